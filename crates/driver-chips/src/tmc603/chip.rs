//! The bridge, and what switches it off.

use motor_physics::pmsm::Bridge;

/// A PWM period in the unit of [`Gates::duties`].
const PWM_PERIOD: f64 = 32_768.0;

/// Below this supply the gates are not driven any more (datasheet: from 9 V), and again from a little above (chosen).
const UNDERVOLTAGE_V: f64 = 9.0;
const UNDERVOLTAGE_HYSTERESIS_V: f64 = 0.5;

/// What the board makes of the chip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// On-resistance of one transistor. Each phase's current flows through one, the upper or the lower.
    pub on_resistance_ohm: f64,
    /// Current of a phase from which on the voltage across its transistor counts as an overcurrent.
    pub overcurrent_a: f64,
}

/// What the controller tells the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gates {
    /// For how much of the PWM period the upper transistors of U, V and W are on, the lower ones for the rest: 0 to 32 768.
    /// More is the whole period.
    pub duties: [u16; 3],
    /// ENABLE. Without it no transistor is on, and what the chip has found is forgotten.
    pub enabled: bool,
}

/// The chip's surroundings, constant over a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pins {
    /// Currents into phases U, V and W at the start of the period.
    pub phase_currents_a: [f64; 3],
    /// The supply of the bridge.
    pub bus_voltage_v: f64,
    /// A phase whose wire is off.
    pub open_phase: Option<Phase>,
    /// A phase whose terminal touches ground.
    pub shorted_phase: Option<Phase>,
}

/// A phase of the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// U.
    U,
    /// V.
    V,
    /// W.
    W,
}

/// A TMC603 with its bridge.
///
/// With unchanging gates and pins its state is at rest after one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tmc603 {
    board: Board,
    /// A short or an overcurrent was found.
    overloaded: bool,
    undervoltage: bool,
}

impl Tmc603 {
    /// The chip after power-on.
    #[must_use]
    pub fn new(board: Board) -> Self {
        Self { board, overloaded: false, undervoltage: false }
    }

    /// What the bridge does to the motor for the next control period.
    ///
    /// It is off without ENABLE and while there is an error: the board ties the error output to ENABLE (decision), as the
    /// datasheet suggests for a stage that protects itself.
    pub fn advance(&mut self, gates: &Gates, pins: &Pins) -> Bridge {
        self.watch(gates, pins);
        let bus_voltage_v = pins.bus_voltage_v.max(0.0);
        if !gates.enabled || self.error() {
            return Bridge::Floating { bus_voltage_v };
        }
        let mut terminals_v = [0.0; 3];
        for ((terminal_v, duty), current_a) in
            terminals_v.iter_mut().zip(gates.duties).zip(pins.phase_currents_a)
        {
            let part = (f64::from(duty) / PWM_PERIOD).min(1.0);
            *terminal_v = part * bus_voltage_v - self.board.on_resistance_ohm * current_a;
        }
        match pins.open_phase {
            None => Bridge::at_terminals(terminals_v),
            Some(phase) => Bridge::at_terminals(terminals_v).with_open(phase as usize),
        }
    }

    /// ERR_OUT: a short to ground or an overcurrent was found since the stage was last disabled, or there is too little
    /// supply.
    #[must_use]
    pub fn error(&self) -> bool {
        self.overloaded || self.undervoltage
    }

    /// Heat in the bridge for each watt of heat in windings of this phase resistance: the same current flows through both.
    #[must_use]
    pub fn conduction_loss_per_copper_loss(&self, phase_resistance_ohm: f64) -> f64 {
        self.board.on_resistance_ohm / phase_resistance_ohm
    }

    fn watch(&mut self, gates: &Gates, pins: &Pins) {
        let enough_v =
            if self.undervoltage { UNDERVOLTAGE_V + UNDERVOLTAGE_HYSTERESIS_V } else { UNDERVOLTAGE_V };
        self.undervoltage = pins.bus_voltage_v < enough_v;
        if !gates.enabled {
            self.overloaded = false;
        } else if !self.undervoltage {
            self.overloaded |= self.is_overloaded(gates, pins);
        }
    }

    /// A short to ground shows as soon as the upper transistor of its phase is on at all.
    fn is_overloaded(&self, gates: &Gates, pins: &Pins) -> bool {
        let shorted = pins.shorted_phase.and_then(|phase| gates.duties.get(phase as usize));
        let overcurrent = |current_a: f64| libm::fabs(current_a) > self.board.overcurrent_a;
        shorted.is_some_and(|duty| *duty > 0) || pins.phase_currents_a.into_iter().any(overcurrent)
    }
}
