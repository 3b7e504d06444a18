//! What is connected to a step/direction connector: whole pulses at a frequency, in whole numbers.
//!
//! The fraction of a pulse period that has passed is kept exactly, so that by any time `t` the whole part of `|f| · t` pulses
//! have come, however time is cut into pieces. A new frequency goes on with the fraction there is. A pulse is high for half a
//! period. With an acceleration the frequency changes by it in every control period, and falls in time for the last pulse.

use driver_chips::tmc5160::Edges;

use crate::TICK_NS;
use crate::parts::PulseParts;

/// The smallest frequency: 1 µHz.
const PER_HZ: f64 = 1e6;

/// Control periods in a second.
const PER_SECOND: f64 = (1_000_000_000 / TICK_NS) as f64;

/// Fractions in a pulse period: a source of 1 µHz adds one of them in a control period.
const PERIOD: u64 = 1_000_000 * (1_000_000_000 / TICK_NS);

const HALF: u64 = PERIOD / 2;

/// A pulse source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PulseSource {
    /// The frequency that it shall have, signed, in µHz, and the one it has.
    wanted_uhz: i64,
    frequency_uhz: i64,
    /// By how much the frequency may change in a control period; 0 = by any amount.
    acceleration: u64,
    /// Pulses until it falls silent; `None`: it never does.
    left: Option<u32>,
    /// STEP is high: the last pulse is not over.
    high: bool,
    /// The passed fraction of a pulse period.
    phase: u64,
    /// Pulses in the last control period, positive to the right.
    steps: i32,
    /// The edges of the last control period.
    edges: Span,
    /// Pulses to the right less those to the left.
    total: i64,
}

/// Edges half a pulse period apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Span {
    count: u64,
    /// Fractions until the first, and in the control period.
    to_first: u64,
    rate: u64,
    rising_first: bool,
    reverse: bool,
}

impl PulseSource {
    /// What is connected from the start.
    pub fn connected(parts: &PulseParts) -> Self {
        let mut source = Self::default();
        source.set_acceleration(parts.acceleration_hz_per_s);
        source.set_frequency(parts.frequency_hz);
        source.set_pulses(parts.pulses);
        source
    }

    /// Sets the frequency, to the nearest µHz, at most 1 GHz; negative is to the left.
    pub fn set_frequency(&mut self, frequency_hz: f64) {
        let limit = 1_000_000_000_000_000;
        self.wanted_uhz = (libm::round(frequency_hz * PER_HZ) as i64).clamp(-limit, limit);
        if self.acceleration == 0 {
            self.frequency_uhz = self.wanted_uhz;
        }
    }

    /// Sets how fast the frequency changes; 0 = at once.
    pub fn set_acceleration(&mut self, hz_per_s: f64) {
        self.acceleration = libm::round(hz_per_s * PER_HZ / PER_SECOND) as u64;
        self.start_from_rest();
        if self.acceleration == 0 {
            self.frequency_uhz = self.wanted_uhz;
        }
    }

    /// Lets it fall silent after so many pulses, the first of them a whole period from now; `None`: never.
    pub fn set_pulses(&mut self, pulses: Option<u32>) {
        self.start_from_rest();
        self.left = pulses;
        self.phase = 0;
    }

    /// Pulses in the last control period, positive to the right.
    pub fn steps(&self) -> i32 {
        self.steps
    }

    /// The edges on STEP in the last control period, which has so many clocks.
    pub fn edges(&self, clocks: u32) -> Edges {
        let Span { count, to_first, rate, rising_first, reverse } = self.edges;
        let clock = |fractions: u64| (fractions * u64::from(clocks) / rate.max(1)) as u32; // within the period
        Edges {
            count: count as u32,
            first_clock: clock(to_first),
            last_clock: clock(to_first + count.saturating_sub(1) * HALF),
            rising_first,
            reverse,
        }
    }

    /// Pulses to the right less those to the left, since the bench was switched on.
    pub fn total(&self) -> i64 {
        self.total
    }

