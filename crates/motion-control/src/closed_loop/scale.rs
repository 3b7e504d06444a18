//! Encoder counts as µsteps: an exact ratio, carried along without drift.

use crate::division::divided;

/// µsteps in a full step.
pub const MICROSTEPS: u32 = 256;

/// What the encoder's counts are worth (TMCM-1311 §8.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderScale {
    /// Numerator: µsteps in a turn.
    microsteps: i64,
    /// Denominator: counts in a turn.
    counts: i64,
}

impl EncoderScale {
    /// A motor of `full_steps` with an encoder of `counts` in a turn; none where either is 0.
    #[must_use]
    pub fn new(full_steps: u32, counts: u32) -> Option<Self> {
        let scale = Self { microsteps: i64::from(full_steps) * i64::from(MICROSTEPS), counts: counts.into() };
        (full_steps != 0 && counts != 0).then_some(scale)
    }

    /// Whether each full step has more than two counts, which a closed loop needs (§8.3, "Attention").
    #[must_use]
    pub fn is_fine_enough(&self) -> bool {
        self.counts * i64::from(MICROSTEPS) > 2 * self.microsteps
    }

    /// Counts in µsteps, rounded to the nearest.
    #[must_use]
    pub fn microsteps(&self, counts: i64) -> i64 {
        rounded(counts.saturating_mul(self.microsteps), self.counts)
    }

    /// µsteps in counts, rounded to the nearest.
    #[must_use]
    pub fn counts(&self, microsteps: i64) -> i64 {
        rounded(microsteps.saturating_mul(self.counts), self.microsteps)
    }

    /// A velocity of so many counts in so many control periods, in µsteps a second; 0 where `ticks` is 0.
    #[must_use]
    pub fn velocity_pps(&self, counts: i32, ticks: u32) -> i32 {
        let velocity_pps = self.per_second(counts).checked_div(self.counts * i64::from(ticks)).unwrap_or(0);
        velocity_pps.clamp(i32::MIN.into(), i32::MAX.into()) as i32
    }

    /// Whether such a velocity is above `speed_pps` either way, found without dividing. Where it is not, the magnitude of
    /// [`EncoderScale::velocity_pps`] is not either.
    #[must_use]
    pub fn is_faster(&self, counts: i32, ticks: u32, speed_pps: u32) -> bool {
        let next_pps = u64::from(speed_pps.min(i32::MAX.unsigned_abs())) + 1;
        let ticks = self.counts.unsigned_abs() * u64::from(ticks);
        ticks != 0 && self.per_second(counts).unsigned_abs() >= next_pps.saturating_mul(ticks)
    }

    /// µsteps of so many counts in each control period of a second, in 1/counts-per-turn.
    fn per_second(&self, counts: i32) -> i64 {
        i64::from(counts).saturating_mul(self.microsteps * crate::TICKS_PER_SECOND)
    }
}

/// Rounded to the nearest, halves up.
fn rounded(dividend: i64, divisor: i64) -> i64 {
    divided(dividend.saturating_add(divisor / 2), divisor).0
}

/// Where the rotor is: the whole µsteps that the counts amount to, and the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Odometer {
    scale: EncoderScale,
    count: i32,
    /// What the counts amount to beyond whole µsteps, in 1/counts-per-turn: at least 0, less than a µstep.
    remainder: i64,
}

impl Odometer {
    /// An odometer that stands on a whole µstep at this count.
    #[must_use]
    pub fn new(scale: EncoderScale, count: i32) -> Self {
        Self { scale, count, remainder: 0 }
    }

    /// What the counts are worth.
    #[must_use]
    pub fn scale(&self) -> &EncoderScale {
        &self.scale
    }

    /// Follows the counter, which wraps. Returns the whole µsteps that the rotor went on.
    pub fn follow(&mut self, count: i32) -> i64 {
        let counts = count.wrapping_sub(self.count);
        self.count = count;
        if counts == 0 {
            return 0;
        }
        let moved = i64::from(counts) * self.scale.microsteps + self.remainder;
        let (microsteps, remainder) = divided(moved, self.scale.counts);
        self.remainder = remainder;
        microsteps
    }

    /// Whole µsteps from here to the place that is `counts` further.
    #[must_use]
    pub fn microsteps_to(&self, counts: i32) -> i64 {
        divided(i64::from(counts) * self.scale.microsteps + self.remainder, self.scale.counts).0
    }

