//! Everything around the firmware of a module for brushless motors: power stage, motor, load, encoder, hall sensors,
//! switches, supply, heat.
//!
//! In each control period the bridge turns the duties that the firmware commands into a voltage vector, which is held for the
//! period while the motor's equations are integrated; then the supply, the sensors and, every 100 ms, the temperatures follow.

mod build;
mod settings;
#[cfg(test)]
mod tests;

use core::f64::consts::TAU;

use driver_chips::tmc603::{Gates, Phase, Pins, Tmc603, ntc_reading};
use module_firmware::tmcm_1640::{Drive, Sensed};
use motor_physics::encoder::Encoder;
use motor_physics::hall::HallSensors;
use motor_physics::heat::HeatedBody;
use motor_physics::load::LoadTorque;
use motor_physics::pmsm::Pmsm;
use motor_physics::supply::Supply;
use motor_physics::switch::LimitSwitch;

use crate::TICK_NS;
use crate::bench_parts::{BOARD_W, HEAT_NS, PERIOD_S, rounded, seconds, with_level};
use crate::hardware::{Hardware, Physical};

/// Currents that make no angle worth telling.
const NO_CURRENT_A: f64 = 1e-3;

/// The hardware of a TMCM-1640.
#[derive(Clone, Debug)]
pub struct BldcBench {
    chip: Tmc603,
    motor: Pmsm,
    load: LoadTorque,
    encoder: Encoder,
    encoder_has_index: bool,
    halls: HallSensors,
    /// Left, right; where there are any.
    switches: [Option<LimitSwitch>; 2],
    supply: Supply,
    winding: HeatedBody,
    board: HeatedBody,
    surroundings: SurroundingsState,
    time_ns: u64,
    /// The heat of the windings, counted from power-on, when the temperatures were last brought up to date.
    heat_from_pj: i64,
    /// What the converter reads at the NTC since the temperature last changed.
    driver_temperature_adc: u16,
    sensed: Sensed,
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
    open_phase: Option<Phase>,
    shorted_phase: Option<Phase>,
    /// IN_0 and IN_1, where no switch drives them.
    inputs: u8,
    /// AIN.
    analog_input: u16,
}

impl Hardware for BldcBench {
    type Sensed = Sensed;
    type Drive = Drive;

    fn sensed(&self) -> Sensed {
        self.sensed
    }

    fn advance(&mut self, drive: &Drive, until_ns: u64) -> bool {
        // The rest is not looked at while the motor moves: it cannot rest before that does.
        let before = (!self.moved).then_some((self.chip, self.supply, self.sensed));
        let gates = Gates { duties: drive.duties, enabled: drive.enabled };
        let bridge = self.chip.advance(&gates, &self.pins());
        self.load_nm = self.load.at(self.motor.turns(), seconds(self.time_ns));
        self.moved = self.motor.advance(bridge, self.load_nm, PERIOD_S);
        self.supply.advance(self.consumed_w(), PERIOD_S);
        self.time_ns = until_ns;
        self.warm();
        self.sense();
        self.moved || before != Some((self.chip, self.supply, self.sensed))
    }

    fn rest(&mut self, periods: u64, until_ns: u64) {
        self.motor.rest(periods);
        self.time_ns = until_ns;
    }

    fn next_change_ns(&self) -> u64 {
        let switches = self.switches.iter().flatten();
        let unsettled = switches.map(LimitSwitch::settled_at_ns).any(|settled_ns| settled_ns > self.time_ns);
        if unsettled || self.load.changes_with_time() {
            return self.time_ns + TICK_NS;
        }
        (self.time_ns / HEAT_NS + 1) * HEAT_NS
    }

