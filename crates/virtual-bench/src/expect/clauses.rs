//! When: the clauses of an expectation, and which of them go together.

use super::condition::Condition;
use super::expectation::{Rule, Timing, Window};

/// What a clause begins with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clause {
    Within,
    After,
    For,
    At,
}

/// A clause's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Time {
    Ns(u64),
    End,
}

/// The clauses so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clauses {
    within_ns: Option<u64>,
    after_ns: Option<u64>,
    hold_ns: Option<u64>,
    at: Option<Time>,
}

impl Clauses {
    /// Adds a clause, or says why it does not go with what stands before it.
    pub(super) fn add(
        &mut self,
        clause: Clause,
        time: Time,
        rule: Rule,
        condition: &Condition,
    ) -> Result<(), &'static str> {
        self.check_once(clause)?;
        check_fits(clause, rule, condition)?;
        match (clause, time) {
            (Clause::At, _) | (_, Time::End) => self.at = Some(time),
            (Clause::Within, Time::Ns(time_ns)) => self.within_ns = Some(time_ns),
            (Clause::After, Time::Ns(time_ns)) => self.after_ns = Some(time_ns),
            (Clause::For, Time::Ns(time_ns)) => self.hold_ns = Some(time_ns),
        }
        self.check_room()
    }

    fn check_once(&self, clause: Clause) -> Result<(), &'static str> {
        let window = self.within_ns.or(self.after_ns).or(self.hold_ns);
        let (taken, message) = match clause {
            Clause::Within => (self.within_ns.is_some(), "there is a `within` already"),
            Clause::After => (self.after_ns.is_some(), "there is an `after` already"),
            Clause::For => (self.hold_ns.is_some(), "there is a `for` already"),
            Clause::At => (self.at.is_some(), "there is an `at` already"),
        };
        if taken {
            return Err(message);
        }
        let at = if clause == Clause::At { window.is_some() } else { self.at.is_some() };
        if at {
            Err("`at` is a single instant: `within`, `after` and `for` do not go with it")
        } else {
            Ok(())
        }
    }

    /// There must be time to meet the condition in.
    fn check_room(&self) -> Result<(), &'static str> {
        let least_ns = self.after_ns.unwrap_or(0).saturating_add(self.hold_ns.unwrap_or(0));
        if self.within_ns.is_some_and(|within_ns| within_ns < least_ns) {
            return Err("`within` ends before `after` and `for` can be over; all times count from the start");
        }
        Ok(())
    }

    pub(super) fn timing(self) -> Timing {
        match self.at {
            Some(Time::Ns(at_ns)) => Timing::At(at_ns),
            Some(Time::End) => Timing::AtEnd,
            None => Timing::During(Window {
                after_ns: self.after_ns.unwrap_or(0),
                within_ns: self.within_ns,
                hold_ns: self.hold_ns.unwrap_or(0),
            }),
        }
    }
}

fn check_fits(clause: Clause, rule: Rule, condition: &Condition) -> Result<(), &'static str> {
    match (clause, rule, condition) {
        (Clause::At | Clause::For, _, Condition::Edge(..)) => {
            Err("a change takes no time: `at` and `for` need a comparison")
        }
        (Clause::At, Rule::Never | Rule::Always, _) => {
            Err("`at` is a single instant: leave out `never` or `always`")
        }
        (Clause::For, Rule::Always, _) => {
            Err("`always` is for all the time: write `within` for its first part")
        }
        _ => Ok(()),
    }
}
