//! The ramp generator that leads the velocity regulator to its target (TMCM-1640 §7.4).
//!
//! The acceleration counts by its magnitude; with one of 0 the velocity stays what it is (a decision: the manual allows any
//! number).
//!
//! This module must never know where the target comes from.

/// Parts of an rpm that the ramp works in: 1 rpm/s is one of them in a ms.
const PARTS_PER_RPM: i64 = 1000;

/// The state of the ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VelocityRamp {
    parts: i64,
}

impl VelocityRamp {
    /// Standing.
    #[must_use]
    pub const fn new() -> Self {
        Self { parts: 0 }
    }

    /// Puts the velocity somewhere, such as what was measured; the ramp goes on from there.
    pub fn set(&mut self, velocity_rpm: i32) {
        self.parts = parts(velocity_rpm);
    }

    /// The velocity in rpm, to the nearest, half of one away from 0.
    #[must_use]
    pub fn rpm(&self) -> i32 {
        ((self.parts + PARTS_PER_RPM / 2 * self.parts.signum()) / PARTS_PER_RPM) as i32
    }

    /// Whether the ramp is on this target, so that another tick changes nothing.
    #[must_use]
    pub fn is_settled(&self, target_rpm: i32) -> bool {
        self.parts == parts(target_rpm)
    }

    /// One regulation, `interval_ms` after the one before, towards a target, with an acceleration in rpm/s.
    pub fn tick(&mut self, target_rpm: i32, acceleration_rpm_per_s: i32, interval_ms: u32) {
        let step = u64::from(acceleration_rpm_per_s.unsigned_abs()) * u64::from(interval_ms);
        let step = i64::try_from(step).unwrap_or(i64::MAX);
        let lowest = self.parts.saturating_sub(step);
        self.parts = parts(target_rpm).min(self.parts.saturating_add(step)).max(lowest);
    }

    /// Like [`VelocityRamp::tick`], but a smaller velocity in the same direction, or 0, is taken at once: for targets that
    /// fall as the way to a position does. To the other direction the acceleration holds (a decision): only a new position
    /// far behind asks for that at speed.
    pub fn follow(&mut self, target_rpm: i32, acceleration_rpm_per_s: i32, interval_ms: u32) {
        let target = parts(target_rpm);
        let falls = target.abs() <= self.parts.abs() && target.signum() * self.parts.signum() >= 0;
        if falls {
            self.parts = target;
        } else {
            self.tick(target_rpm, acceleration_rpm_per_s, interval_ms);
        }
    }
}

fn parts(velocity_rpm: i32) -> i64 {
    i64::from(velocity_rpm) * PARTS_PER_RPM
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn an_acceleration_of_one_is_an_rpm_in_a_second() {
        let mut ramp = VelocityRamp::new();
        (0..499).for_each(|_| ramp.tick(10, 1, 1));
        assert_eq!(ramp.rpm(), 0);
        ramp.tick(10, 1, 1);
        assert_eq!(ramp.rpm(), 1);
        (0..500).for_each(|_| ramp.tick(10, -1, 1));
        assert_eq!(ramp.parts, 1000);
        ramp.tick(-10, 1, 1500);
        assert_eq!((ramp.parts, ramp.rpm()), (-500, -1));
    }

    #[test]
    fn it_goes_on_from_where_it_is_put_and_stays_without_acceleration() {
        let mut ramp = VelocityRamp::new();
        ramp.set(-700);
        assert!(ramp.is_settled(-700));
        ramp.tick(3000, 0, 1);
        assert!(ramp.is_settled(-700));
        ramp.tick(3000, 2000, 5);
        assert_eq!(ramp.rpm(), -690);
    }

    #[test]
    fn following_falls_at_once_and_rises_by_the_acceleration() {
        for sign in [1, -1] {
            let mut ramp = VelocityRamp::new();
            ramp.set(sign * 3000);
            ramp.follow(sign * 1000, 2000, 1);
            assert_eq!(ramp.rpm(), sign * 1000);
            ramp.follow(sign * 3000, 2000, 1);
            assert_eq!(ramp.rpm(), sign * 1002);
            ramp.follow(-sign * 10, 2000, 1);
            assert_eq!(ramp.rpm(), sign * 1000);
            ramp.follow(0, 2000, 1);
            assert!(ramp.is_settled(0));
            ramp.follow(-sign * 10, 2000, 1);
            assert_eq!(ramp.rpm(), -sign * 2);
        }
    }

    proptest! {
        /// Any numbers: towards the target, not beyond it, by the acceleration.
        #[test]
        fn each_tick_keeps_the_acceleration(start: i32, target: i32, acceleration: i32, interval: u32) {
            let mut ramp = VelocityRamp::new();
            ramp.set(start);
            let before = i128::from(ramp.parts);
            ramp.tick(target, acceleration, interval);
            let (after, goal) = (i128::from(ramp.parts), i128::from(parts(target)));
            let step = i128::from(acceleration).abs() * i128::from(interval);
            prop_assert_eq!((after - before).abs(), step.min((goal - before).abs()));
            prop_assert!((goal - after).abs() + (after - before).abs() == (goal - before).abs());
            let mut follower = VelocityRamp::new();
            follower.set(start);
            follower.follow(target, acceleration, interval);
            prop_assert!(follower == ramp || follower.is_settled(target));
            prop_assert!(i64::from(ramp.rpm()).abs_diff(ramp.parts / 1000) <= 1);
        }

        #[test]
        fn the_time_is_the_difference_over_the_acceleration(
            start in -4000_i32..4000,
            target in -4000_i32..4000,
            acceleration in 1_i32..9000,
        ) {
            let mut ramp = VelocityRamp::new();
            ramp.set(start);
            let expected = (start.abs_diff(target) * 1000).div_ceil(acceleration.unsigned_abs());
            let mut ticks = 0;
            while !ramp.is_settled(target) && ticks <= expected {
                ramp.tick(target, acceleration, 1);
                ticks += 1;
            }
            prop_assert_eq!(ticks, expected);
        }
    }
}