    /// Nobody counted the pulses of the last control period.
    pub fn forget_steps(&mut self) {
        self.steps = 0;
        self.edges = Span::default();
    }

    /// Lets a control period pass.
    pub fn advance(&mut self) {
        self.accelerate();
        let (rate, to_first) = (self.rate(), self.until_edge());
        let count = if rate < to_first { 0 } else { 1 + (rate - to_first) / HALF };
        let count = count.min(self.edges_left());
        let reverse = self.frequency_uhz < 0;
        let edges = Span { count, to_first, rate, rising_first: !self.high, reverse };
        self.edges = if count > 0 { edges } else { Span::default() };
        let pulses = (count + u64::from(!self.high)) / 2;
        self.high ^= count % 2 == 1;
        self.phase = self.phase + rate - pulses * PERIOD;
        let pulses = i32::try_from(pulses).unwrap_or(i32::MAX);
        if let Some(left) = &mut self.left {
            *left -= pulses.unsigned_abs();
        }
        self.fall_silent();
        self.steps = if reverse { -pulses } else { pulses };
        self.total += i64::from(self.steps);
    }

    /// Lets control periods pass in which no pulse begins; one may end.
    pub fn rest(&mut self, periods: u64) {
        debug_assert!(periods < self.periods_to_pulse(), "a rest across a pulse");
        self.edges = Span::default();
        self.phase = self.phase.saturating_add(self.rate().saturating_mul(periods));
        self.high &= self.phase < HALF;
        self.fall_silent();
    }

    /// Control periods until the end of the one in which the next pulse begins; `u64::MAX` = never.
    pub fn periods_to_pulse(&self) -> u64 {
        if self.left == Some(0) { u64::MAX } else { self.periods_to(PERIOD) }
    }

    /// The same for the next edge.
    pub fn periods_to_edge(&self) -> u64 {
        if self.edges_left() == 0 { u64::MAX } else { self.periods_to(self.phase + self.until_edge()) }
    }

    fn periods_to(&self, phase: u64) -> u64 {
        if self.frequency_uhz != self.aimed_uhz() {
            return 1;
        }
        phase
            .saturating_sub(self.phase)
            .checked_next_multiple_of(self.rate())
            .map_or(u64::MAX, |missing| missing / self.rate())
    }

    /// Fractions until the next edge.
    fn until_edge(&self) -> u64 {
        if self.high { HALF.saturating_sub(self.phase) } else { PERIOD.saturating_sub(self.phase) }
    }

    /// Edges until it falls silent.
    fn edges_left(&self) -> u64 {
        self.left.map_or(u64::MAX, |left| 2 * u64::from(left) + u64::from(self.high))
    }

    /// After its last pulse it waits for more at the beginning of a period.
    fn fall_silent(&mut self) {
        if self.edges_left() == 0 {
            self.phase = 0;
            self.frequency_uhz = self.aimed_uhz();
        }
    }

    /// A ramp of a source that was silent begins at 0.
    fn start_from_rest(&mut self) {
        if self.acceleration > 0 && self.edges_left() == 0 {
            self.frequency_uhz = 0;
        }
    }

    fn accelerate(&mut self) {
        let missing = self.aimed_uhz() - self.frequency_uhz;
        let most = if self.acceleration == 0 { missing.unsigned_abs() } else { self.acceleration };
        let most = i64::try_from(most).unwrap_or(i64::MAX);
        self.frequency_uhz += missing.clamp(-most, most);
    }

    /// The frequency that is wanted, as far as it leaves room to slow down before the last pulse; none after it.
    fn aimed_uhz(&self) -> i64 {
        let Some(left) = self.left.filter(|_| self.acceleration > 0) else { return self.wanted_uhz };
        if self.edges_left() == 0 {
            return 0;
        }
        let hz_per_s = self.acceleration as f64 / PER_HZ * PER_SECOND;
        let limit_uhz = (libm::sqrt(2.0 * hz_per_s * f64::from(left.max(1))) * PER_HZ) as i64;
        self.wanted_uhz.clamp(-limit_uhz, limit_uhz)
    }

