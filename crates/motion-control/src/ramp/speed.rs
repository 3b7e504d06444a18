//! The next velocity: how fast one may go and still stop in time.
//!
//! Velocities here are in 1/20 000 pps, distances in units of [`super::UNITS_PER_STEP`], time in ticks. With these, a tick
//! at mean velocity (v + w)/2 covers v + w units, and braking from v to the stop velocity s at a covers (v² − s²)/a units.

use crate::TICKS_PER_SECOND;

/// A velocity in 1/20 000 pps.
pub(super) type Speed = i64;

/// What the ramp may do, as a user writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest velocity in pps; at least 0.
    pub max_velocity_pps: i32,
    /// Acceleration and deceleration in pps/s; at least 1.
    pub acceleration_pps2: i32,
    /// Velocity at which the ramp begins and from which it may stop at once, in pps; at least 0.
    pub start_stop_velocity_pps: i32,
}

impl Limits {
    pub(super) fn top_speed(&self) -> Speed {
        i64::from(self.max_velocity_pps.max(0)) * TICKS_PER_SECOND
    }

    /// The velocity change of a tick.
    fn acceleration(&self) -> Speed {
        i64::from(self.acceleration_pps2.max(1))
    }

    /// The velocity below which anything goes.
    fn stop_speed(&self) -> Speed {
        (i64::from(self.start_stop_velocity_pps.max(0)) * TICKS_PER_SECOND).min(self.top_speed())
    }

    /// Where a tick from `from` to `to` begins: a start from below the start velocity jumps there first.
    pub(super) fn jump(&self, from: Speed, to: Speed) -> Speed {
        let stop = self.stop_speed();
        if from.abs() < stop && to != 0 { stop.min(to.abs()) * to.signum() } else { from }
    }

    /// Whether the target, `ahead` units away, is within this tick's reach, so that the ramp may stop on it.
    ///
    /// A tick that slows down to the stop velocity s covers up to v + s units, and from there the ramp stops at once. From
    /// rest without s, a tick that speeds up and slows down covers a/2 units; two more, less than 3 billionths of a step,
    /// keep rounding from leaving a rest.
    pub(super) fn can_land(&self, speed: Speed, ahead: i64) -> bool {
        let (acceleration, stop) = (self.acceleration(), self.stop_speed());
        let reach = (speed.max(stop) + stop).max(acceleration / 2 + 2);
        (0..=acceleration + stop).contains(&speed) && ahead <= reach
    }

    /// Whether going from `speed` to `next` in this tick leaves room to brake before `ahead` units are used up.
    fn leaves_room(&self, speed: Speed, next: Speed, ahead: i64) -> bool {
        let stop = self.stop_speed();
        let left = ahead - (self.jump(speed, next) + next);
        if next <= stop {
            return left >= 0;
        }
        // v² − s² ≤ a · left, with a product less; all but `left` is positive here, and products of unsigned numbers cost a
        // microcontroller half of what signed ones do.
        let Ok(left) = u64::try_from(left) else { return false };
        let product = |factor: u64, other: u64| u128::from(factor) * u128::from(other);
        product((next - stop).unsigned_abs(), (next + stop).unsigned_abs())
            <= product(left, self.acceleration().unsigned_abs())
    }
}

/// One tick from `speed` towards `wanted`; through zero only after a stop there.
pub(super) fn towards(speed: Speed, wanted: Speed, limits: &Limits) -> Speed {
    let (acceleration, stop) = (limits.acceleration(), limits.stop_speed());
    let against = speed != 0 && wanted.signum() != speed.signum();
    if against {
        let slower = (speed.abs() - acceleration).max(0);
        return if speed.abs() <= stop { 0 } else { slower * speed.signum() };
    }
    let sign = if speed == 0 { wanted.signum() } else { speed.signum() };
    let (now, goal) = (speed.abs(), wanted.abs());
    let next = if goal >= now {
        goal.min((now + acceleration).max(stop))
    } else if now <= stop {
        goal
    } else {
        goal.max(now - acceleration)
    };
    next * sign
}

/// The largest velocity for this tick, from `speed` ≥ 0, that still lets the ramp stop after `ahead` > 0 units.
///
/// When braking is due, the exact answer lies between `speed − a` and `speed + a`; six halvings find it to 1/32 of `a`, from
/// below, which keeps the ramp feasible and close to the ideal parabola without a square root.
pub(super) fn braking_speed(speed: Speed, ahead: i64, limits: &Limits) -> Speed {
    let acceleration = limits.acceleration();
    let fastest = towards(speed, limits.top_speed(), limits);
    if limits.leaves_room(speed, fastest, ahead) {
        return fastest;
    }
    let slowest = towards(speed, 0, limits);
    let (mut fits, mut too_fast) = (slowest, fastest.min(speed + acceleration));
    for _ in 0..6 {
        let middle = fits + (too_fast - fits) / 2;
        if middle == fits {
            break;
        }
        if limits.leaves_room(speed, middle, ahead) {
            fits = middle;
        } else {
            too_fast = middle;
        }
    }
    fits
}
