//! The I²t monitor: the sum of the square of a current over a sliding window, and how long it was above a limit
//! (TMCM-1640 §9; the ring is a decision).
//!
//! The window is a ring of [`PARTS`] partial sums. The sum is that of the last [`PARTS`] finished ones: it spans the window
//! exactly, and changes only when a part is finished. Many ticks of one current can be added at once ([`I2t::skip`]), with
//! the same result as one by one.
//!
//! This module must never know what a sum is compared in, nor what follows from exceeding the limit.

use crate::TICKS_PER_SECOND;

/// Partial sums in a window.
pub const PARTS: usize = 64;

/// [`PARTS`] as the divisor of a window.
const PARTS_U64: u64 = PARTS as u64;

/// Ticks of the shortest window: 64 ms, a millisecond for each partial sum (decision). A shorter one is taken for this.
pub const SHORTEST_WINDOW: u64 = PARTS_U64 * SECOND / 1000;

/// Ticks between two counts while the sum is above the limit.
const SECOND: u64 = TICKS_PER_SECOND.cast_unsigned();

/// The state of the monitor. Squares of the current are in whatever unit the caller adds, sums in that unit times ticks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct I2t {
    window_ticks: u64,
    parts: [u64; PARTS],
    /// Which of them is finished next.
    part: usize,
    /// What the part that is not finished has so far, for how many ticks, and how many it will have.
    partial: u64,
    partial_ticks: u64,
    whole_ticks: u64,
    /// The sum of all finished parts: 64 of 64 bits fit, and it is kept up rather than made anew, which takes a
    /// microcontroller hundreds of instructions.
    total: u128,
    /// [`I2t::total`] as far as 64 bits go.
    sum: u64,
    /// For how many ticks the sum has been above the limit.
    above_ticks: u64,
    /// Ticks since it was last above the limit, until the flag is cleared.
    flagged: Option<u64>,
}

impl I2t {
    /// A monitor with an empty window of so many ticks, at least [`SHORTEST_WINDOW`].
    #[must_use]
    pub const fn new(window_ticks: u64) -> Self {
        let window_ticks = if window_ticks < SHORTEST_WINDOW { SHORTEST_WINDOW } else { window_ticks };
        Self {
            window_ticks,
            parts: [0; PARTS],
            part: 0,
            partial: 0,
            partial_ticks: 0,
            whole_ticks: part_ticks(window_ticks, 0),
            total: 0,
            sum: 0,
            above_ticks: 0,
            flagged: None,
        }
    }

    /// Another window: the sum begins anew where it differs, since parts of other lengths do not fit. The flag stays.
    pub fn set_window(&mut self, window_ticks: u64) {
        if window_ticks.max(SHORTEST_WINDOW) != self.window_ticks {
            *self = Self { flagged: self.flagged, ..Self::new(window_ticks) };
        }
    }

    /// The sum over the window.
    #[must_use]
    pub fn sum(&self) -> u64 {
        self.sum
    }

    /// Whether the sum exceeded the limit since the flag was last cleared.
    #[must_use]
    pub fn is_flagged(&self) -> bool {
        self.flagged.is_some()
    }

    /// Clears the flag, once the sum has not been above the limit for a whole window; before that it does nothing.
    pub fn clear_flag(&mut self) {
        if self.flagged.is_some_and(|ticks| ticks >= self.window_ticks) {
            self.flagged = None;
        }
    }

    /// One tick with this square of the current. Returns whether to count: the sum has been above `limit` for another
    /// second.
    pub fn tick(&mut self, square: u32, limit: u64) -> bool {
        self.partial = self.partial.saturating_add(u64::from(square));
        self.partial_ticks += 1;
        if self.partial_ticks >= self.whole_ticks {
            self.finish_part();
        }
        if self.sum <= limit {
            self.above_ticks = 0;
            self.flagged = self.flagged.map(|ticks| ticks.saturating_add(1));
            return false;
        }
        self.flagged = Some(0);
        self.above_ticks += 1;
        let counts = self.above_ticks == SECOND;
        self.above_ticks %= SECOND;
        counts
    }

    /// For how many ticks with this square and this limit nothing changes that anybody can read.
    #[must_use]
    pub fn quiet_ticks(&self, square: u32, limit: u64) -> u64 {
        let above = self.sum > limit;
        if above && self.flagged.is_none() {
            return 0;
        }
        let count = if above { SECOND.saturating_sub(self.above_ticks + 1) } else { u64::MAX };
        if self.is_settled(square) {
            return count;
        }
        count.min(self.whole_ticks.saturating_sub(self.partial_ticks + 1))
    }

    /// The same as so many calls of [`I2t::tick`], for at most [`I2t::quiet_ticks`].
    pub fn skip(&mut self, ticks: u64, square: u32, limit: u64) {
        if self.sum > limit {
            self.flagged = Some(0).filter(|_| ticks > 0).or(self.flagged);
            self.above_ticks = (self.above_ticks + ticks) % SECOND;
        } else if ticks > 0 {
            self.above_ticks = 0;
            self.flagged = self.flagged.map(|since| since.saturating_add(ticks));
        }
        // Parts that are finished meanwhile are those that stand there, or there would be none.
        let mut left = ticks % self.window_ticks;
        while left > 0 {
            let step = left.min(self.whole_ticks - self.partial_ticks);
            self.partial = self.partial.saturating_add(step.saturating_mul(u64::from(square)));
            self.partial_ticks += step;
            left -= step;
            if self.partial_ticks >= self.whole_ticks {
                self.finish_part();
            }
        }
    }

