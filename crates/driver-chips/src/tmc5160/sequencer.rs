//! From edges on the step input to a place in the microstep table: the step counter, the measured step interval, and
//! MicroPlyer, which spreads a step over the interval that the last two steps had.

use super::ChopConf;
use crate::stepper::standstill::STANDSTILL_CLOCKS;
use crate::stepper::table::{Command, PERIOD, turn, vector};

/// The chip's clock.
pub const CLOCK_HZ: f64 = 12e6;

/// TSTEP of a motor that stands: no step for 2^20 clocks.
pub const STANDSTILL_TSTEP: u32 = (1 << 20) - 1;

/// Microsteps of a full step.
const FULL_STEP: u16 = 256;

/// Edges on the step input, evenly spaced, alternately rising and falling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Edges {
    /// How many.
    pub count: u32,
    /// When the first came, in clocks since the control period began.
    pub first_clock: u32,
    /// When the last came; the same for a single edge.
    pub last_clock: u32,
    /// The first one rises.
    pub rising_first: bool,
    /// The level of the direction input: the field turns from coil B towards coil A (decision: which level that is is a
    /// matter of wiring).
    pub reverse: bool,
}

/// Those of the edges that make steps.
struct Steps {
    count: u32,
    /// When the last came, and the one before it if there was one.
    last_clock: u32,
    before_clock: Option<u32>,
}

impl Edges {
    /// Every second edge makes a step, or with `dedge` each.
    fn steps(self, dedge: bool) -> Steps {
        let stride = if dedge { 1 } else { 2 };
        let skipped = u32::from(!dedge && !self.rising_first);
        let count = self.count.saturating_sub(skipped).div_ceil(stride);
        let last = skipped + count.saturating_sub(1) * stride;
        let before_clock = (count > 1).then(|| self.clock_of(last - stride));
        Steps { count, last_clock: self.clock_of(last), before_clock }
    }

    fn clock_of(self, index: u32) -> u32 {
        let span = u64::from(self.last_clock.saturating_sub(self.first_clock));
        let intervals = u64::from(self.count.saturating_sub(1).max(1));
        self.first_clock.saturating_add((span * u64::from(index) / intervals) as u32)
    }
}

/// The sequencer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sequencer {
    /// The microstep counter once the last step is done, 0 to 1023.
    target: u16,
    /// Microsteps of the last step, signed.
    step: i16,
    /// Clocks since the last step, at most those of a standstill.
    since_step: u32,
    /// Clocks between the last two steps, at most those of a standstill.
    interval: u32,
    vector: [i16; 2],
}

impl Default for Sequencer {
    /// After power-on the motor stands.
    fn default() -> Self {
        Self {
            target: 0,
            step: 0,
            since_step: STANDSTILL_CLOCKS,
            interval: STANDSTILL_CLOCKS,
            vector: [0, 0],
        }
    }
}

impl Sequencer {
    /// STST: no step for 2^20 clocks.
    pub(super) fn stands(&self) -> bool {
        self.since_step == STANDSTILL_CLOCKS
    }

    /// TSTEP: clocks between two microsteps of 1/256, as the last two steps had them; or more, if the next is overdue
    /// (decision).
    pub(super) fn tstep(&self) -> u32 {
        let interval = self.interval.max(self.since_step);
        if interval == STANDSTILL_CLOCKS {
            return STANDSTILL_TSTEP;
        }
        interval / u32::from(self.step.unsigned_abs().max(1))
    }

    /// MSCNT: where in the table it is now, 0 to 1023.
    pub(super) fn position(&self, chopconf: ChopConf) -> u16 {
        let missing = if chopconf.intpol { self.step - self.interpolated() } else { 0 };
        (i32::from(self.target) - i32::from(missing)).rem_euclid(PERIOD) as u16
    }

    /// MicroPlyer: how much of the last step is done. The first microstep comes with the step's edge, and the last not later
    /// than 2^20 clocks after it.
    fn interpolated(&self) -> i16 {
        let size = u64::from(self.step.unsigned_abs());
        let done = (u64::from(self.since_step) * size / u64::from(self.interval.max(1)) + 1).min(size);
        self.step.signum() * done as i16
    }

