//! The speed of a shaft from the counter of its quadrature encoder or its hall sensors, read each control period (a
//! decision; the manual says only that speed is measured with the encoder, TMCM-1311 §6 parameter 131).
//!
//! Speed is a distance between two edges over the time between them, so that only the moment of an edge is uncertain, by a
//! period each. The two are the latest edge and the oldest one of a window of time, or in slow motion the last two edges. An
//! edge counts as what it is, a place between two counts: up from 4 to 5 and down from 5 to 4 are the same place. A counter
//! that dithers between two counts therefore shows no speed at all.
//!
//! Time is cut into bins of 5 periods, of which up to 64 are kept, each with its first edge. A word with a bit for each bin
//! finds the oldest without a search, and nothing is divided: a speed stays a fraction.
//!
//! This module must never know what the counter is mounted on, nor units of speed.

/// Control periods in a bin, and those [`Tachometer::recent_counts`] looks back.
const BIN_TICKS: usize = 5;

/// A speed as counts over control periods of 50 µs; 0 counts: standing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountRate {
    /// Counts, positive where its counter rises.
    pub counts: i32,
    /// The control periods they take, never 0.
    pub ticks: u32,
}

impl CountRate {
    /// No motion.
    pub const STANDING: Self = Self { counts: 0, ticks: 1 };
}

/// Where and when the counter changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Edge {
    /// The upper one of the two counts it lies between.
    position: i32,
    tick: u32,
}

/// The state of the measurement.
///
/// `BINS` is the window in bins of 250 µs, with the one that is being filled: 1 to 64. Without an edge for
/// `STANDSTILL_TICKS` control periods the shaft stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tachometer<const BINS: usize, const STANDSTILL_TICKS: u32> {
    count: i32,
    /// Counts control periods from the start of a motion on, and wraps.
    tick: u32,
    /// The last edge, none while at rest, and the one before it.
    edge: Option<Edge>,
    previous: Option<Edge>,
    /// The first edge of each bin, where `occupied` says there is one.
    bins: [Edge; BINS],
    bin: usize,
    /// Bit n: whether there was an edge n bins ago.
    occupied: u64,
    /// The control period within the bin.
    phase: usize,
    /// The counts of the last periods.
    counts: [i32; BIN_TICKS],
    recent_counts: i32,
}

impl<const BINS: usize, const STANDSTILL_TICKS: u32> Tachometer<BINS, STANDSTILL_TICKS> {
    /// The bits of `occupied` that stand for a bin. Evaluated at compile time: other numbers of bins do not compile.
    const BIN_MASK: u64 = u64::MAX >> (64 - BINS);

    /// The shortest time a distance is divided by, an eighth of the window: edges that come close together once are no
    /// speed. In even motion the edges within the window are never so close.
    const SHORTEST_BASE_TICKS: u32 = (BINS * BIN_TICKS).div_ceil(8) as u32;

    /// Standing at this count.
    #[must_use]
    pub const fn new(count: i32) -> Self {
        Self {
            count,
            tick: 0,
            edge: None,
            previous: None,
            bins: [Edge { position: 0, tick: 0 }; BINS],
            bin: 0,
            occupied: 0,
            phase: 0,
            counts: [count; BIN_TICKS],
            recent_counts: 0,
        }
    }

    /// One control period, at whose end the counter reads `count`. It may wrap.
    pub fn tick(&mut self, count: i32) {
        let moved = count.wrapping_sub(self.count);
        if moved == 0 && self.is_at_rest() {
            return;
        }
        self.advance();
        self.count = count;
        if let Some(oldest) = self.counts.get_mut(self.phase) {
            self.recent_counts = count.wrapping_sub(*oldest);
            *oldest = count;
        }
        if moved != 0 {
            let position = if moved > 0 { count } else { count.wrapping_add(1) };
            self.record(Edge { position, tick: self.tick });
        } else if self.edge.is_some_and(|edge| self.ticks_since(edge) >= STANDSTILL_TICKS) {
            // All rest is alike: nothing of the motion before is left to read.
            *self = Self::new(count);
        }
    }

    /// The speed. Where an edge is long overdue it falls with the time since the last one, in which less than a count was
    /// moved, and it is 0 after the standstill time without one.
    #[must_use]
    pub fn rate(&self) -> CountRate {
        let Some((edge, reference)) = self.edge.zip(self.reference()) else {
            return CountRate::STANDING;
        };
        let counts = edge.position.wrapping_sub(reference.position);
        let ticks = edge.tick.wrapping_sub(reference.tick).max(Self::SHORTEST_BASE_TICKS);
        let idle_ticks = self.ticks_since(edge);
        // Overdue is twice as long as a count takes. Shorter pauses come with uneven motion; to cut only those would read too
        // low on average.
        if counts.unsigned_abs().saturating_mul(idle_ticks) / 2 > ticks {
            return CountRate { counts: counts.signum(), ticks: idle_ticks };
        }
        CountRate { counts, ticks }
    }

    /// Counts moved in the last 5 control periods (250 µs), for the damping of standstill (TMCM-1311 §8.5).
    #[must_use]
    pub fn recent_counts(&self) -> i32 {
        self.recent_counts
    }

    /// Whether another period with the same count changes nothing at all: there was no edge for the standstill
    /// time, or none yet.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.edge.is_none()
    }

    /// The same as so many calls of [`Tachometer::tick`] with the count that stands there. [At rest](Tachometer::is_at_rest)
    /// that is nothing; before, the periods until rest are ticked.
    pub fn skip(&mut self, ticks: u64) {
        let mut left = ticks;
        while left > 0 && !self.is_at_rest() {
            self.tick(self.count);
            left -= 1;
        }
    }

    /// The edge to measure the last one from: the oldest in the bins, or the one before if that is the last one itself.
    fn reference(&self) -> Option<Edge> {
        let age = self.occupied.checked_ilog2().map(|age| age as usize);
        let oldest = age.and_then(|age| self.bins.get((self.bin + BINS - age) % BINS)).copied();
        oldest.filter(|oldest| self.edge.is_some_and(|edge| edge.tick != oldest.tick)).or(self.previous)
    }

    fn ticks_since(&self, edge: Edge) -> u32 {
        self.tick.wrapping_sub(edge.tick)
    }

    fn advance(&mut self) {
        self.tick = self.tick.wrapping_add(1);
        self.phase += 1;
        if self.phase >= BIN_TICKS {
            self.phase = 0;
            self.bin = (self.bin + 1) % BINS;
            self.occupied = (self.occupied << 1) & Self::BIN_MASK;
        }
    }

    fn record(&mut self, edge: Edge) {
        self.previous = self.edge.replace(edge);
        if self.occupied & 1 == 0
            && let Some(first) = self.bins.get_mut(self.bin)
        {
            *first = edge;
            self.occupied |= 1;
        }
    }
}

#[cfg(test)]
mod tests;
