//! A run, watched.

use super::expectation::Expectation;
use super::verdict::{Outcome, Verdict};
use super::watch::Watch;
use crate::TICK_NS;
use crate::bench::Bench;

/// Expectations about a run, and what came of them so far. Plain data: it can be cloned along with the bench.
///
/// The times that expectations name count from when the monitor was made; the times in verdicts are the bench's.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    watches: Vec<Watch>,
    /// As many as there are watches.
    verdicts: Vec<Verdict>,
    /// When the bench was looked at last.
    now_ns: u64,
}

impl Monitor {
    /// Watches `bench` from the end of the next control period on. Levels are noted now, so that a change from here on is a
    /// change.
    #[must_use]
    pub fn new(expectations: Vec<Expectation>, bench: &Bench) -> Self {
        let undecided = || Outcome::Undecided { reason: String::new() };
        let verdict =
            |expectation: &Expectation| Verdict { text: expectation.text().to_owned(), outcome: undecided() };
        let verdicts = expectations.iter().map(verdict).collect();
        let watch = |expectation| Watch::new(expectation, bench);
        let watches = expectations.into_iter().map(watch).collect();
        Self { watches, verdicts, now_ns: bench.time_ns() }
    }

    /// Looks at the bench. To be called after every control period in which something may have changed, and at
    /// [`Monitor::next_deadline_ns`]; [`Monitor::advance_to`] does that.
    pub fn observe(&mut self, bench: &Bench) {
        self.now_ns = bench.time_ns();
        for (watch, verdict) in self.watches.iter_mut().zip(&mut self.verdicts) {
            if !verdict.outcome.is_decided()
                && let Some(outcome) = watch.observe(bench)
            {
                verdict.outcome = outcome;
            }
        }
    }

    /// Runs `bench` on to `time_ns` and looks at it on the way, before the first control period too. Comes back early when the last
    /// expectation is decided; where nothing is left to decide from the start, the bench just runs on.
    pub fn advance_to(&mut self, bench: &mut Bench, time_ns: u64) {
        if self.is_decided() {
            bench.advance_to(time_ns);
            return;
        }
        self.observe(bench);
        while !self.is_decided() && time_ns.saturating_sub(bench.time_ns()) >= TICK_NS {
            let next_ns = self.next_deadline_ns().max(bench.time_ns() + TICK_NS);
            let until_ns = time_ns.min(next_ns);
            bench.advance_observed(until_ns, &mut |bench| {
                self.observe(bench);
                // What was seen may have brought a nearer deadline.
                !self.is_decided() && self.next_deadline_ns() >= until_ns
            });
        }
    }

    /// Whether every expectation held or failed.
    #[must_use]
    pub fn is_decided(&self) -> bool {
        self.verdicts.iter().all(|verdict| verdict.outcome.is_decided())
    }

    /// Whether something is undecided that the end of the run would not decide: a condition that may still be met, or a time
    /// that has not come.
    #[must_use]
    pub fn awaits_something(&self) -> bool {
        let watches = self.watches.iter().zip(&self.verdicts);
        watches.into_iter().any(|(watch, verdict)| !verdict.outcome.is_decided() && watch.is_waiting())
    }

    /// The next instant at which the bench must be looked at even if nothing changes until then; always later than the last
    /// look, and `u64::MAX` where there is none.
    #[must_use]
    pub fn next_deadline_ns(&self) -> u64 {
        let undecided =
            self.watches.iter().zip(&self.verdicts).filter(|(_, verdict)| !verdict.outcome.is_decided());
        undecided.map(|(watch, _)| watch.next_deadline_ns(self.now_ns)).min().unwrap_or(u64::MAX)
    }

    /// The run ends here: decides what is about its end, and says of the rest what the values were instead.
    ///
    /// What remains undecided: a condition that was not met but still might have been, and times that were not reached.
    pub fn finish(&mut self, bench: &Bench) {
        self.observe(bench);
        for (watch, verdict) in self.watches.iter().zip(&mut self.verdicts) {
            if !verdict.outcome.is_decided() {
                verdict.outcome = watch.finish(bench);
            }
        }
    }

    /// What came of every expectation so far, in the order they were given in.
    #[must_use]
    pub fn verdicts(&self) -> &[Verdict] {
        &self.verdicts
    }
}
