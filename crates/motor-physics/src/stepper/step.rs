//! A stepper's step, cut where friction or an end of travel stops the shaft: put off to the end of the step, a change of its
//! direction would cost milliamperes.

use super::Stepper;
use super::equations::{Equations, State};
use crate::energy::Work;
use crate::mechanics::Friction;

/// How often friction may stop the shaft within a step; one that is stopped so often stands.
const MAX_STOPS: usize = 4;

/// Halvings of a step to find the instant of a stop: to 50 ns in 50 µs.
const BISECTIONS: usize = 10;

/// What a step leads to.
#[derive(Clone, Copy)]
pub(super) struct Reached {
    pub(super) state: State,
    pub(super) work: Work,
}

impl Stepper {
    /// Where `dt_s` with these voltages leads to.
    pub(super) fn stepped(&self, voltages: [Option<f64>; 2], load_torque_nm: f64, dt_s: f64) -> Reached {
        let equations = Equations::new(self, voltages, load_torque_nm);
        let [a, b] = self.currents_a;
        let (mut state, mut work) = ([a, b, self.velocity_rad_s, 0.0], Work::default());
        let mut left_s = dt_s;
        for _ in 0..MAX_STOPS {
            let friction = self.mechanics.friction(velocity(state), equations.driving_nm(state));
            let equations = equations.with(friction);
            let (reached, more) = equations.after(state, left_s);
            if !self.is_stopped(friction, reached) {
                return Reached { state: reached, work: work.plus(more) };
            }
            let stop_s =
                first_time(left_s, |time_s| self.is_stopped(friction, equations.after(state, time_s).0));
            let (there, more) = equations.after(state, stop_s);
            let (after, swallowed_j) = self.stopped(friction, there);
            state = after;
            work = work.plus(more).swallowing(swallowed_j);
            left_s -= stop_s;
        }
        let (state, more) = equations.with(Friction::Sticks).after(state, left_s);
        Reached { state, work: work.plus(more) }
    }

    /// Whether friction or an end of travel stopped the shaft before this state.
    fn is_stopped(&self, friction: Friction, state: State) -> bool {
        friction.would_drive(velocity(state)) || self.is_beyond_travel(state)
    }

    /// Whether a state lies beyond an end of travel and leads further away.
    fn is_beyond_travel(&self, state: State) -> bool {
        self.mechanics.hard_stops.is_some() && self.velocity_within_travel(state) != velocity(state)
    }

    fn velocity_within_travel(&self, [_, _, velocity, turned_rad]: State) -> f64 {
        let angle = self.angle.advanced_to(self.angle.electrical_rad() + turned_rad);
        self.mechanics.within_travel(angle.turns(self.parameters.pole_pairs), velocity).1
    }

    /// The state from which it goes on after a stop: at standstill, or at an end of travel with the velocity turned round;
    /// and the energy that the end swallows.
    fn stopped(&self, friction: Friction, state: State) -> (State, f64) {
        let [a, b, velocity, turned_rad] = state;
        if friction.would_drive(velocity) {
            return ([a, b, 0.0, turned_rad], 0.0);
        }
        let bounced = self.velocity_within_travel(state);
        let swallowed_j = self.mechanics.kinetic_j(velocity) - self.mechanics.kinetic_j(bounced);
        ([a, b, bounced, turned_rad], swallowed_j)
    }
}

fn velocity([_, _, velocity, _]: State) -> f64 {
    velocity
}

/// The first time at which `holds`, which holds at `latest_s`.
fn first_time(latest_s: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut before_s, mut after_s) = (0.0, latest_s);
    for _ in 0..BISECTIONS {
        let middle_s = 0.5 * (before_s + after_s);
        if holds(middle_s) {
            after_s = middle_s;
        } else {
            before_s = middle_s;
        }
    }
    after_s
}
