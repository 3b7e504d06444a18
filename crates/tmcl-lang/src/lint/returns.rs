//! RSUB and RETI where they mean nothing.

use crate::code::Code;
use crate::diagnostic::Diagnostic;

use super::Findings;
use super::flow::{Graph, Step};
use super::forward::{Context, Forward, Place};
use super::places::Places;

/// Reports each that the author's flow reaches; not those that are reached only because another one is ignored.
pub(super) fn report(graph: &Graph, places: &Places, meant: &Forward, found: &mut Findings) {
    let mut strays = meant.strays.clone();
    strays.sort_by_key(|(address, context)| (*address, *context as usize));
    strays.dedup_by_key(|(address, _)| *address);
    let routines = Starts::new(graph.len(), graph.routines.iter().map(|routine| routine.start));
    let called = |step: &Step| if let Step::Call(target) = step { Some(*target) } else { None };
    let subroutines = Starts::new(graph.len(), graph.steps.iter().filter_map(called));
    for place in strays {
        let (code, message, label, starts, what) = match (graph.step(place.0), place.1) {
            (Step::InterruptReturn, _) => (
                Code::StrayInterruptReturn,
                "RETI can be reached outside an interrupt routine",
                "ignored when no interrupt is being handled",
                &routines,
                "interrupt routine",
            ),
            (Step::SubroutineReturn, Context::Main) => (
                Code::StraySubroutineReturn,
                "RSUB can be reached without a CSUB",
                "ignored when no call is open",
                &subroutines,
                "subroutine",
            ),
            _ => continue,
        };
        let mut diagnostic = Diagnostic::new(code, places.span(place.0), message).label(label);
        if let Some((start, before)) = starts.entered(meant, place) {
            let text = match graph.step(before) {
                Step::Call(target) if target == start => format!("the {what} is called as a subroutine here"),
                _ => format!("from here the program runs on into the {what} {}", places.name(start)),
            };
            diagnostic = diagnostic.also(places.span(before), text);
        }
        found.push(place.0, diagnostic.note("the module then goes on with the next instruction"));
    }
}

/// Where routines begin.
struct Starts(Vec<bool>);

impl Starts {
    fn new(len: usize, starts: impl Iterator<Item = usize>) -> Self {
        let mut is_start = vec![false; len];
        for start in starts {
            is_start[start] = true;
        }
        Self(is_start)
    }

    /// On the way to `place`, the routine that was entered last, and from where.
    fn entered(&self, meant: &Forward, place: Place) -> Option<(usize, usize)> {
        let mut here = place;
        while let Some(before) = meant.before(here) {
            if self.0[here.0] {
                return Some((here.0, before.0));
            }
            here = before;
        }
        None
    }
}
