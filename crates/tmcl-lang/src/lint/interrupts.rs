//! Interrupts that cannot come, and interrupt routines that do not end as such.

use tmcl_tables::Command;

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::instruction::ALL;

use super::Findings;
use super::backward::{Passes, can_end, can_return};
use super::flow::{Graph, Step};
use super::forward::{Context, Forward, Place};
use super::places::{Places, interrupt_name};

/// Reports all of it.
pub(super) fn report(
    graph: &Graph,
    places: &Places,
    meant: &Forward,
    actual: &Forward,
    found: &mut Findings,
) {
    without_vector(graph, places, actual, found);
    never_on(graph, places, actual, found);
    wrong_ends(graph, places, meant, found);
    endless(graph, places, found);
}

/// The EIs of single interrupts that are reached, with the interrupt.
fn enabled(graph: &Graph, actual: &Forward) -> Vec<(usize, u8)> {
    let enables = graph.commands().filter(|(_, command, _)| *command == Command::EnableInterrupt);
    let reached = enables.filter(|(address, _, it)| it.kind != ALL && actual.reaches_at_all(*address));
    reached.map(|(address, _, it)| (address, it.kind)).collect()
}

fn without_vector(graph: &Graph, places: &Places, actual: &Forward, found: &mut Findings) {
    let is_vector = |command| command == Command::SetInterruptVector;
    let vectors: Vec<_> =
        graph.commands().filter(|(_, command, _)| is_vector(*command)).map(|it| it.2.kind).collect();
    for (address, number) in enabled(graph, actual) {
        if vectors.contains(&number) {
            continue;
        }
        let name = interrupt_name(graph.module, number);
        let message = format!("{name} is enabled, but has no vector");
        let diagnostic = Diagnostic::new(Code::InterruptWithoutVector, places.span(address), message)
            .label(format!("no VECT {number} in the program"))
            .note("an interrupt without a vector is ignored");
        found.push(address, diagnostic);
    }
}

fn never_on(graph: &Graph, places: &Places, actual: &Forward, found: &mut Findings) {
    let is_master = |command, kind| command == Command::EnableInterrupt && kind == ALL;
    if graph.commands().any(|(_, command, it)| is_master(command, it.kind)) {
        return;
    }
    let enabled = enabled(graph, actual);
    let [(first, number), rest @ ..] = enabled.as_slice() else { return };
    let message = "interrupts are enabled, but never as a whole";
    let mut diagnostic = Diagnostic::new(Code::InterruptsNeverOn, places.span(*first), message)
        .label(format!("{} cannot come", interrupt_name(graph.module, *number)));
    for (address, number) in rest {
        let text = format!("nor can {}", interrupt_name(graph.module, *number));
        diagnostic = diagnostic.also(places.span(*address), text);
    }
    found.push(
        *first,
        diagnostic.note(format!("EI {ALL} switches interrupt processing on (TMCM-1311 §5.6.5)")),
    );
}

/// RSUB and STOP in interrupt routines, and RETI in their subroutines.
fn wrong_ends(graph: &Graph, places: &Places, meant: &Forward, found: &mut Findings) {
    for address in 0..graph.len() {
        for context in [Context::Interrupt, Context::InterruptSubroutine] {
            if !meant.reaches(address, context) {
                continue;
            }
            let diagnostic = match (graph.step(address), context) {
                (Step::SubroutineReturn, Context::Interrupt) => ends_with_rsub(places, address),
                (Step::InterruptReturn, Context::InterruptSubroutine) => ends_in_subroutine(places, address),
                (Step::Stop, _) => ends_with_stop(graph, places, meant, (address, context)),
                _ => continue,
            };
            found.push(address, at_vector(places, meant, (address, context), diagnostic));
            break;
        }
    }
}

fn ends_with_rsub(places: &Places, address: usize) -> Diagnostic {
    let message = "an interrupt routine can end with RSUB";
    Diagnostic::new(Code::SubroutineReturnInInterrupt, places.span(address), message)
        .label("RETI is what ends an interrupt routine")
        .note("RSUB takes the way back of a subroutine that the interrupt came upon, and is ignored where there is none")
        .note("until a RETI the interrupt is not over: no other one comes, and accumulator, X and flags are not restored")
}

fn ends_in_subroutine(places: &Places, address: usize) -> Diagnostic {
    let message = "RETI can be reached in a subroutine of an interrupt routine";
    Diagnostic::new(Code::SubroutineReturnInInterrupt, places.span(address), message)
        .label("the interrupt ends here, but the subroutine has not returned")
        .note("its return address stays on the stack; when 8 have gathered there, every CSUB is ignored")
}

fn ends_with_stop(graph: &Graph, places: &Places, meant: &Forward, place: Place) -> Diagnostic {
    let before = meant.before(place).filter(|_| graph.appended_stop == Some(place.0));
    let (address, message, label) = match before {
        Some(before) => (
            before.0,
            "an interrupt routine can run to the end of the program",
            "the program ends behind this",
        ),
        None => (place.0, "an interrupt routine can end with STOP", "the whole program ends here"),
    };
    Diagnostic::new(Code::SubroutineReturnInInterrupt, places.span(address), message)
        .label(label)
        .note("RETI ends an interrupt routine; STOP ends the program and all that it was doing")
}

/// Routines that neither end nor leave the program in any way.
fn endless(graph: &Graph, places: &Places, found: &mut Findings) {
    let returns = can_return(graph, Passes::NOTHING);
    let ends = can_end(graph, &returns);
    for routine in &graph.routines {
        if ends[routine.start] || returns[routine.start] {
            continue;
        }
        let message = format!("the interrupt routine {} never returns", places.name(routine.start));
        let diagnostic = Diagnostic::new(
            Code::SubroutineReturnInInterrupt,
            places.span(routine.start),
            message,
        )
        .label("no RETI can be reached from here")
        .also(places.span(routine.vector), "it becomes an interrupt routine here")
        .note("until a RETI the interrupt is not over: no other one comes, and the program does not go on");
        found.push(routine.start, diagnostic);
    }
}

fn at_vector(places: &Places, meant: &Forward, place: Place, diagnostic: Diagnostic) -> Diagnostic {
    match meant.vector(place) {
        Some(vector) => diagnostic.also(places.span(vector), "the interrupt routine is named here"),
        None => diagnostic,
    }
}
