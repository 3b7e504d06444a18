//! Instructions that are never reached, and flow that leaves the program.

use crate::code::Code;
use crate::diagnostic::Diagnostic;

use super::Findings;
use super::flow::{Graph, Step};
use super::forward::Forward;
use super::places::Places;

/// Reports runs of instructions that are not among `reachable`.
pub(super) fn report_unreached(graph: &Graph, places: &Places, reachable: &Forward, found: &mut Findings) {
    let reached: Vec<_> = (0..graph.len()).map(|address| reachable.reaches_at_all(address)).collect();
    let mut start = 0;
    for run in reached.chunk_by(|a, b| a == b) {
        if run.first() == Some(&false) {
            unreached(graph, places, start, run.len(), found);
        }
        start += run.len();
    }
}

/// Reports instructions that lead out of the program.
pub(super) fn report_runs_off(graph: &Graph, places: &Places, actual: &Forward, found: &mut Findings) {
    let mut leaving: Vec<_> = actual.leaving.iter().map(|(address, _)| *address).collect();
    leaving.sort_unstable();
    leaving.dedup();
    for address in leaving {
        found.push(address, runs_off(graph, places, address));
    }
}

fn unreached(graph: &Graph, places: &Places, start: usize, run: usize, found: &mut Findings) {
    let ends_with_appended = graph.appended_stop == Some(start + run - 1);
    let len = if ends_with_appended { run - 1 } else { run };
    let message = match len {
        0 => return,
        1 => "this instruction is never reached".to_owned(),
        _ => format!("{len} instructions are never reached"),
    };
    let first = if len == 1 { String::new() } else { format!("from here, {}", places.name(start)) };
    let mut diagnostic = Diagnostic::new(Code::Unreachable, places.span(start), message).label(first);
    if len > 1 {
        diagnostic = diagnostic.also(places.span(start + len - 1), "to here");
    }
    if let Some(before) = start.checked_sub(1) {
        diagnostic = diagnostic.also(places.span(before), why_not(graph, places, before));
    }
    let note = "a host can start a program at any address (command 129, TMCM-1311 §11.6); JA instructions at the top \
                of the program are taken for such starts";
    found.push(start, diagnostic.note(note));
}

/// Why the flow does not go on behind an instruction that is reached.
fn why_not(graph: &Graph, places: &Places, before: usize) -> String {
    match graph.step(before) {
        Step::Jump(target) => format!("the program goes on at {}", places.name(target)),
        Step::Call(target) => format!("{} never returns", places.name(target)),
        Step::SubroutineReturn => "the subroutine ends here".to_owned(),
        Step::InterruptReturn => "the interrupt routine ends here".to_owned(),
        Step::Stop | Step::Leave | Step::Next | Step::Branch(_) => "the program ends here".to_owned(),
    }
}

fn runs_off(graph: &Graph, places: &Places, address: usize) -> Diagnostic {
    let label = match graph.step(address) {
        Step::SubroutineReturn | Step::InterruptReturn => {
            "where this is ignored, the program goes on behind it"
        }
        _ => "the program goes on behind this",
    };
    Diagnostic::new(Code::RunsOff, places.span(address), "the program can run past its last instruction")
        .label(label)
        .note("behind the program lies what the program memory held before; erased memory reads as STOP")
        .note("end the program with STOP, or go back with JA")
}