    /// Takes the edges of a control period of so many clocks.
    pub(super) fn count(&mut self, edges: &[Edges], chopconf: ChopConf, shaft: bool, clocks: u32) {
        let mut now = 0;
        for edges in edges {
            let steps = edges.steps(chopconf.dedge);
            if steps.count == 0 {
                continue;
            }
            // Edges out of order or beyond the period are as late as they can be.
            let at = steps.last_clock.clamp(now, clocks);
            self.interval = match steps.before_clock {
                Some(before) => at - before.clamp(now, at),
                None => self.since_step.saturating_add(at - now),
            }
            .clamp(1, STANDSTILL_CLOCKS);
            let size = 1 << chopconf.mres.min(8);
            self.step = if edges.reverse == shaft { size } else { -size };
            let microsteps = i32::from(self.step) * (steps.count % PERIOD.unsigned_abs()).cast_signed();
            self.target = (i32::from(self.target) + microsteps).rem_euclid(PERIOD) as u16;
            (self.since_step, now) = (0, at);
        }
        self.since_step = (self.since_step + (clocks - now)).min(STANDSTILL_CLOCKS);
    }

    /// The commanded vector at the end of the control period; in full steps it points to the middle of its quadrant.
    pub(super) fn command(&mut self, chopconf: ChopConf, full_steps: bool) -> Command {
        let position = self.position(chopconf);
        let position = if full_steps { position / FULL_STEP * FULL_STEP + FULL_STEP / 2 } else { position };
        let before = self.vector;
        self.vector = vector(position);
        Command {
            vector: self.vector,
            before,
            changed: before != self.vector,
            direction: turn(before, self.vector),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn resolution(mres: u8) -> ChopConf {
        ChopConf { mres, ..ChopConf::default() }
    }

    fn interpolating(mres: u8) -> ChopConf {
        ChopConf { intpol: true, ..resolution(mres) }
    }

    fn pulse(clock: u32) -> Edges {
        Edges { count: 1, first_clock: clock, last_clock: clock, rising_first: true, reverse: false }
    }

    /// A pulse every so many clocks, the first after as many, through control periods of 600.
    fn run(sequencer: &mut Sequencer, chopconf: ChopConf, interval: u32, pulses: u32) {
        let mut next = interval;
        for period in 0..pulses * interval / 600 + 1 {
            let begin = period * 600;
            let here: [Edges; 1] = if next < begin + 600 && next <= pulses * interval {
                [pulse(next - begin)]
            } else {
                [Edges::default()]
            };
            next += if here[0].count == 1 { interval } else { 0 };
            sequencer.count(&here, chopconf, false, 600);
        }
    }

    #[test]
    fn tstep_is_the_step_interval_in_clocks_of_a_256th_microstep() {
        for (mres, interval, tstep) in [(4, 750, 46), (4, 7500, 468), (0, 1200, 1200), (8, 60_000, 234)] {
            let mut sequencer = Sequencer::default();
            assert_eq!(sequencer.tstep(), STANDSTILL_TSTEP);
            run(&mut sequencer, resolution(mres), interval, 1);
            assert_eq!(sequencer.tstep(), STANDSTILL_TSTEP, "one step has no interval yet");
            run(&mut sequencer, resolution(mres), interval, 20);
            assert_eq!(sequencer.tstep(), tstep, "{interval} clocks at 2^{mres}");
        }
    }

    #[test]
    fn after_2_to_the_20_clocks_without_a_step_it_stands() {
        let mut sequencer = Sequencer::default();
        run(&mut sequencer, resolution(4), 6000, 3);
        assert_eq!(sequencer.tstep(), 375);
        let left = (1 << 20) - sequencer.since_step;
        sequencer.count(&[], resolution(4), false, left - 1);
        assert!(!sequencer.stands());
        assert_eq!(sequencer.tstep(), 65_535, "the next step is overdue");
        sequencer.count(&[], resolution(4), false, 1);
        assert!(sequencer.stands());
        assert_eq!(sequencer.tstep(), STANDSTILL_TSTEP);
    }

    #[test]
    fn the_interval_of_many_steps_in_a_period_is_that_of_the_last_two() {
        let mut sequencer = Sequencer::default();
        let edges = Edges { count: 10, first_clock: 20, last_clock: 560, rising_first: true, reverse: false };
        sequencer.count(&[edges], resolution(2), false, 600);
        assert_eq!((sequencer.interval, sequencer.target), (120, 20), "five rising edges, 120 clocks apart");
        assert_eq!(sequencer.since_step, 600 - 500);
        let both = ChopConf { dedge: true, ..resolution(2) };
        let edges = Edges { rising_first: false, ..edges };
        sequencer.count(&[edges], both, false, 600);
        assert_eq!((sequencer.interval, sequencer.target), (60, 60), "all ten, 60 clocks apart");
        sequencer.count(&[edges], resolution(2), false, 600);
        assert_eq!((sequencer.since_step, sequencer.target), (40, 80), "the second, and so on to the last");
    }

    #[test]
    fn interpolated_microsteps_are_evenly_spaced_and_done_with_the_next_step() {
        let (mut sequencer, chopconf) = (Sequencer::default(), interpolating(4));
        for _ in 0..5 {
            sequencer.count(&[pulse(0)], chopconf, false, 4800);
        }
        assert_eq!(sequencer.position(chopconf), 80);
        // Now 16 microsteps of 300 clocks each, the first with the edge.
        sequencer.count(&[pulse(0)], chopconf, false, 0);
        for microstep in 1..=16 {
            assert_eq!(sequencer.position(chopconf), 80 + microstep);
            sequencer.count(&[], chopconf, false, 299);
            assert_eq!(sequencer.position(chopconf), 80 + microstep);
            sequencer.count(&[], chopconf, false, 1);
        }
        assert_eq!(sequencer.position(chopconf), 96, "and there it waits");
    }

    #[test]
    fn a_step_that_comes_early_cuts_the_one_before_short() {
        let (mut sequencer, chopconf) = (Sequencer::default(), interpolating(4));
        for _ in 0..3 {
            sequencer.count(&[pulse(0)], chopconf, false, 4800);
        }
        sequencer.count(&[pulse(0)], chopconf, false, 1200);
        assert_eq!(sequencer.position(chopconf), 48 + 5, "a quarter of the interval");
        sequencer.count(&[pulse(0)], chopconf, false, 0);
        assert_eq!(sequencer.position(chopconf), 64 + 1, "a small jump");
        sequencer.count(&[], chopconf, false, 600);
        assert_eq!(sequencer.position(chopconf), 64 + 9, "now at the pace of 1200 clocks a step");
    }

    #[test]
    fn a_step_out_of_standstill_takes_2_to_the_20_clocks() {
        let (mut sequencer, chopconf) = (Sequencer::default(), interpolating(4));
        sequencer.count(&[pulse(0)], chopconf, false, 1 << 19);
        assert_eq!(sequencer.position(chopconf), 9);
        sequencer.count(&[], chopconf, false, 1 << 19);
        assert_eq!(sequencer.position(chopconf), 16);
        assert!(sequencer.stands());
    }

    #[test]
    fn full_steps_point_to_the_middle_of_their_quadrant() {
        let (mut sequencer, chopconf) = (Sequencer::default(), resolution(4));
        for step in 0..64_u16 {
            let position = sequencer.position(chopconf);
            assert_eq!(position, 16 * step);
            let [a, b] = sequencer.command(chopconf, true).vector;
            assert!((a.abs() - b.abs()).abs() <= 1 && (175..=176).contains(&a.abs()), "{a}, {b}");
            assert_eq!((a > 0, b > 0), ([0, 3].contains(&(position / 256)), position < 512));
            sequencer.count(&[pulse(0)], chopconf, false, 600);
        }
    }

    fn any_edges() -> impl Strategy<Value = Edges> {
        (0..40_u32, 0..600_u32, 0..600_u32, any::<[bool; 2]>()).prop_map(
            |(count, one, other, [rising_first, reverse])| Edges {
                count,
                first_clock: one.min(other),
                last_clock: one.max(other),
                rising_first,
                reverse,
            },
        )
    }

    proptest! {
        /// Whatever the order of directions, edges and resolutions: the counter is the sum of what each step was worth.
        #[test]
        fn no_step_is_lost(
            periods in prop::collection::vec(
                (prop::collection::vec(any_edges(), 0..3), 0..9_u8, any::<[bool; 3]>()), 1..40,
            ),
        ) {
            let (mut sequencer, mut expected) = (Sequencer::default(), 0_i64);
            for (bursts, mres, [dedge, intpol, shaft]) in periods {
                let chopconf = ChopConf { mres, dedge, intpol, ..ChopConf::default() };
                sequencer.count(&bursts, chopconf, shaft, 600);
                for edges in bursts {
                    let rising = (0..edges.count).filter(|index| (index % 2 == 0) == edges.rising_first);
                    let steps = if dedge { i64::from(edges.count) } else { rising.count() as i64 };
                    expected += if edges.reverse == shaft { steps << mres } else { -(steps << mres) };
                }
                let target = expected.rem_euclid(1024);
                prop_assert_eq!(i64::from(sequencer.target), target);
                let behind = (target - i64::from(sequencer.position(chopconf))).rem_euclid(1024);
                let size = i64::from(sequencer.step.unsigned_abs());
                prop_assert!(behind < size.max(1) || 1024 - behind < size, "by more than a step: {}", behind);
            }
            sequencer.count(&[], interpolating(0), false, 1 << 20);
            prop_assert_eq!(i64::from(sequencer.position(interpolating(0))), expected.rem_euclid(1024));
        }
    }
}