    fn physical(&self) -> Physical {
        let Pmsm { current_d_a, current_q_a, torque_nm, velocity_rad_s, .. } = self.motor;
        let [phase_u_a, phase_v_a, phase_w_a] = self.motor.phase_currents_a();
        Physical {
            rotor_turns: self.motor.turns(),
            velocity_rpm: velocity_rad_s * 60.0 / TAU,
            torque_nm,
            load_nm: self.load_nm,
            load_angle_deg: self.load_angle_deg(),
            bus_voltage_v: self.supply.bus_voltage_v(),
            supply_current_a: self.supply.source_current_a(),
            winding_temperature_c: self.winding.temperature_c(self.surroundings.ambient_c),
            board_temperature_c: self.board_temperature_c(),
            current_d_a,
            current_q_a,
            phase_u_a,
            phase_v_a,
            phase_w_a,
            ..Physical::default()
        }
    }
}

impl BldcBench {
    fn pins(&self) -> Pins {
        Pins {
            phase_currents_a: self.motor.phase_currents_a(),
            bus_voltage_v: self.supply.bus_voltage_v(),
            open_phase: self.surroundings.open_phase,
            shorted_phase: self.surroundings.shorted_phase,
        }
    }

    /// What board, bridge and motor take; negative when they feed back.
    fn consumed_w(&self) -> f64 {
        let bridge_w = self.bridge_loss_w(self.motor.copper_power_w(PERIOD_S));
        self.board_w() + bridge_w + self.motor.electrical_power_w(PERIOD_S)
    }

    /// Heat in the bridge while the windings make this much.
    fn bridge_loss_w(&self, copper_w: f64) -> f64 {
        copper_w * self.chip.conduction_loss_per_copper_loss(self.motor.parameters.resistance_ohm)
    }

    /// What the board takes for itself while it is on.
    fn board_w(&self) -> f64 {
        if self.surroundings.powered { BOARD_W } else { 0.0 }
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
        self.board.advance(self.board_w() + self.bridge_loss_w(copper_w), seconds(HEAT_NS));
        self.read_ntc();
    }

    /// Not in every control period: the formula is dear.
    fn read_ntc(&mut self) {
        self.driver_temperature_adc = ntc_reading(self.board_temperature_c());
    }

    /// The angle of the current vector from the rotor's d axis; 0 without current.
    fn load_angle_deg(&self) -> f64 {
        let Pmsm { current_d_a, current_q_a, .. } = self.motor;
        if libm::hypot(current_d_a, current_q_a) < NO_CURRENT_A {
            return 0.0;
        }
        libm::atan2(current_q_a, current_d_a).to_degrees()
    }

    fn board_temperature_c(&self) -> f64 {
        let state = &self.surroundings;
        state.board_temperature_c.unwrap_or_else(|| self.board.temperature_c(state.ambient_c))
    }

    /// What the firmware will be told next.
    fn sense(&mut self) {
        let turns = self.motor.turns();
        let sample = self.encoder.sample(turns);
        self.sensed = Sensed {
            phase_currents_ma: self.motor.phase_currents_a().map(|current_a| rounded(current_a * 1000.0)),
            halls: self.halls.bits(self.motor.angle().electrical_rad()),
            encoder_counts: sample.counts,
            encoder_index: sample.index_passed,
            supply_voltage_dv: rounded(self.supply.bus_voltage_v() * 10.0).max(0).cast_unsigned(),
            driver_temperature_adc: self.driver_temperature_adc,
            driver_error: self.chip.error(),
            inputs: self.inputs(turns),
            analog_input: self.surroundings.analog_input,
        };
    }

    /// A switch's contact pulls its input down while it is closed; where there is no switch, the input is what it is set to.
    fn inputs(&mut self, turns: f64) -> u8 {
        let [left, right] = &mut self.switches;
        [(1, left), (0, right)].into_iter().fold(self.surroundings.inputs, |inputs, (number, switch)| {
            match switch {
                Some(switch) => with_level(inputs, number, !switch.sample(turns, self.time_ns)),
                None => inputs,
            }
        })
    }
}
