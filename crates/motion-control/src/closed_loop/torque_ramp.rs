//! The current of torque mode on its way to its target (TMCM-1311 §8.7, parameters 14, 19, 20 and 141).
//!
//! Outside the start/stop current the ramp follows the slope. Inside it nothing is ramped (decision): from 0 the ramp
//! begins at the start/stop current, or at a target below it; from the start/stop current it goes at once to a target
//! below, be that 0 or not. A change of sign passes 0, where the ramp is for one control period.
//!
//! This module must never know what the current does, nor which limits a target was given.

/// Parts of a mA that the ramp works in: a slope of 1 mA/s is one of them in a control period.
const PARTS_PER_MA: i32 = crate::TICKS_PER_SECOND as i32;

/// The largest current, in either direction: 100 A. More is taken for this (decision).
pub const MAX_CURRENT_MA: i32 = 100_000;

/// The state of the ramp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct TorqueRamp {
    /// The actual current in parts of a mA, so that slow slopes are exact.
    actual_parts: i32,
}

impl TorqueRamp {
    /// Without current.
    #[must_use]
    pub const fn new() -> Self {
        Self { actual_parts: 0 }
    }

    /// Puts the actual current somewhere, in mA; the ramp goes on from there.
    pub fn set_actual(&mut self, actual_ma: i32) {
        self.actual_parts = parts(actual_ma);
    }

    /// The actual current in mA, positive in the direction of positive targets, rounded towards zero.
    #[must_use]
    pub fn actual_ma(&self) -> i32 {
        self.actual_parts / PARTS_PER_MA
    }

    /// One control period towards a target, with a slope in mA/s, of which 0 goes there at once, and a start/stop current.
    pub fn tick(&mut self, target_ma: i32, slope_ma_per_s: u32, start_stop_ma: u32) {
        let target = parts(target_ma);
        if slope_ma_per_s == 0 {
            self.actual_parts = target;
            return;
        }
        let step = i32::try_from(slope_ma_per_s).unwrap_or(i32::MAX);
        let start_stop = parts(i32::try_from(start_stop_ma).unwrap_or(i32::MAX));
        let sign = if self.actual_parts == 0 { target.signum() } else { self.actual_parts.signum() };
        // A target on the other side is one of 0 until 0 is reached.
        let goal = (target * sign).max(0);
        self.actual_parts = sign * approach(self.actual_parts.abs(), goal, step, start_stop);
    }

    /// Whether the ramp is on this target, so that another tick changes nothing.
    #[must_use]
    pub fn is_settled(&self, target_ma: i32) -> bool {
        self.actual_parts == parts(target_ma)
    }
}

fn parts(current_ma: i32) -> i32 {
    current_ma.clamp(-MAX_CURRENT_MA, MAX_CURRENT_MA) * PARTS_PER_MA
}

