//! An incremental encoder: two lines in quadrature, an index pulse, and the counter that follows them.
//!
//! The counter follows what the lines show, not the shaft: when a line breaks it stops counting, as a real one does.

/// How an encoder is built and mounted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderConfig {
    /// Counts in a turn: four for each line of the disc.
    pub counts_per_turn: u32,
    /// Where the shaft stands at the index pulse.
    pub offset_turns: f64,
    /// Whether it counts down while the shaft turns to the right: A and B swapped.
    pub inverted: bool,
}

/// What is broken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EncoderFault {
    /// Nothing.
    #[default]
    None,
    /// Line A stays low: the counter dithers between two counts.
    LineA,
    /// Line B stays low: the counter dithers between two counts.
    LineB,
    /// The index never comes.
    Index,
}

/// What the counter says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderSample {
    /// Counts since power-on; wraps.
    pub counts: i32,
    /// Whether the index pulse came since the last sample.
    pub index_passed: bool,
}

/// An encoder and its counter.
#[derive(Clone, Debug, PartialEq)]
pub struct Encoder {
    config: EncoderConfig,
    /// What is broken; may be changed in operation.
    pub fault: EncoderFault,
    /// Quarter periods of the disc's lines since the index, as the disc stands.
    disc: i64,
    /// The quarter period that the lines show, 0 to 3.
    shown: i64,
    counts: i32,
}

impl Encoder {
    /// An encoder that is switched on with the shaft at `turns`: the counter starts at 0.
    #[must_use]
    pub fn new(config: EncoderConfig, turns: f64) -> Self {
        let disc = config.disc(turns);
        Self { config, fault: EncoderFault::None, disc, shown: disc.rem_euclid(4), counts: 0 }
    }

    /// How it is built and mounted.
    #[must_use]
    pub fn config(&self) -> EncoderConfig {
        self.config
    }

    /// Follows the shaft to `turns`. However far it went, no count is lost.
    pub fn sample(&mut self, turns: f64) -> EncoderSample {
        let (before, after) = (self.disc, self.config.disc(turns));
        let broken = quarter(before, self.fault);
        self.counts = self.counts.wrapping_add(step(self.shown, broken)); // a line just broke, or was mended
        self.shown = quarter(after, self.fault);
        let moved = match self.fault {
            EncoderFault::None | EncoderFault::Index => (after - before) as i32, // wraps, as the counter does
            EncoderFault::LineA | EncoderFault::LineB => step(broken, self.shown),
        };
        self.counts = self.counts.wrapping_add(moved);
        self.disc = after;
        let index_passed = self.fault != EncoderFault::Index && self.config.index_between(before, after);
        EncoderSample { counts: self.counts, index_passed }
    }
}

impl EncoderConfig {
    fn disc(&self, turns: f64) -> i64 {
        let turned = turns - self.offset_turns;
        let turned = if self.inverted { -turned } else { turned };
        floor(turned * f64::from(self.counts_per_turn))
    }

    /// Whether the disc enters the index, one count wide, on its way.
    fn index_between(&self, before: i64, after: i64) -> bool {
        let counts_per_turn = i64::from(self.counts_per_turn.max(1));
        if after > before {
            before.rem_euclid(counts_per_turn) + (after - before) >= counts_per_turn
        } else {
            (before - 1).rem_euclid(counts_per_turn) < before - after
        }
    }
}

/// The whole number at or below `value`.
fn floor(value: f64) -> i64 {
    let towards_zero = value as i64;
    towards_zero - i64::from(towards_zero as f64 > value)
}

/// The quarter period that lines A and B show: 00, 10, 11, 01 for 0 to 3.
fn quarter(disc: i64, fault: EncoderFault) -> i64 {
    match (fault, disc.rem_euclid(4)) {
        (EncoderFault::LineA, 1) | (EncoderFault::LineB, 3) => 0,
        (EncoderFault::LineA, 2) => 3,
        (EncoderFault::LineB, 2) => 1,
        (_, quarter) => quarter,
    }
}

