//! Everything around the firmware of a stepper module: driver chip, motor, load, encoder, switches, supply, heat.
//!
//! In each control period the chip turns what the firmware commands into voltages across the coils, which are held for the
//! period while the motor's equations are integrated in one step; then the supply, the sensors and, every 100 ms, the
//! temperatures follow.

mod build;
mod settings;

use driver_chips::tmc262::{Coils, CoolStep, Registers, Tmc262};
use module_firmware::tmcm_1311::{Drive, DriverStatus, Sensed};
use motor_physics::encoder::Encoder;
use motor_physics::switch::LimitSwitch;

use crate::TICK_NS;
use crate::bench_parts::{PERIOD_S, rounded};
use crate::hardware::{Hardware, Physical};
use crate::pulse_source::PulseSource;
use crate::stepper_stage::StepperStage;

/// The hardware of a TMCM-1311.
#[derive(Clone, Debug)]
pub struct StepperBench {
    chip: Tmc262,
    stage: StepperStage,
    encoder: Encoder,
    encoder_has_index: bool,
    /// Left, right, home; where there are any.
    switches: [Option<LimitSwitch>; 3],
    pulses: PulseSource,
    surroundings: SurroundingsState,
    sensed: Sensed,
    /// The current vector that the firmware commands.
    coils: [i16; 2],
}

/// What is set from outside and stays until it is set again.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SurroundingsState {
    /// ENABLE of the step/direction connector.
    enabled: bool,
    /// IN_0 to IN_7.
    inputs: u8,
    /// AIN_0 and AIN_4.
    analog_inputs: [u16; 2],
}

impl Hardware for StepperBench {
    type Sensed = Sensed;
    type Drive = Drive;

    fn sensed(&self) -> Sensed {
        self.sensed
    }

    fn advance(&mut self, drive: &Drive, until_ns: u64) -> bool {
        // The rest is not looked at while the motor moves: it cannot rest before that does.
        let before = (!self.stage.moved).then_some((self.chip, self.stage.supply, self.sensed));
        let terminals = self.chip.advance(&registers(drive), &self.stage.pins(), PERIOD_S);
        self.stage.advance(terminals, until_ns);
        self.coils = drive.coils;
        self.pulses.advance();
        self.sense();
        // Pulses are events: the next period has others, even if as many.
        let pulsed = self.sensed.steps != 0;
        self.stage.moved || pulsed || before != Some((self.chip, self.stage.supply, self.sensed))
    }

    fn rest(&mut self, periods: u64, until_ns: u64) {
        self.stage.rest(periods, until_ns);
        self.pulses.rest(periods);
    }

    fn next_change_ns(&self) -> u64 {
        let time_ns = self.stage.time_ns;
        let switches = self.switches.iter().flatten();
        let unsettled = switches.map(LimitSwitch::settled_at_ns).any(|settled_ns| settled_ns > time_ns);
        let Some(change_ns) = self.stage.next_change_ns().filter(|_| !unsettled) else {
            return time_ns + TICK_NS;
        };
        let pulse_ns = self.pulses.periods_to_pulse().saturating_mul(TICK_NS).saturating_add(time_ns);
        pulse_ns.min(change_ns)
    }

    fn physical(&self) -> Physical {
        self.stage.physical(self.coils)
    }
}

impl StepperBench {
    /// What the firmware will be told next.
    fn sense(&mut self) {
        let turns = self.stage.motor.turns();
        let [left_open, right_open, home_open] = self
            .switches
            .each_mut()
            .map(|switch| switch.as_mut().is_some_and(|switch| !switch.sample(turns, self.stage.time_ns)));
        let sample = self.encoder.sample(turns);
        // The home switch pulls IN_1 down while it is closed; where there is none, the input is what it is set to.
        let inputs = match &self.switches {
            [_, _, Some(_)] => (self.surroundings.inputs & !2) | (u8::from(home_open) << 1),
            _ => self.surroundings.inputs,
        };
        self.sensed = Sensed {
            encoder_counts: sample.counts,
            encoder_index: sample.index_passed,
            inputs,
            left_switch_open: left_open,
            right_switch_open: right_open,
            steps: self.pulses.steps(),
            enabled: self.surroundings.enabled,
            analog_inputs: self.surroundings.analog_inputs,
            coil_currents_ma: self.stage.motor.currents_a.map(|current_a| rounded(current_a * 1000.0)),
            supply_voltage_dv: rounded(self.stage.supply.bus_voltage_v() * 10.0).max(0).cast_unsigned(),
            supply_current_ma: rounded(self.stage.supply.source_current_a() * 1000.0).max(0).cast_unsigned(),
            temperature_c: rounded(self.stage.board_temperature_c()),
            driver: self.driver_status(),
        };
    }

    fn driver_status(&self) -> DriverStatus {
        let status = self.chip.status();
        let [short_a, short_b] = status.short_to_ground;
        let [open_a, open_b] = status.open_load;
        let bits = [
            status.stall,
            status.over_temperature,
            status.over_temperature_warning,
            short_a,
            short_b,
            open_a,
            open_b,
            status.standstill,
        ];
        DriverStatus {
            stallguard: status.stallguard_value,
            current_scale: status.current_scale,
            flags: bits.into_iter().rev().fold(0, |flags, bit| (flags << 1) | u8::from(bit)),
        }
    }
}

fn registers(drive: &Drive) -> Registers {
    let chip = &drive.chip;
    Registers {
        coils: Coils::Direct(drive.coils),
        current_scale: chip.current_scale,
        half_scale: chip.half_scale,
        off_time: chip.off_time,
        stallguard_threshold: chip.stallguard_threshold,
        stallguard_filter: chip.stallguard_filter,
        coolstep: CoolStep {
            lower_threshold: chip.cool_step.semin,
            hysteresis: chip.cool_step.semax,
            up_step: chip.cool_step.seup,
            down_step: chip.cool_step.sedn,
            quarter_minimum: chip.cool_step.quarter_minimum,
        },
        short_protection_disabled: chip.short_protection_disabled,
    }
}
