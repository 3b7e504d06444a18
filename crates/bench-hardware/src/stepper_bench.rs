//! Everything around the firmware of a stepper module: driver chip, motor, load, encoder, switches, supply, heat.
//!
//! In each control period the chip turns what the firmware commands into voltages across the coils, which are held for the
//! period while the motor's equations are integrated in one step; then the supply, the sensors and, every 100 ms, the
//! temperatures follow.

mod build;
mod pulse_source;
mod settings;

use core::f64::consts::TAU;

use driver_chips::tmc262::{CoilFault, Coils, CoolStep, Pins, Registers, Tmc262};
use module_firmware::tmcm_1311::{Drive, DriverStatus, Sensed};
use motor_physics::Terminal;
use motor_physics::encoder::Encoder;
use motor_physics::heat::HeatedBody;
use motor_physics::load::LoadTorque;
use motor_physics::stepper::Stepper;
use motor_physics::supply::Supply;
use motor_physics::switch::LimitSwitch;

use pulse_source::PulseSource;

use crate::Coil;
use crate::TICK_NS;
use crate::bench_parts::{BOARD_W, HEAT_NS, PERIOD_S, rounded, seconds};
use crate::hardware::{Hardware, Physical};

/// On-resistance of the two transistors in series with a coil (chosen: two of 50 mΩ).
const BRIDGE_OHM: f64 = 0.1;

/// The hardware of a TMCM-1311.
#[derive(Clone, Debug)]
pub struct StepperBench {
    chip: Tmc262,
    motor: Stepper,
    load: LoadTorque,
    encoder: Encoder,
    encoder_has_index: bool,
    /// Left, right, home; where there are any.
    switches: [Option<LimitSwitch>; 3],
    pulses: PulseSource,
    supply: Supply,
    winding: HeatedBody,
    board: HeatedBody,
    surroundings: SurroundingsState,
    time_ns: u64,
    /// The heat of the windings, counted from power-on, when the temperatures were last brought up to date.
    heat_from_pj: i64,
    sensed: Sensed,
    /// The current vector that the firmware commands.
    coils: [i16; 2],
    load_nm: f64,
    /// Whether the motor moved in the last control period, or its currents changed.
    moved: bool,
}

/// What is set from outside and stays until it is set again.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SurroundingsState {
    powered: bool,
    ambient_c: f64,
    board_temperature_c: Option<f64>,
    open_coil: Option<Coil>,
    shorted_coil: Option<Coil>,
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
        let before = (!self.moved).then_some((self.chip, self.supply, self.sensed));
        let terminals = self.chip.advance(&registers(drive), &self.pins(), PERIOD_S);
        let terminals = self.interrupted(terminals);
        self.load_nm = self.load.at(self.motor.turns(), seconds(self.time_ns));
        self.moved = self.motor.advance(terminals, self.load_nm, PERIOD_S);
        self.supply.advance(self.board_w() + self.motor.electrical_power_w(PERIOD_S), PERIOD_S);
        self.coils = drive.coils;
        self.time_ns = until_ns;
        self.warm();
        self.pulses.advance();
        self.sense();
        // Pulses are events: the next period has others, even if as many.
        let pulsed = self.sensed.steps != 0;
        self.moved || pulsed || before != Some((self.chip, self.supply, self.sensed))
    }

    fn rest(&mut self, periods: u64, until_ns: u64) {
        self.motor.rest(periods);
        self.pulses.rest(periods);
        self.time_ns = until_ns;
    }

    fn next_change_ns(&self) -> u64 {
        let switches = self.switches.iter().flatten();
        let unsettled = switches.map(LimitSwitch::settled_at_ns).any(|settled_ns| settled_ns > self.time_ns);
        if unsettled || self.load.changes_with_time() {
            return self.time_ns + TICK_NS;
        }
        let pulse_ns = self.pulses.periods_to_pulse().saturating_mul(TICK_NS).saturating_add(self.time_ns);
        pulse_ns.min((self.time_ns / HEAT_NS + 1) * HEAT_NS)
    }

    fn physical(&self) -> Physical {
        let [coil_a_a, coil_b_a] = self.motor.currents_a;
        Physical {
            rotor_turns: self.motor.turns(),
            velocity_rpm: self.motor.velocity_rad_s * 60.0 / TAU,
            torque_nm: self.motor.torque_nm,
            load_nm: self.load_nm,
            load_angle_deg: self.load_angle_deg(),
            coil_a_a,
            coil_b_a,
            bus_voltage_v: self.supply.bus_voltage_v(),
            supply_current_a: self.supply.source_current_a(),
            winding_temperature_c: self.winding.temperature_c(self.surroundings.ambient_c),
            board_temperature_c: self.board_temperature_c(),
            ..Physical::default()
        }
    }
}