/// What a counter makes of one quarter period following another; 0 if both lines changed at once.
fn step(before: i64, after: i64) -> i32 {
    match (after - before).rem_euclid(4) {
        1 => 1,
        3 => -1,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    const PLAIN: EncoderConfig = EncoderConfig { counts_per_turn: 4096, offset_turns: 0.0, inverted: false };

    #[test]
    fn it_counts_exactly_over_millions_of_turns() {
        let config = EncoderConfig { counts_per_turn: 40_000, ..PLAIN };
        let mut encoder = Encoder::new(config, 0.0);
        for turns in [5_000_000.25, -7_000_000.5] {
            let expected = (turns * 40_000.0) as i64 as i32;
            assert_eq!(encoder.sample(turns).counts, expected);
        }
        assert_eq!(encoder.sample(0.0).counts, 0);
    }

    #[test]
    fn the_index_comes_once_a_turn_both_ways() {
        let mut encoder = Encoder::new(EncoderConfig { offset_turns: 0.25, ..PLAIN }, 0.0);
        let forth: Vec<_> =
            (1..=30).filter(|step| encoder.sample(f64::from(*step) * 0.1).index_passed).collect();
        assert_eq!(forth, [3, 13, 23]);
        let back: Vec<_> =
            (0..30).rev().filter(|step| encoder.sample(f64::from(*step) * 0.1).index_passed).collect();
        assert_eq!(back, [22, 12, 2]);
    }

    #[test]
    fn the_index_stands_at_the_same_count_both_ways() {
        let count = |turns: f64| turns / 4096.0;
        let mut encoder = Encoder::new(PLAIN, count(-2.5));
        let forth = [-1.5, -0.5, 0.5, 1.5].map(|at| encoder.sample(count(at)).index_passed);
        assert_eq!(forth, [false, false, true, false]);
        let back = [0.5, -0.5, -1.5].map(|at| encoder.sample(count(at)).index_passed);
        assert_eq!(back, [true, false, false]);
    }

    #[test]
    fn a_dead_index_never_comes_and_counting_goes_on() {
        let mut encoder = Encoder::new(PLAIN, 0.5);
        encoder.fault = EncoderFault::Index;
        assert_eq!(encoder.sample(2.5), EncoderSample { counts: 8192, index_passed: false });
    }

    #[test]
    fn a_mended_line_counts_again_from_where_the_counter_stood() {
        let mut encoder = Encoder::new(PLAIN, 0.0);
        encoder.sample(0.5);
        encoder.fault = EncoderFault::LineA;
        let stuck = encoder.sample(100.0).counts;
        encoder.fault = EncoderFault::None;
        let mended = encoder.sample(100.5).counts;
        assert!((mended - stuck - 2048).abs() <= 1, "{mended} after {stuck}");
    }

    proptest! {
        #[test]
        fn there_and_back_is_where_it_was(
            counts_per_turn in 1_u32..100_000,
            offset_turns in -1.0..1.0,
            inverted: bool,
            start in -1e6..1e6,
            way in proptest::collection::vec(-1e6..1e6, 0..20),
        ) {
            let mut encoder = Encoder::new(EncoderConfig { counts_per_turn, offset_turns, inverted }, start);
            let power_on = encoder.clone();
            for turns in way {
                let sample = encoder.sample(turns);
                prop_assert_eq!(encoder.sample(turns), EncoderSample { index_passed: false, ..sample });
            }
            encoder.sample(start);
            prop_assert_eq!(encoder, power_on);
        }

        #[test]
        fn counting_up_means_turning_right_unless_inverted(inverted: bool, start in -100.0..100.0, way in 0.01_f64..10.0) {
            let mut encoder = Encoder::new(EncoderConfig { inverted, ..PLAIN }, start);
            let counts = f64::from(encoder.sample(start + way).counts);
            let expected = 4096.0 * if inverted { -way } else { way };
            prop_assert!((counts - expected).abs() <= 1.0, "{} instead of {}", counts, expected);
        }

        #[test]
        fn with_a_dead_line_the_counter_dithers_between_two_counts(
            line_a: bool,
            start in -1.0..1.0,
            way in proptest::collection::vec(-3.0..3.0, 1..50),
        ) {
            let mut encoder = Encoder::new(PLAIN, start);
            encoder.fault = if line_a { EncoderFault::LineA } else { EncoderFault::LineB };
            let counts: Vec<_> = way.into_iter().map(|turns| encoder.sample(turns).counts).collect();
            let (low, high) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
            prop_assert!(high - low <= 1 && low.abs() <= 2, "{:?}", counts);
        }
    }
}
