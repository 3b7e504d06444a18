//! What can be changed about a stepper module's surroundings while it runs.

use driver_chips::tmc262::Tmc262;
use motor_physics::load::LoadTorque;

use super::StepperBench;
use super::build::BOARD;
use crate::Surroundings;
use crate::bench_parts::{encoder_fault, restarted, stick, with_level};
use crate::{Power, Setting, SwitchName};

/// Full steps in an electrical period.
const FULL_STEPS: f64 = 4.0;

impl Surroundings for StepperBench {
    fn apply(&mut self, setting: Setting) {
        let state = &mut self.surroundings;
        match setting {
            Setting::LoadTorqueNm(torque_nm) => self.load = LoadTorque::Constant(torque_nm),
            Setting::LoadInertiaKgm2(inertia_kgm2) => {
                self.motor.mechanics.inertia_kgm2 = self.motor.parameters().rotor_inertia_kgm2 + inertia_kgm2;
            }
            Setting::LoadFrictionNm(friction_nm) => self.motor.mechanics.friction_nm = friction_nm,
            Setting::Input { number, high } => {
                state.inputs = with_level(state.inputs, number, high);
            }
            Setting::AnalogInput { number, reading } => {
                let [ain_0, ain_4] = &mut state.analog_inputs;
                match number {
                    0 => *ain_0 = reading,
                    4 => *ain_4 = reading,
                    _ => {}
                }
            }
            Setting::SupplyVoltageV(voltage_v) => self.supply.parameters.voltage_v = voltage_v,
            Setting::AmbientC(ambient_c) => state.ambient_c = ambient_c,
            Setting::EncoderLine(line) => self.encoder.fault = encoder_fault(line, self.encoder_has_index),
            Setting::CoilOpen(coil) => state.open_coil = coil,
            Setting::CoilShort(coil) => state.shorted_coil = coil,
            Setting::SwitchContact { switch, stuck } => {
                let [left, right, home] = &mut self.switches;
                let switch = match switch {
                    SwitchName::Left => left,
                    SwitchName::Right => right,
                    SwitchName::Home => home,
                };
                stick(switch.as_mut(), stuck);
            }
            Setting::BoardTemperatureC(board_temperature_c) => {
                state.board_temperature_c = board_temperature_c;
            }
            Setting::DroppedSteps(full_steps) => self.motor.slip(f64::from(full_steps) / FULL_STEPS),
            Setting::StepFrequencyHz(frequency_hz) => self.pulses.set_frequency(frequency_hz),
            Setting::StepPulses(pulses) => self.pulses.set_pulses(pulses),
            Setting::StepEnable(enabled) => state.enabled = enabled,
            Setting::Power(power) => self.switch(power),
            // A stepper has neither phases U, V, W nor hall sensors.
            Setting::PhaseOpen(_) | Setting::PhaseShort(_) | Setting::HallLine { .. } => {}
        }
        // What changed may show at once, even if nothing moves; an index that the firmware has not seen yet stays.
        let index_pending = self.sensed.encoder_index;
        self.sense();
        self.sensed.encoder_index |= index_pending;
    }

    fn encoder_counts(&self) -> i32 {
        self.sensed.encoder_counts
    }

    fn step_pulses(&self) -> i64 {
        self.pulses.total()
    }
}

impl StepperBench {
    /// Without power the chip forgets what it found, and the encoder's counter how far it counted; the rotor keeps its
    /// place.
    fn switch(&mut self, power: Power) {
        self.surroundings.powered = power != Power::Off;
        self.chip = Tmc262::new(BOARD);
        self.pulses.forget_steps();
        self.encoder = restarted(&self.encoder, self.motor.turns());
    }
}
