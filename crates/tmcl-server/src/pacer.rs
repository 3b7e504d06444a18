//! Virtual time that follows the wall clock, `speed` times as fast.

use std::time::{Duration, Instant};

use virtual_bench::{Bench, TICK_NS};

use crate::state::{State, StateError};

/// How far virtual time may fall behind before it slips: it never sprints to catch up.
const PATIENCE: Duration = Duration::from_millis(100);

/// How long one catching-up may take: whoever waits for the bench waits no longer than this.
const SLICE: Duration = Duration::from_micros(80);

/// Control periods of one module between two looks at the clock.
const TICKS_PER_LOOK: usize = 16;

/// How a bench is run on to an instant: plainly, or with somebody looking on.
pub type Advance = Box<dyn FnMut(&mut Bench, u64) + Send>;

/// A bench and the clock it follows.
pub(crate) struct Paced {
    pub(crate) bench: Bench,
    /// Where its EEPROMs are kept, if they are.
    pub(crate) state: Option<State>,
    advance: Advance,
    speed: f64,
    /// The instant at which virtual time was `origin_ns`.
    origin: Instant,
    origin_ns: u64,
}

/// How a catching-up ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CaughtUp {
    /// Virtual time is where it should be.
    Yes,
    /// There is more to do; others may go first.
    NotYet,
    /// The machine is too slow: this much wall-clock time was given up.
    Slipped(Duration),
}

impl Paced {
    pub(crate) fn new(bench: Bench, speed: f64, advance: Advance, now: Instant) -> Self {
        let origin_ns = bench.time_ns();
        Self { bench, state: None, advance, speed, origin: now, origin_ns }
    }

    /// Writes what the EEPROMs took to their files.
    pub(crate) fn save(&mut self) -> Result<(), StateError> {
        self.state.as_mut().map_or(Ok(()), |state| state.save(&mut self.bench))
    }

    /// Runs the bench towards the present, for a slice of time at most.
    pub(crate) fn catch_up(&mut self, now: Instant) -> CaughtUp {
        let target_ns = self.virtual_ns(now);
        while target_ns.saturating_sub(self.bench.time_ns()) >= TICK_NS {
            let look_ns = self.bench.time_ns().saturating_add(self.ticks_to_look() * TICK_NS);
            (self.advance)(&mut self.bench, target_ns.min(look_ns));
            if now.elapsed() > SLICE {
                return self.unfinished(now, target_ns);
            }
        }
        CaughtUp::Yes
    }

    /// Control periods until the next look at the clock: the fewer the more modules move.
    fn ticks_to_look(&self) -> u64 {
        let modules = if self.bench.is_at_rest() { 1 } else { self.bench.modules().count().max(1) };
        u64::try_from(TICKS_PER_LOOK / modules).unwrap_or(1).max(1)
    }

    /// Slips when too far behind.
    fn unfinished(&mut self, now: Instant, target_ns: u64) -> CaughtUp {
        let behind_ns = target_ns.saturating_sub(self.bench.time_ns());
        let behind = Duration::from_secs_f64(Duration::from_nanos(behind_ns).as_secs_f64() / self.speed);
        if behind <= PATIENCE {
            return CaughtUp::NotYet;
        }
        (self.origin, self.origin_ns) = (now, self.bench.time_ns());
        CaughtUp::Slipped(behind)
    }

    fn virtual_ns(&self, now: Instant) -> u64 {
        let elapsed_ns = now.saturating_duration_since(self.origin).as_nanos() as f64 * self.speed;
        self.origin_ns.saturating_add(elapsed_ns as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paced(speed: f64, start: Instant) -> Paced {
        Paced::new(Bench::default(), speed, Box::new(Bench::advance_to), start)
    }

    #[test]
    fn virtual_time_is_wall_time_times_speed() {
        let start = Instant::now();
        let mut paced = paced(2.0, start);
        assert_eq!(paced.catch_up(start + Duration::from_millis(10)), CaughtUp::Yes);
        assert_eq!(paced.bench.time_ns(), 20_000_000);
    }

    #[test]
    fn what_cannot_be_caught_up_is_given_up_not_sprinted_after() {
        let start = Instant::now() - Duration::from_secs(3600);
        let mut paced = paced(1000.0, start);
        let now = Instant::now();
        let slipped = (0..1_000_000).find_map(|_| match paced.catch_up(now) {
            CaughtUp::Slipped(by) => Some(by),
            CaughtUp::Yes | CaughtUp::NotYet => None,
        });
        assert!(slipped.is_some_and(|by| by > PATIENCE));
        // From here on virtual time goes on from where it is.
        let reached_ns = paced.bench.time_ns();
        assert!(paced.virtual_ns(now) <= reached_ns + TICK_NS);
    }
}