/// One control period between magnitudes of a current.
fn approach(actual: i32, goal: i32, step: i32, start_stop: i32) -> i32 {
    if goal > actual {
        let next = if actual < start_stop { start_stop } else { actual.saturating_add(step) };
        next.min(goal)
    } else if actual <= start_stop {
        goal
    } else {
        actual.saturating_sub(step).max(start_stop).max(goal)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    /// The actual current after each of so many control periods.
    fn run(ramp: &mut TorqueRamp, ticks: u32, target: i32, slope: u32, start_stop: u32) -> Vec<i32> {
        (0..ticks)
            .map(|_| {
                ramp.tick(target, slope, start_stop);
                ramp.actual_ma()
            })
            .collect()
    }

    #[test]
    fn a_slope_of_one_is_a_milliampere_in_a_second() {
        for sign in [1, -1] {
            let mut ramp = TorqueRamp::new();
            run(&mut ramp, 3 * 20_000 - 1, sign * 1000, 1, 0);
            assert_eq!(ramp.actual_ma(), sign * 2);
            run(&mut ramp, 1, sign * 1000, 1, 0);
            assert_eq!(ramp.actual_ma(), sign * 3);
            assert!(ramp.is_settled(sign * 3));
        }
    }

    #[test]
    fn no_slope_goes_there_at_once() {
        let mut ramp = TorqueRamp::new();
        assert_eq!(run(&mut ramp, 1, 3000, 0, 100), [3000]);
        assert_eq!(run(&mut ramp, 1, -3000, 0, 100), [-3000]);
    }

    #[test]
    fn a_reversal_stops_and_starts_at_the_start_stop_current() {
        let mut ramp = TorqueRamp::new();
        let per_ma = 20_000;
        assert_eq!(run(&mut ramp, 4, 102, per_ma, 100), [100, 101, 102, 102]);
        assert_eq!(run(&mut ramp, 6, -102, per_ma, 100), [101, 100, 0, -100, -101, -102]);
        assert_eq!(run(&mut ramp, 4, 0, per_ma, 100), [-101, -100, 0, 0]);
    }

    #[test]
    fn within_the_start_stop_current_nothing_is_ramped() {
        let mut ramp = TorqueRamp::new();
        let per_ma = 20_000;
        assert_eq!(run(&mut ramp, 2, 40, per_ma, 100), [40, 40]);
        assert_eq!(run(&mut ramp, 3, 101, per_ma, 100), [100, 101, 101]);
        assert_eq!(run(&mut ramp, 3, 40, per_ma, 100), [100, 40, 40]);
        assert_eq!(run(&mut ramp, 3, -40, per_ma, 100), [0, -40, -40]);
    }

    #[test]
    fn it_goes_on_from_where_it_is_put() {
        let mut ramp = TorqueRamp::new();
        run(&mut ramp, 30_000, 1000, 1, 0);
        ramp.set_actual(-700);
        assert!(ramp.is_settled(-700));
        assert_eq!(run(&mut ramp, 2, 0, 20_000, 100), [-699, -698]);
    }

    #[test]
    fn nothing_overflows() {
        let mut ramp = TorqueRamp::new();
        ramp.set_actual(i32::MIN);
        assert_eq!(ramp.actual_ma(), -MAX_CURRENT_MA);
        assert_eq!(run(&mut ramp, 3, i32::MAX, u32::MAX, 0), [0, MAX_CURRENT_MA, MAX_CURRENT_MA]);
        assert_eq!(run(&mut ramp, 3, i32::MIN, u32::MAX, u32::MAX), [0, -MAX_CURRENT_MA, -MAX_CURRENT_MA]);
        assert!(ramp.is_settled(i32::MIN));
    }

    proptest! {
        /// Every tick moves towards the target, at most by the slope or the start/stop current, never across 0, and never
        /// rests between 0 and the start/stop current but on the target.
        #[test]
        fn each_tick_keeps_the_rules(
            start in -4000_i32..=4000,
            target in -4000_i32..=4000,
            slope in 1_u32..200_000_000,
            start_stop in 0_u32..=4000,
        ) {
            let mut ramp = TorqueRamp::new();
            ramp.set_actual(start);
            for _ in 0..200 {
                let before = ramp.actual_parts;
                ramp.tick(target, slope, start_stop);
                let actual = ramp.actual_parts;
                prop_assert!((before.min(parts(target))..=before.max(parts(target))).contains(&actual));
                prop_assert!(before.signum() * actual.signum() >= 0, "across 0");
                let inside = parts(start_stop as i32);
                let step = slope as i32;
                let jumps = before.abs() <= inside && actual.abs() <= inside;
                prop_assert!(jumps || before.abs_diff(actual) <= step.unsigned_abs());
                let lingers = actual != 0 && actual.abs() < inside && actual != parts(target);
                prop_assert!(!lingers, "{before} to {actual}");
                prop_assert!(actual != before || ramp.is_settled(target));
            }
        }

        /// From 0 with a slope, the time to the target is the distance beyond the start/stop current over the slope.
        #[test]
        fn the_ramp_takes_as_long_as_its_slope_says(
            target in 1_i32..=3000,
            forward: bool,
            slope in 1000_u32..1_000_000,
            start_stop in 0_u32..=3000,
        ) {
            let target = if forward { target } else { -target };
            let mut ramp = TorqueRamp::new();
            let beyond_parts = u64::from(target.unsigned_abs().saturating_sub(start_stop)) * 20_000;
            let expected = beyond_parts.div_ceil(u64::from(slope)) + u64::from(start_stop > 0);
            let mut ticks = 0;
            while !ramp.is_settled(target) {
                prop_assert!(ticks < expected, "longer than {expected}");
                ramp.tick(target, slope, start_stop);
                ticks += 1;
            }
            prop_assert_eq!(ticks, expected);
        }
    }
}
