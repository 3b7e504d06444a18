//! What is connected to a step/direction connector: whole pulses at a frequency, in whole numbers.
//!
//! The fraction of a pulse period that has passed is kept exactly, so that by any time `t` the whole part of `|f| · t` pulses
//! have come, however time is cut into pieces. A new frequency goes on with the fraction there is.

use crate::TICK_NS;

/// The smallest frequency: 1 µHz.
const PER_HZ: f64 = 1e6;

/// Fractions in a pulse period: a source of 1 µHz adds one of them in a control period.
const PERIOD: u64 = 1_000_000 * (1_000_000_000 / TICK_NS);

/// A pulse source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PulseSource {
    frequency_uhz: u64,
    to_the_left: bool,
    /// Pulses until it falls silent; `None`: it never does.
    left: Option<u32>,
    /// The passed fraction of a pulse period, less than one.
    phase: u64,
    /// Pulses in the last control period, positive to the right.
    steps: i32,
    /// Pulses to the right less those to the left.
    total: i64,
}

impl PulseSource {
    /// Sets the frequency, to the nearest µHz, at most 1 GHz; negative is to the left.
    pub(super) fn set_frequency(&mut self, frequency_hz: f64) {
        self.frequency_uhz =
            (libm::round(libm::fabs(frequency_hz) * PER_HZ) as u64).min(1_000_000_000_000_000);
        self.to_the_left = frequency_hz < 0.0;
    }

    /// Lets it fall silent after so many pulses, the first of them a whole period from now; `None`: never.
    pub(super) fn set_pulses(&mut self, pulses: Option<u32>) {
        self.left = pulses;
        self.phase = 0;
    }

    /// Pulses in the last control period, positive to the right.
    pub(super) fn steps(&self) -> i32 {
        self.steps
    }

    /// Pulses to the right less those to the left, since the bench was switched on.
    pub(super) fn total(&self) -> i64 {
        self.total
    }

    /// Nobody counted the pulses of the last control period.
    pub(super) fn forget_steps(&mut self) {
        self.steps = 0;
    }

    /// Lets a control period pass.
    pub(super) fn advance(&mut self) {
        let phase = self.phase + self.rate();
        let pulses = self.left.map_or(phase / PERIOD, |left| (phase / PERIOD).min(left.into()));
        self.phase = phase % PERIOD;
        let pulses = i32::try_from(pulses).unwrap_or(i32::MAX);
        if let Some(left) = &mut self.left {
            *left -= pulses.unsigned_abs();
            if *left == 0 {
                self.phase = 0;
            }
        }
        self.steps = if self.to_the_left { -pulses } else { pulses };
        self.total += i64::from(self.steps);
    }

    /// Lets control periods pass in which no pulse falls.
    pub(super) fn rest(&mut self, periods: u64) {
        debug_assert!(periods < self.periods_to_pulse(), "a rest across a pulse");
        self.phase += self.rate() * periods;
    }

    /// Control periods until the end of the one in which the next pulse falls; `u64::MAX` = never.
    pub(super) fn periods_to_pulse(&self) -> u64 {
        (PERIOD - self.phase)
            .checked_next_multiple_of(self.rate())
            .map_or(u64::MAX, |missing| missing / self.rate())
    }

    /// Fractions in a control period.
    fn rate(&self) -> u64 {
        if self.left == Some(0) { 0 } else { self.frequency_uhz }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Goes on for `periods`, resting wherever that is allowed and `may_rest` says so.
    fn run(source: &mut PulseSource, periods: u64, may_rest: bool) {
        let mut left = periods;
        while left > 0 {
            let rest = (source.periods_to_pulse() - 1).min(left);
            if may_rest && rest > 0 {
                source.rest(rest);
                left -= rest;
            } else {
                source.advance();
                left -= 1;
            }
        }
    }

    fn at(frequency_hz: f64) -> PulseSource {
        let mut source = PulseSource::default();
        source.set_frequency(frequency_hz);
        source
    }

    proptest! {
        /// ⌊f · t⌋ pulses by every t, with and without rests.
        #[test]
        fn the_count_is_exact_however_time_is_cut(
            frequency_uhz in prop_oneof![0..=1_000_000_000_000_i64, 0..=100_000_000_i64],
            to_the_left in any::<bool>(),
            pieces in proptest::collection::vec((0..3000_u64, any::<bool>()), 1..12),
        ) {
            let sign = if to_the_left { -1 } else { 1 };
            let mut source = at((sign * frequency_uhz) as f64 / 1e6);
            let mut periods = 0;
            for (length, may_rest) in pieces {
                run(&mut source, length, may_rest);
                periods += length;
                // µHz · 50 µs in picopulses.
                let expected = i128::from(frequency_uhz) * i128::from(periods) * 50 / 1_000_000_000_000;
                prop_assert_eq!(i128::from(source.total()), expected * i128::from(sign));
            }
        }

        /// With a number of pulses to give, that many, and the last after n / f.
        #[test]
        fn a_number_of_pulses_is_kept(frequency_hz in 1..1_000_000_u32, pulses in 0..2000_u32) {
            let mut source = at(f64::from(frequency_hz));
            run(&mut source, 7, false);
            let before = source.total();
            source.set_pulses(Some(pulses));
            let periods = (u64::from(pulses) * 20_000).div_ceil(u64::from(frequency_hz));
            if periods > 0 {
                run(&mut source, periods - 1, true);
                prop_assert!(source.total() - before < i64::from(pulses));
                run(&mut source, 1, true);
            }
            prop_assert_eq!(source.total() - before, i64::from(pulses));
            prop_assert_eq!(source.periods_to_pulse(), u64::MAX);
            run(&mut source, 100_000, true);
            prop_assert_eq!(source.total() - before, i64::from(pulses));
        }
    }

    #[test]
    fn a_new_frequency_goes_on_in_the_period_that_has_begun() {
        let mut source = at(1000.0);
        run(&mut source, 15, false);
        source.set_frequency(2000.0);
        assert_eq!(source.periods_to_pulse(), 3, "a quarter of a period at 2 kHz is 2.5 control periods");
        run(&mut source, 3, true);
        assert_eq!((source.steps(), source.total()), (1, 1));
        source.set_frequency(0.0);
        assert_eq!(source.periods_to_pulse(), u64::MAX);
    }

    #[test]
    fn a_second_helping_takes_as_long_as_the_first() {
        let mut source = at(1000.0);
        for _ in 0..2 {
            source.set_pulses(Some(3));
            run(&mut source, 59, true);
            assert_eq!(source.total() % 3, 2);
            run(&mut source, 30, true);
            assert_eq!(source.total() % 3, 0);
        }
        source.set_pulses(None);
        run(&mut source, 20_000, true);
        assert_eq!(source.total(), 6 + 1000);
    }
}
