//! One expectation, watched.

use super::condition::{Comparison, Condition, Edge, Operand, Sides, described};
use super::expectation::{Expectation, Rule, Timing, Window};
use super::show;
use super::verdict::Outcome;
use crate::TICK_NS;
use crate::bench::Bench;

/// An expectation and what was seen so far.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Watch {
    expectation: Expectation,
    start_ns: u64,
    /// Whether what it looks at changes while everything is at rest.
    changes_at_rest: bool,
    /// Edges: what the quantity was when it was looked at last, and before.
    last: f64,
    before: f64,
    /// Since when the condition is met without a break.
    since_ns: Option<u64>,
    longest: Option<Stretch>,
    nearest: Option<Nearest>,
}

/// How long the condition was met without a break.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    from_ns: u64,
    length_ns: u64,
}

/// Where a comparison came nearest to holding.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Nearest {
    distance: f64,
    sides: Sides,
    at_ns: u64,
}

impl Watch {
    /// Looks at the bench for the first time; edges are seen from here on.
    pub(super) fn new(expectation: Expectation, bench: &Bench) -> Self {
        let last = match &expectation.condition {
            Condition::Edge(operand, _) => operand.read(bench),
            Condition::Comparisons(_) => 0.0,
        };
        Self {
            start_ns: bench.time_ns(),
            changes_at_rest: expectation.condition.changes_at_rest(),
            expectation,
            last,
            before: last,
            since_ns: None,
            longest: None,
            nearest: None,
        }
    }

    /// Looks at the bench now. Returns what is certain, if anything is.
    pub(super) fn observe(&mut self, bench: &Bench) -> Option<Outcome> {
        if bench.time_ns() <= self.start_ns {
            return None;
        }
        match self.expectation.timing {
            Timing::AtEnd => None,
            Timing::At(at_ns) if bench.time_ns() < self.bench_ns(at_ns) => None,
            Timing::At(_) => Some(self.judge(bench)),
            Timing::During(window) => self.observe_during(window, bench),
        }
    }

    /// The next instant at which the bench must be looked at even if nothing changed.
    pub(super) fn next_deadline_ns(&self, now_ns: u64) -> u64 {
        let window = match self.expectation.timing {
            Timing::AtEnd => return u64::MAX,
            Timing::At(at_ns) => return self.bench_ns(at_ns),
            Timing::During(window) => window,
        };
        let from_ns = self.bench_ns(window.after_ns);
        if now_ns < from_ns {
            return from_ns;
        }
        let held_ns = self.since_ns.map_or(u64::MAX, |since_ns| since_ns.saturating_add(window.hold_ns));
        let change_ns = if self.changes_at_rest { now_ns.saturating_add(TICK_NS) } else { u64::MAX };
        self.until_ns(window).min(held_ns).min(change_ns)
    }

    /// Whether the run must go on for this to be decided, rather than end.
    pub(super) fn is_waiting(&self) -> bool {
        match self.expectation.timing {
            Timing::AtEnd => false,
            Timing::At(_) => true,
            Timing::During(window) => match self.expectation.rule {
                Rule::Eventually => true,
                Rule::Always | Rule::Never => window.within_ns.is_some() || window.after_ns > 0,
            },
        }
    }

    /// The run ends here, and nothing was certain until now.
    pub(super) fn finish(&self, bench: &Bench) -> Outcome {
        let at_ns = bench.time_ns();
        let ended = |due_ns: u64| {
            let reason = format!("the run ended at {}, before {}", show::time(at_ns), show::time(due_ns));
            Outcome::Undecided { reason }
        };
        let window = match self.expectation.timing {
            Timing::AtEnd => return self.judge(bench),
            Timing::At(due_ns) => return ended(self.bench_ns(due_ns)),
            Timing::During(window) => window,
        };
        let from_ns = self.bench_ns(window.after_ns);
        match (self.expectation.rule, window.within_ns) {
            _ if at_ns < from_ns => ended(from_ns),
            (Rule::Eventually, _) => {
                let reason = format!("the run ended first; {}", self.missed(window, bench));
                Outcome::Undecided { reason }
            }
            (Rule::Always | Rule::Never, None) => Outcome::Held { at_ns },
            (Rule::Always | Rule::Never, Some(within_ns)) => ended(self.bench_ns(within_ns)),
        }
    }

    fn observe_during(&mut self, window: Window, bench: &Bench) -> Option<Outcome> {
        let now_ns = bench.time_ns();
        let is_met = self.look(bench);
        if now_ns < self.bench_ns(window.after_ns) {
            return None;
        }
        let until_ns = self.until_ns(window);
        if now_ns > until_ns {
            return Some(self.expired(window, until_ns, bench));
        }
        let outcome = match self.expectation.rule {
            Rule::Always => (!is_met).then(|| self.failed(bench)),
            Rule::Never => self.is_held(is_met, window, bench).then(|| self.failed(bench)),
            Rule::Eventually => {
                self.is_held(is_met, window, bench).then_some(Outcome::Held { at_ns: now_ns })
            }
        };
        outcome.or_else(|| (now_ns == until_ns).then(|| self.expired(window, until_ns, bench)))
    }

