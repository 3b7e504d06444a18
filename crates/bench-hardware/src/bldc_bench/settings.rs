//! What can be changed about the surroundings of a module for brushless motors while it runs.

use driver_chips::tmc603::{Phase as ChipPhase, Tmc603};
use motor_physics::load::LoadTorque;

use super::BldcBench;
use super::build::BOARD;
use crate::Surroundings;
use crate::bench_parts::{encoder_fault, restarted, stick, with_level};
use crate::{HallSensor, Phase, Power, Setting, SwitchName};

impl Surroundings for BldcBench {
    fn apply(&mut self, setting: Setting) {
        let state = &mut self.surroundings;
        match setting {
            Setting::LoadTorqueNm(torque_nm) => self.load = LoadTorque::Constant(torque_nm),
            Setting::LoadInertiaKgm2(inertia_kgm2) => {
                self.motor.mechanics.inertia_kgm2 = self.motor.parameters.rotor_inertia_kgm2 + inertia_kgm2;
            }
            Setting::LoadFrictionNm(friction_nm) => self.motor.mechanics.friction_nm = friction_nm,
            Setting::Input { number, high } => state.inputs = with_level(state.inputs, number, high),
            Setting::AnalogInput { number: 0, reading } => state.analog_input = reading,
            Setting::SupplyVoltageV(voltage_v) => self.supply.parameters.voltage_v = voltage_v,
            Setting::AmbientC(ambient_c) => state.ambient_c = ambient_c,
            Setting::EncoderLine(line) => self.encoder.fault = encoder_fault(line, self.encoder_has_index),
            Setting::PhaseOpen(phase) => state.open_phase = phase.map(chip_phase),
            Setting::PhaseShort(phase) => state.shorted_phase = phase.map(chip_phase),
            Setting::HallLine { sensor, stuck } => self.stick_hall(sensor, stuck),
            Setting::SwitchContact { switch, stuck } => self.stick_switch(switch, stuck),
            Setting::BoardTemperatureC(board_temperature_c) => {
                state.board_temperature_c = board_temperature_c;
            }
            Setting::Power(power) => self.switch(power),
            // It is the module that has the EEPROM.
            Setting::EepromCut(_) => {}
            // There is one analogue input, there are no coils, no full steps, and no step/direction connector.
            Setting::AnalogInput { .. }
            | Setting::CoilOpen(_)
            | Setting::CoilShort(_)
            | Setting::DroppedSteps(_)
            | Setting::StepFrequencyHz(_)
            | Setting::StepAccelerationHzPerS(_)
            | Setting::StepPulses(_)
            | Setting::StepEnable(_)
            | Setting::StepLevel(_)
            | Setting::DirLevel(_) => {}
        }
        // What changed may show at once, even if nothing moves; an index that the firmware has not seen yet stays.
        self.read_ntc();
        let index_pending = self.sensed.encoder_index;
        self.sense();
        self.sensed.encoder_index |= index_pending;
    }

    fn encoder_counts(&self) -> i32 {
        self.sensed.encoder_counts
    }

    fn step_pulses(&self) -> i64 {
        0
    }
}

impl BldcBench {
    /// Without power the chip forgets what it found, and the encoder's counter how far it counted; the rotor keeps its
    /// place.
    fn switch(&mut self, power: Power) {
        self.surroundings.powered = power != Power::Off;
        self.chip = Tmc603::new(BOARD);
        self.encoder = restarted(&self.encoder, self.motor.turns());
    }

    fn stick_hall(&mut self, sensor: HallSensor, level: Option<bool>) {
        let [h1, h2, h3] = &mut self.halls.stuck;
        match sensor {
            HallSensor::H1 => *h1 = level,
            HallSensor::H2 => *h2 = level,
            HallSensor::H3 => *h3 = level,
        }
    }

    fn stick_switch(&mut self, switch: SwitchName, stuck: Option<crate::Contact>) {
        let [left, right] = &mut self.switches;
        match switch {
            SwitchName::Left => stick(left.as_mut(), stuck),
            SwitchName::Right => stick(right.as_mut(), stuck),
            SwitchName::Home => {}
        }
    }
}

fn chip_phase(phase: Phase) -> ChipPhase {
    match phase {
        Phase::U => ChipPhase::U,
        Phase::V => ChipPhase::V,
        Phase::W => ChipPhase::W,
    }
}
