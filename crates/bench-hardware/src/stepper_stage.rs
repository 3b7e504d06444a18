//! What is behind the driver chip of every stepper module: motor, load, supply, heat, and what can break between them.

use core::f64::consts::TAU;

use driver_chips::stepper::{CoilFault, Pins};
use motor_physics::Terminal;
use motor_physics::heat::{HeatParameters, HeatedBody};
use motor_physics::load::LoadTorque;
use motor_physics::stepper::{Stepper, StepperParameters};
use motor_physics::supply::Supply;

use crate::bench_parts::{BOARD_W, HEAT_NS, PERIOD_S, seconds};
use crate::hardware::Physical;
use crate::parts::CommonParts;
use crate::{Coil, Power, Setting};

/// On-resistance of the two transistors in series with a coil (chosen: two of 50 mΩ).
const BRIDGE_OHM: f64 = 0.1;

/// Full steps in an electrical period.
const FULL_STEPS: f64 = 4.0;

/// Power stage, motor and load.
#[derive(Clone, Debug)]
pub struct StepperStage {
    /// The motor and its shaft.
    pub motor: Stepper,
    load: LoadTorque,
    /// What it runs on.
    pub supply: Supply,
    winding: HeatedBody,
    board: HeatedBody,
    powered: bool,
    ambient_c: f64,
    board_temperature_c: Option<f64>,
    open_coil: Option<Coil>,
    shorted_coil: Option<Coil>,
    /// Virtual time.
    pub time_ns: u64,
    /// The heat of the windings, counted from power-on, when the temperatures were last brought up to date.
    heat_from_pj: i64,
    load_nm: f64,
    /// Whether the motor moved in the last control period, or its currents changed.
    pub moved: bool,
}

impl StepperStage {
    /// Everything at rest, the shaft at 0.
    #[must_use]
    pub fn new(common: &CommonParts, motor: StepperParameters) -> Self {
        Self {
            motor: Stepper::new(motor, common.mechanics),
            load: common.load.clone(),
            supply: Supply::new(common.supply),
            winding: HeatedBody::new(HeatParameters::stepper_winding(&motor)),
            board: HeatedBody::new(HeatParameters::board()),
            powered: true,
            ambient_c: common.ambient_c,
            board_temperature_c: None,
            open_coil: None,
            shorted_coil: None,
            time_ns: 0,
            heat_from_pj: 0,
            load_nm: 0.0,
            moved: false,
        }
    }

    /// What the chip sees.
    pub fn pins(&self) -> Pins {
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

    /// Holds the terminals for the control period that ends at `until_ns`.
    pub fn advance(&mut self, terminals: [Terminal; 2], until_ns: u64) {
        let terminals = self.interrupted(terminals);
        self.load_nm = self.load.at(self.motor.turns(), seconds(self.time_ns));
        self.moved = self.motor.advance(terminals, self.load_nm, PERIOD_S);
        self.supply.advance(self.board_w() + self.motor.electrical_power_w(PERIOD_S), PERIOD_S);
        self.time_ns = until_ns;
        self.warm();
    }

    /// Control periods like the last one, in which nothing changed.
    pub fn rest(&mut self, periods: u64, until_ns: u64) {
        self.motor.rest(periods);
        self.time_ns = until_ns;
    }

    /// The next instant at which something may change by itself; `None`: it may at once.
    pub fn next_change_ns(&self) -> Option<u64> {
        (!self.load.changes_with_time()).then_some((self.time_ns / HEAT_NS + 1) * HEAT_NS)
    }

    /// What really is, with the field where the chip commands it.
    pub fn physical(&self, commanded: [i16; 2]) -> Physical {
        let [coil_a_a, coil_b_a] = self.motor.currents_a;
        Physical {
            rotor_turns: self.motor.turns(),
            velocity_rpm: self.motor.velocity_rad_s * 60.0 / TAU,
            torque_nm: self.motor.torque_nm,
            load_nm: self.load_nm,
            load_angle_deg: self.load_angle_deg(commanded),
            coil_a_a,
            coil_b_a,
            bus_voltage_v: self.supply.bus_voltage_v(),
            supply_current_a: self.supply.source_current_a(),
            winding_temperature_c: self.winding.temperature_c(self.ambient_c),
            board_temperature_c: self.board_temperature_c(),
            ..Physical::default()
        }
    }

    /// The board's temperature.
    pub fn board_temperature_c(&self) -> f64 {
        self.board_temperature_c.unwrap_or_else(|| self.board.temperature_c(self.ambient_c))
    }

    /// Changes something about it; what is not its own comes back.
    pub fn apply(&mut self, setting: Setting) -> Option<Setting> {
        match setting {
            Setting::LoadTorqueNm(torque_nm) => self.load = LoadTorque::Constant(torque_nm),
            Setting::LoadInertiaKgm2(inertia_kgm2) => {
                self.motor.mechanics.inertia_kgm2 = self.motor.parameters().rotor_inertia_kgm2 + inertia_kgm2;
            }
            Setting::LoadFrictionNm(friction_nm) => self.motor.mechanics.friction_nm = friction_nm,
            Setting::SupplyVoltageV(voltage_v) => self.supply.parameters.voltage_v = voltage_v,
            Setting::AmbientC(ambient_c) => self.ambient_c = ambient_c,
            Setting::CoilOpen(coil) => self.open_coil = coil,
            Setting::CoilShort(coil) => self.shorted_coil = coil,
            Setting::BoardTemperatureC(board_temperature_c) => self.board_temperature_c = board_temperature_c,
            Setting::DroppedSteps(full_steps) => self.motor.slip(f64::from(full_steps) / FULL_STEPS),
            other => return Some(other),
        }
        None
    }

    /// The rotor keeps its place.
    pub fn switch(&mut self, power: Power) {
        self.powered = power != Power::Off;
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
        if self.open_coil == Some(coil) {
            CoilFault::Open
        } else if self.shorted_coil == Some(coil) {
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
        if self.powered { BOARD_W } else { 0.0 }
    }

    /// How far the rotor lags behind the commanded current vector; 0 when there is none.
    fn load_angle_deg(&self, commanded: [i16; 2]) -> f64 {
        match commanded.map(f64::from) {
            [0.0, 0.0] => 0.0,
            [a, b] => wrapped(libm::atan2(b, a) - self.motor.angle().electrical_rad()).to_degrees(),
        }
    }
}

/// An angle brought back to −π to π.
fn wrapped(angle_rad: f64) -> f64 {
    angle_rad - libm::round(angle_rad / TAU) * TAU
}
