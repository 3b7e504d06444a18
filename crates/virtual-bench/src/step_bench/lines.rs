//! STEP and DIR where wires or a recording drive them, edge by edge.

use std::sync::Arc;

use driver_chips::tmc5160::Edges;

use super::PERIOD_CLOCKS;
use crate::TICK_NS;
use crate::config::RecordedLevels;
use bench_hardware::PulseLevels;

/// The two lines.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Lines {
    levels: PulseLevels,
    recording: Arc<[RecordedLevels]>,
    /// The recorded levels that come next.
    next: usize,
    /// An edge that a wire brought, which the next control period begins with.
    pending: Option<Edges>,
    /// Rising edges with DIR low less those with DIR high.
    total: i64,
}

impl Lines {
    /// With a recording to be played.
    pub(super) fn playing(recording: &[RecordedLevels]) -> Self {
        Self { recording: recording.into(), ..Self::default() }
    }

    pub(super) fn levels(&self) -> PulseLevels {
        self.levels
    }

    pub(super) fn total(&self) -> i64 {
        self.total
    }

    pub(super) fn set_dir(&mut self, high: bool) {
        self.levels.dir = high;
    }

    /// What a wire brings acts with the next control period.
    pub(super) fn set_step(&mut self, high: bool) {
        self.pending = self.step(high, 0).or(self.pending);
    }

    /// Appends the edges of the control period that begins at `from_ns`.
    pub(super) fn take(&mut self, from_ns: u64, edges: &mut Vec<Edges>) {
        edges.extend(self.pending.take());
        while let Some(levels) =
            self.recording.get(self.next).filter(|levels| levels.at_ns < from_ns + TICK_NS)
        {
            let RecordedLevels { at_ns, step, dir } = *levels;
            self.next += 1;
            self.levels.dir = dir;
            let clock = at_ns.saturating_sub(from_ns) * u64::from(PERIOD_CLOCKS) / TICK_NS;
            edges.extend(self.step(step, clock as u32)); // within the period
        }
    }

    /// The end of the control period in which the next recorded levels come.
    pub(super) fn next_change_ns(&self) -> u64 {
        self.recording.get(self.next).map_or(u64::MAX, |levels| (levels.at_ns / TICK_NS + 1) * TICK_NS)
    }

    /// The edge that a level of STEP makes. DIR is low to the right (decision).
    fn step(&mut self, high: bool, clock: u32) -> Option<Edges> {
        if high == self.levels.step {
            return None;
        }
        self.levels.step = high;
        let reverse = self.levels.dir;
        if high {
            self.total += if reverse { -1 } else { 1 };
        }
        Some(Edges { count: 1, first_clock: clock, last_clock: clock, rising_first: high, reverse })
    }
}