impl StepperBench {
    fn pins(&self) -> Pins {
        let parameters = self.motor.parameters();
        Pins {
            currents_a: self.motor.currents_a,
            back_emf_v: self.motor.back_emf_v(),
            rotor_velocity_rps: self.motor.velocity_rad_s / TAU,
            bus_voltage_v: self.supply.bus_voltage_v(),
            resistance_ohm: parameters.resistance_ohm,
            inductance_h: parameters.inductance_h,
            temperature_c: self.board_temperature_c(),
            coil_faults: [self.coil_fault(Coil::A), self.coil_fault(Coil::B)],
        }
    }

    /// A coil whose wire is off is driven by nothing, whatever the chip does.
    fn interrupted(&self, terminals: [Terminal; 2]) -> [Terminal; 2] {
        let [a, b] = terminals;
        let bus_voltage_v = self.supply.bus_voltage_v();
        let through = |coil, terminal| match self.coil_fault(coil) {
            CoilFault::Open => Terminal::Floating { bus_voltage_v },
            CoilFault::None | CoilFault::ShortToGround => terminal,
        };
        [through(Coil::A, a), through(Coil::B, b)]
    }

    /// A coil that is both open and shorted carries nothing: it is open.
    fn coil_fault(&self, coil: Coil) -> CoilFault {
        if self.surroundings.open_coil == Some(coil) {
            CoilFault::Open
        } else if self.surroundings.shorted_coil == Some(coil) {
            CoilFault::ShortToGround
        } else {
            CoilFault::None
        }
    }

    /// Brings the temperatures up to date where it is time to.
    fn warm(&mut self) {
        if !self.time_ns.is_multiple_of(HEAT_NS) {
            return;
        }
        let copper_pj = self.motor.energy.copper_pj;
        let copper_w = motor_physics::energy::joules(copper_pj - self.heat_from_pj) / seconds(HEAT_NS);
        self.heat_from_pj = copper_pj;
        self.winding.advance(copper_w, seconds(HEAT_NS));
        let bridge_w = copper_w * BRIDGE_OHM / self.motor.parameters().resistance_ohm;
        self.board.advance(self.board_w() + bridge_w, seconds(HEAT_NS));
    }

    /// What the board takes for itself while it is on.
    fn board_w(&self) -> f64 {
        if self.surroundings.powered { BOARD_W } else { 0.0 }
    }

    /// How far the rotor lags behind the commanded current vector; 0 when there is none.
    fn load_angle_deg(&self) -> f64 {
        match self.coils.map(f64::from) {
            [0.0, 0.0] => 0.0,
            [a, b] => wrapped(libm::atan2(b, a) - self.motor.angle().electrical_rad()).to_degrees(),
        }
    }

    fn board_temperature_c(&self) -> f64 {
        let state = &self.surroundings;
        state.board_temperature_c.unwrap_or_else(|| self.board.temperature_c(state.ambient_c))
    }

    /// What the firmware will be told next.
    fn sense(&mut self) {
        let turns = self.motor.turns();
        let [left_open, right_open, home_open] = self
            .switches
            .each_mut()
            .map(|switch| switch.as_mut().is_some_and(|switch| !switch.sample(turns, self.time_ns)));
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
            coil_currents_ma: self.motor.currents_a.map(|current_a| rounded(current_a * 1000.0)),
            supply_voltage_dv: rounded(self.supply.bus_voltage_v() * 10.0).max(0).cast_unsigned(),
            supply_current_ma: rounded(self.supply.source_current_a() * 1000.0).max(0).cast_unsigned(),
            temperature_c: rounded(self.board_temperature_c()),
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

/// An angle brought back to −π to π.
fn wrapped(angle_rad: f64) -> f64 {
    angle_rad - libm::round(angle_rad / TAU) * TAU
}
