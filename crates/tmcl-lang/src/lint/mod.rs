//! Flow that is legal but hardly meant.
//!
//! The program's instructions become a control-flow graph (`flow`): what follows what, where the program begins, where
//! interrupt routines begin. A subroutine is looked at once, not once a call: a CSUB leads on to the next instruction
//! where its subroutine can reach an RSUB (`backward`). Every instruction is reached in up to four contexts
//! (`forward`); whether RSUB and RETI mean something depends on them. Open calls are counted on the same graph
//! (`calls`). Everything is a walk with a list of its own, never on the native stack; only finding the way to
//! a misplaced return, for its message, is more than linear in the number of instructions.
//!
//! Where a choice has to be made, no warning is better than a wrong one. Nothing here may know text: names and places
//! come from the [`Program`] alone.

mod arithmetic;
mod backward;
mod calls;
mod components;
mod flow;
mod forward;
mod instructions;
mod interrupts;
mod names;
mod nesting;
mod places;
mod returns;
mod unreachable;

#[cfg(test)]
mod tests;

use crate::diagnostic::Diagnostic;
use crate::program::Program;
use crate::source::Sources;

use calls::Calls;
use flow::Graph;
use forward::{Forward, Rules};
use places::Places;

/// Everything there is to say about a program without errors, in the order of the addresses, all warnings included: the
/// caller drops those that are off ([`crate::Code::is_on_by_default`]).
#[must_use]
pub fn lint(program: &Program, sources: &Sources) -> Vec<Diagnostic> {
    let graph = Graph::new(program);
    let places = Places::new(program);
    let meant = Forward::new(&graph, Rules::Meant);
    let calls = Calls::new(&graph, &meant);
    let ignored = calls.ignorable(&graph);
    let goes_astray = meant.goes_astray(&graph) || ignored.contains(&true);
    // Where every call returns as it should, the module does what is meant.
    let astray = goes_astray.then(|| {
        let actual = Forward::new(&graph, Rules::Actual { ignored: &ignored });
        (actual, Forward::new(&graph, Rules::Anything))
    });
    let (actual, any) = astray.as_ref().map_or((&meant, &meant), |(actual, any)| (actual, any));

    let mut found = Findings::default();
    unreachable::report_unreached(&graph, &places, any, &mut found);
    unreachable::report_runs_off(&graph, &places, actual, &mut found);
    returns::report(&graph, &places, &meant, &mut found);
    nesting::report(&graph, &places, &calls, &mut found);
    interrupts::report(&graph, &places, &meant, actual, &mut found);
    instructions::report(&graph, &places, &mut found);
    arithmetic::report(&graph, &places, &mut found);
    names::report_labels(&graph, program, sources, &mut found);
    let mut diagnostics = found.in_order();
    diagnostics.extend(names::unused_constants(program));
    diagnostics
}

/// What was found so far, with the addresses it belongs to.
#[derive(Default)]
struct Findings(Vec<(usize, Diagnostic)>);

impl Findings {
    fn push(&mut self, address: usize, diagnostic: Diagnostic) {
        self.0.push((address, diagnostic));
    }

    fn in_order(mut self) -> Vec<Diagnostic> {
        self.0.sort_by_key(|(address, diagnostic)| (*address, diagnostic.code));
        self.0.into_iter().map(|(_, diagnostic)| diagnostic).collect()
    }
}
