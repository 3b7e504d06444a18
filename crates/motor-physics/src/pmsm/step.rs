//! A step, cut where something begins or ends.
//!
//! The equations are smooth but for diodes that begin or cease to conduct, a shaft that stops, sticks or starts, and ends of
//! travel. Put off to the end of a step of 50 µs, such an event would cost amperes. So the step ends at the event, and what is
//! left of it is another.

use super::bridge::Connection;
use super::equations::{Equations, State};
use super::{Bridge, Pmsm, shaft};
use crate::energy::Work;

/// Parts of a step at most; what is left then is integrated in one go.
const MAX_PARTS: usize = 32;
/// Halvings of a step to find an event: to a nanosecond in 50 µs.
const BISECTIONS: usize = 16;
/// How far the rotor may turn, electrically, in a part of a step: only a load drags it so fast that this matters.
const PART_RAD: f64 = 0.5;

impl Pmsm {
    /// The state after `dt_s`, and where the energy went.
    pub(super) fn stepped(&mut self, bridge: Bridge, load_torque_nm: f64, dt_s: f64) -> (State, Work) {
        let longest_s = self.longest_part_s(bridge, dt_s);
        let unconnected = Equations::new(self, load_torque_nm);
        let mut state = [self.current_d_a, self.current_q_a, self.velocity_rad_s, 0.0];
        let (mut work, mut left_s) = (Work::default(), dt_s);
        for _ in 0..MAX_PARTS {
            let (begin, equations) = self.begun(state, bridge, unconnected);
            let part_s = left_s.min(longest_s);
            let (reached, more) = equations.after(begin, part_s);
            if self.stays(reached, bridge, &equations) {
                (state, work) = (reached, work.plus(more));
                left_s -= part_s;
            } else {
                let event_s = self.event(begin, bridge, &equations, part_s);
                let (ended, more) = self.ended(begin, &equations, event_s);
                (state, work) = (ended, work.plus(more));
                left_s -= event_s;
            }
            if left_s <= 0.0 {
                return (state, work);
            }
        }
        let (begin, equations) = self.begun(state, bridge, unconnected);
        let (state, more) = self.ended(begin, &equations, left_s);
        (state, work.plus(more))
    }

    /// How long a part of a step may be.
    fn longest_part_s(&self, bridge: Bridge, dt_s: f64) -> f64 {
        let electrical_rad_s = self.parameters.pole_pairs * libm::fabs(self.velocity_rad_s);
        let longest_s = if electrical_rad_s * dt_s > PART_RAD { PART_RAD / electrical_rad_s } else { dt_s };
        match bridge {
            // A rectifier's pulse may begin and end within a step.
            Bridge::Floating { bus_voltage_v } if self.line_to_line_emf_v() > bus_voltage_v => {
                longest_s.min(0.25 * dt_s)
            }
            _ => longest_s,
        }
    }

    /// When the regime ends, given that it does within `left_s`.
    fn event(&self, state: State, bridge: Bridge, equations: &Equations, left_s: f64) -> f64 {
        let (mut before_s, mut after_s) = (0.0, left_s);
        for _ in 0..BISECTIONS {
            let middle_s = 0.5 * (before_s + after_s);
            if self.stays(equations.after(state, middle_s).0, bridge, equations) {
                before_s = middle_s;
            } else {
                after_s = middle_s;
            }
        }
        after_s
    }

    /// What holds from this state on.
    fn begun(&mut self, state: State, bridge: Bridge, equations: Equations) -> (State, Equations) {
        let (state, connection) = match bridge {
            Bridge::Driven { voltage_alpha_beta_v } => {
                self.rails = [0; 3];
                (state, Connection::Closed(voltage_alpha_beta_v))
            }
            Bridge::DrivenOpen { open_phase, voltage_alpha_beta_v } => {
                self.rails = [0; 3];
                super::diodes::opened(state, open_phase, voltage_alpha_beta_v, equations.rotor(state))
            }
            Bridge::Floating { bus_voltage_v } => self.switch_diodes(state, bus_voltage_v, &equations),
        };
        let [_, _, velocity, _] = state;
        let turns = self.travelled(state);
        let friction = shaft::friction(&self.mechanics, turns, velocity, equations.driving_nm(state));
        (state, equations.with(connection, friction))
    }

    /// Whether it still holds in this state.
    fn stays(&self, state: State, bridge: Bridge, equations: &Equations) -> bool {
        let [_, _, velocity, _] = state;
        let (turns, driving_nm) = (self.travelled(state), equations.driving_nm(state));
        shaft::stays(&self.mechanics, equations.friction, turns, velocity, driving_nm)
            && match bridge {
                Bridge::Driven { .. } | Bridge::DrivenOpen { .. } => true,
                Bridge::Floating { bus_voltage_v } => self.diodes_stay(state, bus_voltage_v, equations),
            }
    }

    /// The state `after_s` later, when it ended: at standstill, or at an end of travel, where that was the reason.
    fn ended(&self, begin: State, equations: &Equations, after_s: f64) -> (State, Work) {
        let (state, work) = equations.after(begin, after_s);
        let [d, q, velocity, turned_rad] = state;
        let turns = self.travelled(state);
        let (allowed_turns, allowed) = shaft::stopped(&self.mechanics, equations.friction, turns, velocity);
        let allowed_rad =
            turned_rad + (allowed_turns - turns) * self.parameters.pole_pairs * core::f64::consts::TAU;
        let swallowed_j = self.mechanics.kinetic_j(velocity) - self.mechanics.kinetic_j(allowed);
        ([d, q, allowed, allowed_rad], work.swallowing(swallowed_j))
    }

    /// Where the shaft is in a state, in turns; 0 where travel has no ends, for then it does not matter.
    fn travelled(&self, [_, _, _, turned_rad]: State) -> f64 {
        if self.mechanics.hard_stops.is_none() {
            return 0.0;
        }
        let angle = self.angle.advanced_to(self.angle.electrical_rad() + turned_rad);
        angle.turns(self.parameters.pole_pairs)
    }
}
