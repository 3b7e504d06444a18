//! A step, cut where something begins or ends.
//!
//! The equations are smooth but for diodes that begin or cease to conduct, a shaft that stops, sticks or starts, and ends of
//! travel. Put off to the end of a step of 50 µs, such an event would cost amperes. So the step ends at the event, and what is
//! left of it is another.

use super::bridge::Connection;
use super::{Bridge, Outside, Pmsm, State, shaft};
use crate::angle::Direction;
use crate::rk4;

/// Parts of a step at most; what is left then is integrated in one go.
const MAX_PARTS: usize = 32;
/// Halvings of a step to find an event: to a nanosecond in 50 µs.
const BISECTIONS: usize = 16;

/// What stays the same between two events.
#[derive(Clone, Copy)]
struct Regime {
    connection: Connection,
    outside: Outside,
}

impl Pmsm {
    /// The state after `dt_s`.
    pub(super) fn stepped(&mut self, start: State, bridge: Bridge, load_torque_nm: f64, dt_s: f64) -> State {
        let longest_s = match bridge {
            // A rectifier's pulse may begin and end within a step.
            Bridge::Floating { bus_voltage_v } if self.line_to_line_emf_v() > bus_voltage_v => 0.25 * dt_s,
            _ => dt_s,
        };
        let (mut state, mut left_s) = (start, dt_s);
        for _ in 0..MAX_PARTS {
            let (begin, regime) = self.begun(state, bridge, load_torque_nm);
            let part_s = left_s.min(longest_s);
            let reached = self.integrated(begin, regime, part_s);
            let taken_s = if self.stays(reached, bridge, regime) {
                state = reached;
                part_s
            } else {
                let event_s = self.event(begin, bridge, regime, part_s);
                state = self.ended(self.integrated(begin, regime, event_s), regime);
                event_s
            };
            left_s -= taken_s;
            if left_s <= 0.0 {
                return state;
            }
        }
        let (begin, regime) = self.begun(state, bridge, load_torque_nm);
        self.ended(self.integrated(begin, regime, left_s), regime)
    }

    /// When the regime ends, given that it does within `left_s`.
    fn event(&self, state: State, bridge: Bridge, regime: Regime, left_s: f64) -> f64 {
        let (mut before_s, mut after_s) = (0.0, left_s);
        for _ in 0..BISECTIONS {
            let middle_s = 0.5 * (before_s + after_s);
            if self.stays(self.integrated(state, regime, middle_s), bridge, regime) {
                before_s = middle_s;
            } else {
                after_s = middle_s;
            }
        }
        after_s
    }

    /// What holds from this state on.
    fn begun(&mut self, state: State, bridge: Bridge, load_torque_nm: f64) -> (State, Regime) {
        let (state, connection) = match bridge {
            Bridge::Driven { voltage_alpha_beta_v } => {
                self.rails = [0; 3];
                (state, Connection::Closed(voltage_alpha_beta_v))
            }
            Bridge::Floating { bus_voltage_v } => self.switch_diodes(state, bus_voltage_v),
        };
        let [d, q, velocity, angle, ..] = state;
        let torque_nm = self.parameters.torque_nm(d, q) + load_torque_nm;
        let friction = shaft::friction(&self.mechanics, self.turns_at(angle), velocity, torque_nm);
        (state, Regime { connection, outside: Outside { load_torque_nm, friction } })
    }

    /// Whether it still holds in this state.
    fn stays(&self, state: State, bridge: Bridge, Regime { outside, .. }: Regime) -> bool {
        let [d, q, velocity, angle, ..] = state;
        let torque_nm = self.parameters.torque_nm(d, q) + outside.load_torque_nm;
        let turns = self.turns_at(angle);
        shaft::stays(&self.mechanics, outside.friction, turns, velocity, torque_nm)
            && match bridge {
                Bridge::Driven { .. } => true,
                Bridge::Floating { bus_voltage_v } => self.diodes_stay(state, bus_voltage_v),
            }
    }

    /// The state at which it ended: at standstill, or at an end of travel, where that was the reason.
    fn ended(&self, state: State, Regime { outside, .. }: Regime) -> State {
        let [d, q, velocity, angle, electrical, copper, friction, load] = state;
        let turns = self.turns_at(angle);
        let (allowed_turns, allowed) = shaft::stopped(&self.mechanics, outside.friction, turns, velocity);
        let allowed_angle =
            angle + (allowed_turns - turns) * self.parameters.pole_pairs * core::f64::consts::TAU;
        let swallowed_j = self.mechanics.kinetic_j(velocity) - self.mechanics.kinetic_j(allowed);
        [d, q, allowed, allowed_angle, electrical, copper, friction + swallowed_j, load]
    }

    /// Where the shaft is once the electrical angle has gone on to this.
    fn turns_at(&self, electrical_rad: f64) -> f64 {
        self.angle.advanced_to(electrical_rad).turns(self.parameters.pole_pairs)
    }

    fn integrated(&self, start: State, Regime { connection, outside }: Regime, dt_s: f64) -> State {
        let [_, _, _, start_rad, ..] = start;
        let direction = Direction::of(start_rad);
        rk4::step(start, dt_s, |state| {
            let [_, _, _, angle_rad, ..] = state;
            self.derivative(state, direction.turned(angle_rad - start_rad), connection, outside)
        })
    }
}
