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
}

/// How much room there is to brake in, for a tick from `speed` ≥ 0: what does not change while the next velocity is looked for.
struct Room {
    speed: Speed,
    ahead: i64,
    stop: Speed,
    acceleration: Speed,
    /// The acceleration times what would be left after a tick to the stop velocity s.
    above_stop: u128,
}

impl Room {
    fn new(speed: Speed, ahead: i64, limits: &Limits) -> Self {
        let (stop, acceleration) = (limits.stop_speed(), limits.acceleration());
        // A tick to s or more begins there if it did not begin faster.
        let left = ahead - speed.max(stop) - stop;
        let above_stop = product(left.max(0).unsigned_abs(), acceleration.unsigned_abs());
        Self { speed, ahead, stop, acceleration, above_stop }
    }

    /// Whether going to `next` ≥ 0 in this tick leaves room to brake before `ahead` units are used up.
    fn is_left_by(&self, next: Speed) -> bool {
        let &Self { speed, ahead, stop, acceleration, above_stop } = self;
        if next <= stop {
            // `Limits::jump`, for velocities that are not negative.
            let start = if speed >= stop || next == 0 { speed } else { next };
            return start + next <= ahead;
        }
        // v² − s² ≤ a · left, where going on to v takes v − s of what is left at s. So (v − s)(v + s + a) is compared with
        // what stays the same, and that with a product less; of unsigned numbers, which cost a microcontroller half of what
        // signed ones do.
        product((next - stop).unsigned_abs(), (next + stop + acceleration).unsigned_abs()) <= above_stop
    }
}

fn product(factor: u64, other: u64) -> u128 {
    u128::from(factor) * u128::from(other)
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
    let room = Room::new(speed, ahead, limits);
    let fastest = towards(speed, limits.top_speed(), limits);
    if room.is_left_by(fastest) {
        return fastest;
    }
    let slowest = towards(speed, 0, limits);
    let (mut fits, mut too_fast) = (slowest, fastest.min(speed + acceleration));
    for _ in 0..6 {
        let middle = fits + (too_fast - fits) / 2;
        if middle == fits {
            break;
        }
        if room.is_left_by(middle) {
            fits = middle;
        } else {
            too_fast = middle;
        }
    }
    fits
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// The rule as one writes it down: after the tick, what is left is enough to brake from v to s.
        #[test]
        fn room_is_what_braking_takes(
            speed in prop_oneof![0..1_i64 << 46, 0..2_000_000_i64],
            next in prop_oneof![0..1_i64 << 46, 0..2_000_000_i64],
            ahead in prop_oneof![0..1_i64 << 61, 0..1_i64 << 33, 0..4_000_000_i64],
            max_velocity_pps in 0..i32::MAX,
            acceleration_pps2 in prop_oneof![0..i32::MAX, 0..2000_i32],
            start_stop_velocity_pps in prop_oneof![0..i32::MAX, 0..100_i32],
        ) {
            let limits = Limits { max_velocity_pps, acceleration_pps2, start_stop_velocity_pps };
            let stop = limits.stop_speed();
            let left = i128::from(ahead) - i128::from(limits.jump(speed, next) + next);
            let (v, s) = (i128::from(next.max(stop)), i128::from(stop));
            let expected = left >= 0 && v * v - s * s <= left * i128::from(limits.acceleration());
            prop_assert_eq!(Room::new(speed, ahead, &limits).is_left_by(next), expected);
        }
    }
}
