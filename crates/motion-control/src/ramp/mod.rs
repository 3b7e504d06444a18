//! The ramp generator: trapezoidal velocity, exact landing, everything changeable in mid-flight.
//!
//! One [`Ramp::tick`] is one control period of 50 µs. All arithmetic is exact, so nothing drifts, however slow the ramp:
//! velocities are counted in 1/[`TICKS_PER_SECOND`] pps, so that an acceleration of `a` pps/s changes them by exactly `a`
//! a tick, and positions in 1/[`UNITS_PER_STEP`] step, so that the mean of two velocities is an exact number of units
//! (TMCM-1311 §8.4; the range of 327 679 999 pps and 24 999 998 pps/s fits 64 bits).
//!
//! Positions wrap at 32 bits, and a target more than 2³¹ − 1 steps away is reached the other, shorter way (§5.7.4).
//!
//! This module must never know whose steps these are (microsteps, encoder steps), nor what a stop switch is.

mod speed;

pub use speed::Limits;
use speed::{Speed, braking_speed, towards};

use crate::TICKS_PER_SECOND;
use crate::division::divided_down;

/// Subdivisions of a step: one unit of velocity, held for a tick, is two of them.
pub const UNITS_PER_STEP: i64 = 2 * TICKS_PER_SECOND * TICKS_PER_SECOND;

/// What the ramp is driving at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// To stop exactly at a position (§6, parameter 128 = 0).
    Position(i32),
    /// To turn at a velocity in pps (§6, parameter 128 = 1).
    Velocity(i32),
}

/// The state of the ramp generator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ramp {
    goal: Goal,
    /// Whole steps, rounded down.
    position: i32,
    /// The rest, in units, at least 0 and less than a step.
    fraction: i64,
    /// Signed, in 1/20 000 pps.
    velocity: Speed,
    /// Whether it moves, and slowed down in the last tick.
    braking: bool,
    /// Whether the velocity changed in the last tick.
    changing: bool,
}

impl Default for Ramp {
    fn default() -> Self {
        Self {
            goal: Goal::Position(0),
            position: 0,
            fraction: 0,
            velocity: 0,
            braking: false,
            changing: false,
        }
    }
}

/// An exact place on the ramp's axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    position: i32,
    fraction: i64,
}

impl Ramp {
    /// Exactly where it is.
    #[must_use]
    pub fn place(&self) -> Place {
        Place { position: self.position, fraction: self.fraction }
    }

    /// How far it went since then, in units of 1/[`UNITS_PER_STEP`].
    #[must_use]
    pub fn units_since(&self, then: Place) -> i64 {
        let steps = i64::from(self.position.wrapping_sub(then.position));
        steps * UNITS_PER_STEP + self.fraction - then.fraction
    }

    /// Turns at a velocity all at once, as if it always had.
    pub fn set_velocity_pps(&mut self, velocity_pps: i32) {
        self.velocity = i64::from(velocity_pps) * TICKS_PER_SECOND;
        self.braking = false;
    }

    /// Stops at once, whatever the limits, and stays where it is.
    pub fn halt(&mut self) {
        self.goal = Goal::Position(self.position);
        self.fraction = 0;
        self.velocity = 0;
        self.braking = false;
        self.changing = false;
    }

    /// What it is driving at.
    #[must_use]
    pub fn goal(&self) -> Goal {
        self.goal
    }

    /// Drives at something else from the next tick on, from the velocity it has.
    pub fn set_goal(&mut self, goal: Goal) {
        self.goal = goal;
    }

    /// Whole steps, rounded down.
    #[must_use]
    pub fn position(&self) -> i32 {
        self.position
    }

    /// Calls the present place `position`, and shifts a target along: nothing moves.
    pub fn redefine_position(&mut self, position: i32) {
        if let Goal::Position(target) = self.goal {
            self.goal = Goal::Position(target.wrapping_add(position.wrapping_sub(self.position)));
        }
        self.position = position;
    }

