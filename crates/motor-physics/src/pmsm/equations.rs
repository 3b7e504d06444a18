//! The differential equations while nothing begins or ends.

use super::Pmsm;
use super::bridge::Connection;
use super::currents::{CurrentSlopes, Windings};
use super::frame::dot;
use crate::angle::Direction;
use crate::energy::Work;
use crate::mechanics::Friction;
use crate::rk4;

/// (id, iq, ω) and the electrical angle from where it was at the beginning of the step.
pub(super) type State = [f64; 4];

/// What the equations know besides the state.
#[derive(Clone, Copy)]
pub(super) struct Equations {
    /// Where the rotor is at the beginning of the step.
    start: Direction,
    connection: Connection,
    pub(super) friction: Friction,
    windings: Windings,
    /// Torque per ampere across the magnets, and what saliency adds per ampere along them.
    torque_constant: f64,
    reluctance_constant: f64,
    per_inertia: f64,
    pub(super) load_torque_nm: f64,
    viscous_nm_s_per_rad: f64,
}

impl Equations {
    /// Those of a motor of which it is not yet known how it is connected and what brakes its shaft.
    pub(super) fn new(motor: &Pmsm, load_torque_nm: f64) -> Self {
        let parameters = &motor.parameters;
        Self {
            start: motor.direction,
            connection: Connection::Open,
            friction: Friction::Sticks,
            windings: Windings::of(parameters),
            torque_constant: parameters.torque_nm(0.0, 1.0),
            reluctance_constant: 1.5
                * parameters.pole_pairs
                * (parameters.d_inductance_h - parameters.q_inductance_h),
            per_inertia: 1.0 / motor.mechanics.inertia_kgm2,
            load_torque_nm,
            viscous_nm_s_per_rad: motor.mechanics.viscous_nm_s_per_rad,
        }
    }

    /// The same with this connection and this friction.
    pub(super) fn with(self, connection: Connection, friction: Friction) -> Self {
        Self { connection, friction, ..self }
    }

    /// The direction of the d axis in a state.
    #[inline]
    pub(super) fn rotor(&self, [_, _, _, turned_rad]: State) -> Direction {
        self.start.turned(turned_rad)
    }

    pub(super) fn current_slopes(&self, [d, q, velocity, _]: State) -> CurrentSlopes {
        CurrentSlopes::new(&self.windings, [d, q], velocity)
    }

    /// What drives the shaft against friction in a state.
    #[inline]
    pub(super) fn driving_nm(&self, [d, q, ..]: State) -> f64 {
        (self.torque_constant + self.reluctance_constant * d) * q + self.load_torque_nm
    }

    /// The state after `dt_s` and where the energy went until then.
    ///
    /// The energies depend on nothing but the state, so they are integrated with the weights of the Runge-Kutta step from
    /// the states that it went through: the same as taking them along, at a fraction of the cost.
    pub(super) fn after(&self, first: State, dt_s: f64) -> (State, Work) {
        match self.connection {
            // By far the most steps are of this kind, and all the others would slow it down.
            Connection::Closed(voltage) => self.integrated(first, dt_s, |_, rotor| rotor.to_rotor(voltage)),
            connection => self.integrated(first, dt_s, |slopes, rotor| slopes.voltage(connection, rotor)),
        }
    }

    #[inline(never)] // it is long, and called where a step is cut, too
    fn integrated(
        &self,
        first: State,
        dt_s: f64,
        voltage: impl Fn(&CurrentSlopes, Direction) -> [f64; 2],
    ) -> (State, Work) {
        // A shaft that sticks is one that nothing accelerates.
        let (friction_nm, per_inertia) = match self.friction {
            Friction::Acts(friction_nm) => (friction_nm, self.per_inertia),
            Friction::Sticks => (0.0, 0.0),
        };
        let slopes = |state| self.slopes(state, friction_nm, per_inertia, &voltage);
        let (k1, power1_w) = slopes(first);
        let second = rk4::moved(first, k1, 0.5 * dt_s);
        let (k2, power2_w) = slopes(second);
        let third = rk4::moved(first, k2, 0.5 * dt_s);
        let (k3, power3_w) = slopes(third);
        let fourth = rk4::moved(first, k3, dt_s);
        let (k4, power4_w) = slopes(fourth);
        let last = rk4::moved(first, rk4::mean([k1, k2, k3, k4]), dt_s);
        let [electrical_w] = rk4::mean([[power1_w], [power2_w], [power3_w], [power4_w]]);
        let [squared_a2, velocity, squared_rad2_per_s2] =
            rk4::mean([first, second, third, fourth].map(quantities));
        let friction_w = self.viscous_nm_s_per_rad * squared_rad2_per_s2 - friction_nm * velocity;
        let work = Work {
            electrical_j: electrical_w * dt_s,
            copper_j: 1.5 * self.windings.resistance_ohm * squared_a2 * dt_s,
            friction_j: friction_w * dt_s,
            load_j: -self.load_torque_nm * velocity * dt_s,
        };
        (last, work)
    }

    /// Rates of change of the state, and the power from the power stage.
    #[inline(always)] // four calls of which each would cost half as much again
    fn slopes(
        &self,
        state: State,
        friction_nm: f64,
        per_inertia: f64,
        voltage: impl Fn(&CurrentSlopes, Direction) -> [f64; 2],
    ) -> (State, f64) {
        let [d, q, velocity, _] = state;
        let slopes = CurrentSlopes::new(&self.windings, [d, q], velocity);
        let voltage = voltage(&slopes, self.rotor(state));
        let [slope_d, slope_q] = slopes.under(voltage);
        let held_nm = friction_nm - self.viscous_nm_s_per_rad * velocity;
        let rates = [
            slope_d,
            slope_q,
            (self.driving_nm(state) + held_nm) * per_inertia,
            self.windings.pole_pairs * velocity,
        ];
        (rates, 1.5 * dot(voltage, [d, q]))
    }
}

/// What the powers depend on: the square of the current vector, the velocity, and its square.
fn quantities([d, q, velocity, _]: State) -> [f64; 3] {
    [d * d + q * q, velocity, velocity * velocity]
}