    /// Whether the condition is met now.
    fn look(&mut self, bench: &Bench) -> bool {
        match &self.expectation.condition {
            Condition::Edge(operand, edge) => {
                self.before = core::mem::replace(&mut self.last, operand.read(bench));
                edge.is_met(self.before, self.last)
            }
            Condition::Comparisons(comparisons) => all_hold(comparisons, bench),
        }
    }

    /// Whether the condition, met now or not, has been met for as long as it shall.
    fn is_held(&mut self, is_met: bool, window: Window, bench: &Bench) -> bool {
        let now_ns = bench.time_ns();
        if !is_met {
            self.since_ns = None;
            self.note_nearest(bench);
            return false;
        }
        let from_ns = *self.since_ns.get_or_insert(now_ns);
        let length_ns = now_ns.saturating_sub(from_ns);
        if self.longest.is_none_or(|longest| longest.length_ns < length_ns) {
            self.longest = Some(Stretch { from_ns, length_ns });
        }
        length_ns >= window.hold_ns
    }

    /// A single comparison that does not hold may be nearer to holding than ever.
    fn note_nearest(&mut self, bench: &Bench) {
        let Condition::Comparisons(comparisons) = &self.expectation.condition else { return };
        let [comparison] = comparisons.as_slice() else { return };
        let sides = comparison.sides(bench);
        let Some(distance) = comparison.distance(sides) else { return };
        if self.nearest.is_none_or(|nearest| distance < nearest.distance) {
            self.nearest = Some(Nearest { distance, sides, at_ns: bench.time_ns() });
        }
    }

    /// Whether the condition is met at the instant that it is about.
    fn judge(&self, bench: &Bench) -> Outcome {
        let is_met = match &self.expectation.condition {
            Condition::Comparisons(comparisons) => all_hold(comparisons, bench),
            Condition::Edge(_, edge) => edge.is_met(self.before, self.last),
        };
        if is_met { Outcome::Held { at_ns: bench.time_ns() } } else { self.failed(bench) }
    }

    /// The window is over.
    fn expired(&self, window: Window, at_ns: u64, bench: &Bench) -> Outcome {
        match self.expectation.rule {
            Rule::Always | Rule::Never => Outcome::Held { at_ns },
            Rule::Eventually => Outcome::Failed { at_ns, reason: self.missed(window, bench) },
        }
    }

    /// What is the case now should not be.
    fn failed(&self, bench: &Bench) -> Outcome {
        let at_ns = bench.time_ns();
        let at = show::time(at_ns);
        let reason = match &self.expectation.condition {
            Condition::Edge(operand, edge) => {
                format!("{} at {at}", self.described_edge(operand, *edge))
            }
            Condition::Comparisons(comparisons) => {
                let values = described(comparisons, bench);
                match self.longest.filter(|longest| longest.length_ns > 0) {
                    Some(longest) => format!("{values} from {} to {at}", show::time(longest.from_ns)),
                    None => format!("{values} at {at}"),
                }
            }
        };
        Outcome::Failed { at_ns, reason }
    }

    fn described_edge(&self, operand: &Operand, edge: Edge) -> String {
        let [before, last] = [self.before, self.last].map(|value| operand.shown_value(value));
        format!("{} {} from {before} to {last}", operand.shown(), edge.past())
    }

    /// What was the case instead of what should have been.
    fn missed(&self, window: Window, bench: &Bench) -> String {
        let at = show::time(bench.time_ns());
        let comparisons = match &self.expectation.condition {
            Condition::Comparisons(comparisons) => comparisons,
            Condition::Edge(operand, edge) => {
                let value = operand.shown_value(self.last);
                return format!("{} was {value} at {at} and never {}", operand.shown(), edge.past());
            }
        };
        let values = format!("{} at {at}", described(comparisons, bench));
        if let Some(Stretch { from_ns, length_ns }) = self.longest.filter(|_| window.hold_ns > 0) {
            let [length, from] = [length_ns, from_ns].map(show::time);
            return format!("{values}; it held for {length} at the longest, from {from}");
        }
        match (comparisons.as_slice(), self.nearest) {
            ([comparison], Some(nearest)) if nearest.sides != comparison.sides(bench) => {
                let nearest_at = show::time(nearest.at_ns);
                format!("{values}; nearest {} at {nearest_at}", comparison.values(nearest.sides))
            }
            _ => values,
        }
    }

    /// A time of the expectation as the bench counts it. Before the end of the first control period there is nothing to look
    /// at: a module that was just switched on has sensed nothing yet.
    fn bench_ns(&self, time_ns: u64) -> u64 {
        self.start_ns.saturating_add(time_ns.max(TICK_NS))
    }

    /// When a window ends.
    fn until_ns(&self, window: Window) -> u64 {
        window.within_ns.map_or(u64::MAX, |within_ns| self.bench_ns(within_ns))
    }
}

fn all_hold(comparisons: &[Comparison], bench: &Bench) -> bool {
    comparisons.iter().all(|comparison| comparison.holds(comparison.sides(bench)))
}