    /// The velocity in pps, rounded towards zero.
    #[must_use]
    pub fn velocity_pps(&self) -> i32 {
        // |velocity| stays below 2^31 · 20 000 by the range of the limits.
        let pps = divided_down(self.velocity.abs(), TICKS_PER_SECOND).0 * self.velocity.signum();
        i32::try_from(pps).unwrap_or(i32::MAX)
    }

    /// Whether it stands still.
    #[must_use]
    pub fn is_standing(&self) -> bool {
        self.velocity == 0
    }

    /// Whether it moves, and slowed down in the last tick.
    #[must_use]
    pub fn is_braking(&self) -> bool {
        self.braking
    }

    /// Whether it speeded up or slowed down in the last tick.
    #[must_use]
    pub fn is_changing_speed(&self) -> bool {
        self.changing
    }

    /// Whether it stands exactly on its target position.
    #[must_use]
    pub fn is_on_target(&self) -> bool {
        self.is_standing() && self.goal == Goal::Position(self.position) && self.fraction == 0
    }

    /// Whether another tick would change nothing.
    #[must_use]
    pub fn is_settled(&self, limits: &Limits) -> bool {
        self.is_at_rest(limits) && !self.changing
    }

    /// Whether it stands, and its goal leaves it there.
    #[must_use]
    pub fn is_at_rest(&self, limits: &Limits) -> bool {
        match self.goal {
            Goal::Position(_) => self.is_on_target() || (self.is_standing() && limits.max_velocity_pps == 0),
            Goal::Velocity(_) => self.is_standing() && self.commanded_speed(limits) == 0,
        }
    }

    /// One control period: changes the velocity within the limits and moves by the mean of the old and the new one.
    ///
    /// Constant work: at most seven looks at the braking distance, each of one product of 128 bits.
    pub fn tick(&mut self, limits: &Limits) {
        let before = self.velocity;
        match self.goal {
            Goal::Velocity(_) => {
                self.velocity = towards(before, self.commanded_speed(limits), limits);
                self.advance(limits.jump(before, self.velocity) + self.velocity);
            }
            Goal::Position(target) => self.approach(target, limits),
        }
        self.changing = self.velocity != before;
        self.braking = self.velocity != 0 && self.velocity.abs() < before.abs();
    }

    /// The velocity to turn at, limited to the maximum.
    fn commanded_speed(&self, limits: &Limits) -> Speed {
        let Goal::Velocity(velocity_pps) = self.goal else { return 0 };
        let top = limits.top_speed();
        (i64::from(velocity_pps) * TICKS_PER_SECOND).clamp(-top, top)
    }

    fn approach(&mut self, target: i32, limits: &Limits) {
        let distance = self.distance_to(target);
        if distance == 0 && self.velocity == 0 {
            return;
        }
        // Seen in a mirror where needed, the target lies ahead.
        let sign = if distance < 0 || (distance == 0 && self.velocity < 0) { -1 } else { 1 };
        let (ahead, speed) = (distance * sign, self.velocity * sign);
        if limits.can_land(speed, ahead) {
            self.position = target;
            self.fraction = 0;
            self.velocity = 0;
            return;
        }
        let next = if speed < 0 { towards(speed, 0, limits) } else { braking_speed(speed, ahead, limits) };
        let start = limits.jump(speed, next);
        self.velocity = next * sign;
        self.advance((start + next) * sign);
    }

    /// Units to `target`, the shorter way round.
    fn distance_to(&self, target: i32) -> i64 {
        i64::from(target.wrapping_sub(self.position)) * UNITS_PER_STEP - self.fraction
    }

    /// Moves by `units`, at most a few thousand steps.
    fn advance(&mut self, units: i64) {
        let (whole, fraction) = divided_down(self.fraction + units, UNITS_PER_STEP);
        self.fraction = fraction;
        self.position = self.position.wrapping_add(i32::try_from(whole).unwrap_or(0));
    }
}

#[cfg(test)]
mod tests;