    /// Fractions in a control period.
    fn rate(&self) -> u64 {
        if self.edges_left() == 0 { 0 } else { self.frequency_uhz.unsigned_abs() }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

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

    /// Every edge with its clock since the beginning, at 12 MHz.
    fn edge_clocks(source: &mut PulseSource, periods: u32) -> Vec<(u32, bool)> {
        let mut clocks = Vec::new();
        for period in 0..periods {
            source.advance();
            let edges = source.edges(600);
            for index in 0..edges.count {
                let span = edges.last_clock - edges.first_clock;
                let clock = edges.first_clock + span * index / (edges.count - 1).max(1);
                clocks.push((period * 600 + clock, (index % 2 == 0) == edges.rising_first));
            }
        }
        clocks
    }

    #[test]
    fn a_pulse_is_high_for_half_a_period_and_the_last_one_ends() {
        let mut source = at(16_000.0);
        source.set_pulses(Some(40));
        let edges = edge_clocks(&mut source, 1000);
        assert_eq!(edges.len(), 80);
        for (index, (clock, rising)) in edges.iter().enumerate() {
            let expected = 750 + 375 * index as u32;
            assert!(clock.abs_diff(expected) <= 1, "{clock} of {expected}");
            assert_eq!(*rising, index % 2 == 0);
        }
        assert_eq!((source.total(), source.periods_to_edge()), (40, u64::MAX));
        source.set_pulses(Some(1));
        assert_eq!(edge_clocks(&mut source, 1000).len(), 2);
    }

    #[test]
    fn a_ramp_reaches_its_frequency_and_ends_with_its_last_pulse() {
        let mut source = PulseSource::default();
        source.set_acceleration(16_000.0);
        source.set_frequency(-16_000.0);
        source.set_pulses(Some(40_000));
        let edges = edge_clocks(&mut source, 100_000);
        assert_eq!((edges.len(), source.total()), (80_000, -40_000));
        let interval = |index: usize| edges[index + 2].0 - edges[index].0;
        assert_eq!(interval(40_000), 750, "16 kHz in the middle");
        // v = √(2 a n): 8 kHz, a half, after a quarter of the 8000 pulses of a ramp.
        assert!(interval(4000).abs_diff(1500) < 5, "{} clocks", interval(4000));
        assert!(interval(76_000).abs_diff(1500) < 15, "{} clocks", interval(76_000));
        assert!(interval(79_990) > 20_000, "slow at the end");
        assert_eq!(source.periods_to_edge(), u64::MAX);
    }

    #[test]
    fn every_edge_of_a_pulse_has_its_direction_and_a_new_ramp_begins_at_rest() {
        let mut source = at(-51_200.0);
        for acceleration in [0.0, 8000.0] {
            source.set_acceleration(acceleration);
            source.set_frequency(-8000.0);
            source.set_pulses(Some(100));
            let mut reversed = 0;
            for period in 0..10_000 {
                source.advance();
                let edges = source.edges(600);
                reversed += if edges.reverse { edges.count } else { 0 };
                assert!(acceleration == 0.0 || period > 200 || edges.count == 0, "√(2 / a) is 15 ms");
            }
            assert_eq!(reversed, 200);
        }
    }

    #[test]
    fn a_ramp_may_turn_round() {
        let mut source = PulseSource::default();
        source.set_acceleration(10_000.0);
        source.set_frequency(5000.0);
        edge_clocks(&mut source, 20_000);
        let there = source.total();
        assert_eq!(there, 1250 + 2500, "half a second of ramp, half a second at 5 kHz");
        source.set_frequency(-5000.0);
        edge_clocks(&mut source, 20_000);
        assert!((source.total() - there).abs() <= 1, "as far to the left as to the right");
    }
}