    /// Counts from here to the place that is whole `microsteps` further: the inverse of [`Odometer::microsteps_to`], where
    /// a count is worth a µstep or more.
    #[must_use]
    pub fn counts_to(&self, microsteps: i64) -> i64 {
        let ahead = microsteps.saturating_mul(self.scale.counts).saturating_sub(self.remainder);
        // Rounded up: the first count that lies on the µstep.
        divided(ahead.saturating_add(self.scale.microsteps - 1), self.scale.microsteps).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn scale(full_steps: u32, counts: u32) -> EncoderScale {
        EncoderScale::new(full_steps, counts).expect("neither is 0")
    }

    #[test]
    fn a_turn_is_a_turn() {
        assert_eq!(scale(200, 40_000).microsteps(40_000), 51_200);
        assert_eq!(scale(200, 40_000).counts(51_200), 40_000);
        assert_eq!(scale(200, 40_000).counts(-25_600), -20_000);
        assert_eq!(scale(200, 4000).microsteps(-1), -13, "12.8");
    }

    #[test]
    fn without_steps_or_counts_there_is_no_scale() {
        assert_eq!(EncoderScale::new(0, 4000), None);
        assert_eq!(EncoderScale::new(200, 0), None);
    }

    #[test]
    fn more_than_two_counts_a_full_step_will_do() {
        assert!(!scale(200, 400).is_fine_enough());
        assert!(scale(200, 401).is_fine_enough());
    }

    #[test]
    fn a_turn_a_second_is_51_200_pps() {
        assert_eq!(scale(200, 40_000).velocity_pps(2, 1), 51_200);
        assert_eq!(scale(200, 40_000).velocity_pps(-1, 100), -256);
        assert_eq!(scale(200, 40_000).velocity_pps(7, 0), 0);
    }

    proptest! {
        #[test]
        fn what_the_odometer_says_is_what_the_count_is_worth(
            full_steps in 1_u32..=400,
            counts in 1_u32..=65_535,
            steps in proptest::collection::vec(-100_000..100_000, 1..50),
        ) {
            let scale = scale(full_steps, counts);
            let (mut odometer, mut count, mut position) = (Odometer::new(scale, 0), 0_i32, 0_i64);
            for step in steps {
                count = count.wrapping_add(step);
                prop_assert_eq!(odometer.microsteps_to(step), {
                    let mut there = odometer;
                    there.follow(count)
                });
                position += odometer.follow(count);
            }
            let exact = i64::from(count) * scale.microsteps;
            prop_assert_eq!(position, exact.div_euclid(scale.counts));
        }

        #[test]
        fn a_place_in_counts_is_found_again(
            full_steps in 100_u32..=400,
            counts in 1_u32..=25_600,
            start in any::<i32>(),
            way in -1_000_000_i32..1_000_000,
        ) {
            let mut odometer = Odometer::new(scale(full_steps, counts), 0);
            odometer.follow(start);
            prop_assert_eq!(odometer.counts_to(odometer.microsteps_to(way)), i64::from(way));
        }

        #[test]
        fn what_is_faster_has_a_larger_velocity(
            full_steps in 1_u32..=400,
            counts in 1_u32..=65_535,
            moved in -100_000_i32..100_000,
            ticks in 1_u32..3000,
            off_pps in -1_i32..=1,
        ) {
            let scale = scale(full_steps, counts);
            let speed_pps = scale.velocity_pps(moved, ticks).unsigned_abs();
            let other_pps = speed_pps.saturating_add_signed(off_pps);
            let is_faster = scale.is_faster(moved, ticks, other_pps);
            prop_assert!(is_faster || speed_pps <= other_pps);
            // A velocity that 32 bits do not hold is faster than it reads.
            prop_assert!(!is_faster || speed_pps > other_pps || speed_pps >= i32::MAX.unsigned_abs());
        }

        #[test]
        fn nothing_overflows(
            full_steps in 1_u32..=400,
            counts in 1_u32..=65_535,
            count in any::<i32>(),
            far in any::<i64>(),
            ticks in any::<u32>(),
        ) {
            let scale = scale(full_steps, counts);
            let mut odometer = Odometer::new(scale, 0);
            odometer.follow(count);
            let _ = (odometer.counts_to(far), odometer.microsteps_to(count), scale.velocity_pps(count, ticks));
            let _ = (scale.is_faster(count, ticks, ticks), scale.is_faster(count, ticks, u32::MAX));
            let _ = (scale.microsteps(far), scale.counts(far));
        }
    }
}