    /// Whether the whole window, and what is to follow, is of this square.
    fn is_settled(&self, square: u32) -> bool {
        let expected = |ticks: u64| ticks.saturating_mul(u64::from(square));
        let whole = |part| expected(part_ticks(self.window_ticks, part));
        self.partial == expected(self.partial_ticks)
            && self.parts.iter().enumerate().all(|(part, sum)| *sum == whole(part))
    }

    fn finish_part(&mut self) {
        if let Some(part) = self.parts.get_mut(self.part) {
            let before = core::mem::replace(part, self.partial);
            self.total = (self.total + u128::from(self.partial)).saturating_sub(u128::from(before));
            self.sum = u64::try_from(self.total).unwrap_or(u64::MAX);
        }
        self.part = (self.part + 1) % PARTS;
        self.whole_ticks = part_ticks(self.window_ticks, self.part);
        self.partial = 0;
        self.partial_ticks = 0;
    }
}

/// How long a part of a window takes: all of them together take the window, whatever does not divide.
const fn part_ticks(window_ticks: u64, part: usize) -> u64 {
    let part = part as u64;
    // 2³² ms are less than 2³⁷ ticks.
    let (start, end) = (window_ticks.saturating_mul(part), window_ticks.saturating_mul(part + 1));
    end / PARTS_U64 - start / PARTS_U64
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const NEVER: u64 = u64::MAX;

    fn run(monitor: &mut I2t, ticks: u64, square: u32, limit: u64) -> u64 {
        (0..ticks).map(|_| u64::from(monitor.tick(square, limit))).sum()
    }

    #[test]
    fn the_sum_is_that_of_the_window() {
        let window = 20_001;
        let mut monitor = I2t::new(window);
        run(&mut monitor, window, 9, NEVER);
        assert_eq!(monitor.sum(), 9 * window);
        run(&mut monitor, window / 2 + 1, 0, NEVER);
        let half = 9 * window / 2;
        assert!(monitor.sum().abs_diff(half) <= 9 * (window / 64 + 1), "{} of {half}", monitor.sum());
        run(&mut monitor, window, 0, NEVER);
        assert_eq!(monitor.sum(), 0);
    }

    #[test]
    fn a_window_too_short_is_64_ms() {
        for ticks in [0, 1, 63 * 20, SHORTEST_WINDOW] {
            let mut monitor = I2t::new(ticks);
            run(&mut monitor, 1279, 1, NEVER);
            assert_eq!(monitor.sum(), 1260, "63 parts of a millisecond");
            run(&mut monitor, 1, 1, NEVER);
            assert_eq!(monitor.sum(), 1280);
        }
    }

    #[test]
    fn each_second_above_the_limit_counts_and_a_sum_on_the_limit_does_not() {
        let mut monitor = I2t::new(0);
        assert_eq!(run(&mut monitor, 100_000, 1, 1280), 0);
        assert!(!monitor.is_flagged());
        assert_eq!(run(&mut monitor, 19_999, 1, 1279), 0);
        assert!(monitor.is_flagged());
        assert_eq!(run(&mut monitor, 1, 1, 1279), 1);
        assert_eq!(run(&mut monitor, 40_000, 1, 1279), 2);
    }

    #[test]
    fn the_flag_is_cleared_only_a_window_after_the_sum_fell() {
        let mut monitor = I2t::new(0);
        run(&mut monitor, 2000, 1, 1000);
        run(&mut monitor, 1, 1, 2000);
        for _ in 1..1280 {
            monitor.clear_flag();
            assert!(monitor.is_flagged());
            run(&mut monitor, 1, 1, 2000);
        }
        assert!(monitor.is_flagged(), "nobody cleared it");
        monitor.clear_flag();
        assert!(!monitor.is_flagged());
    }

    #[test]
    fn nothing_overflows() {
        let mut monitor = I2t::new(20 * u64::from(u32::MAX));
        let quiet = monitor.quiet_ticks(u32::MAX, NEVER);
        monitor.skip(quiet, u32::MAX, NEVER);
        run(&mut monitor, 2, u32::MAX, NEVER);
        assert_eq!(monitor.sum(), (quiet + 1) * u64::from(u32::MAX));
    }

    proptest! {
        /// Resting as long as it may is stepping, and nothing that can be read changes on the way.
        #[test]
        fn skipping_is_ticking(
            window in 0_u64..6000,
            phases in proptest::collection::vec((0_u32..4, 0_u64..9000, 0_u64..20_000, proptest::bool::ANY), 1..6),
        ) {
            let mut stepped = I2t::new(window);
            let mut skipped = stepped.clone();
            for (square, limit, mut ticks, clears) in phases {
                let counts = run(&mut stepped, ticks, square, limit);
                let mut counts_skipped = 0;
                while ticks > 0 {
                    let quiet = skipped.quiet_ticks(square, limit).min(ticks);
                    let before = (skipped.sum(), skipped.is_flagged());
                    skipped.skip(quiet, square, limit);
                    prop_assert_eq!(before, (skipped.sum(), skipped.is_flagged()));
                    ticks -= quiet;
                    if ticks > 0 {
                        counts_skipped += u64::from(skipped.tick(square, limit));
                        ticks -= 1;
                    }
                }
                prop_assert_eq!(counts, counts_skipped);
                if clears {
                    stepped.clear_flag();
                    skipped.clear_flag();
                }
                prop_assert_eq!(&stepped, &skipped);
            }
        }
    }
}
