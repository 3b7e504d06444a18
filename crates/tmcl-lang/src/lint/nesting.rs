//! Calls that nest too deep, and subroutines that call themselves.

use crate::code::Code;
use crate::diagnostic::Diagnostic;

use super::Findings;
use super::calls::{Calls, STACK};
use super::flow::{Graph, Step};
use super::forward::Context;
use super::places::Places;

const IGNORED: &str = "the module keeps 8 calls (TMCM-1311 §11.5): a CSUB beyond that is ignored, and the program goes on behind it";

/// Reports both.
pub(super) fn report(graph: &Graph, places: &Places, calls: &Calls, found: &mut Findings) {
    let mut recursions = std::collections::BTreeSet::new();
    for (address, step) in graph.steps.iter().enumerate() {
        let Step::Call(target) = *step else { continue };
        if calls.is_recursive(graph, address) {
            if recursions.insert(calls.component(address)) {
                found.push(address, recursion(graph, places, calls, address));
            }
        } else if is_ninth(calls, address, Context::Main) {
            found.push(address, too_deep(places, calls, address, target));
        } else if is_ninth(calls, address, Context::Interrupt) {
            found.push(address, too_deep_in_interrupt(places, calls, address, target));
        }
    }
}

/// Deeper calls follow from the ninth.
fn is_ninth(calls: &Calls, address: usize, context: Context) -> bool {
    calls.depth(address, context).is_some_and(|depth| depth.open == STACK)
}

/// The CSUBs that are open at an instruction, the last one first.
fn open_calls(calls: &Calls, address: usize, context: Context) -> impl Iterator<Item = usize> + '_ {
    let before = move |address: usize| calls.depth(address, context).and_then(|depth| depth.call);
    core::iter::successors(before(address), move |address| before(*address))
}

fn too_deep(places: &Places, calls: &Calls, address: usize, target: usize) -> Diagnostic {
    let message = format!("calls can nest {} deep here; the module keeps {STACK}", STACK + 1);
    let mut diagnostic = Diagnostic::new(Code::NestingTooDeep, places.span(address), message)
        .label(format!("{} is not called when {STACK} calls are open", places.name(target)));
    let mut open: Vec<_> = open_calls(calls, address, Context::Main).collect();
    open.reverse();
    for (index, call) in open.into_iter().enumerate() {
        diagnostic = diagnostic.also(places.span(call), format!("call {}", index + 1));
    }
    diagnostic.note(IGNORED)
}

fn too_deep_in_interrupt(places: &Places, calls: &Calls, address: usize, target: usize) -> Diagnostic {
    let main = calls.most_open().min(STACK);
    let message =
        format!("calls can nest {} deep in this interrupt routine; the module keeps {STACK}", STACK + 1);
    let mut diagnostic = Diagnostic::new(Code::NestingTooDeep, places.span(address), message)
        .label(format!("{} is not called when {STACK} calls are open", places.name(target)));
    for call in open_calls(calls, address, Context::Interrupt) {
        diagnostic = diagnostic.also(places.span(call), "this call is open");
    }
    diagnostic
        .note(format!(
            "the program can have {main} calls open when the interrupt comes, and shares its stack with it"
        ))
        .note(IGNORED)
}

fn recursion(graph: &Graph, places: &Places, calls: &Calls, address: usize) -> Diagnostic {
    let cycle = calls.cycle(graph, address);
    let name = |call: &usize| match graph.step(*call) {
        Step::Call(target) => places.name(target),
        _ => String::new(),
    };
    let own_name = name(&address);
    let message = match cycle.as_slice() {
        [] | [_] => format!("{own_name} can call itself"),
        [first, rest @ ..] => {
            let rest: String = rest.iter().map(|call| format!(", which can call {}", name(call))).collect();
            format!("{own_name} can call {}{rest}", name(first))
        }
    };
    let mut diagnostic = Diagnostic::new(Code::Recursion, places.span(address), message)
        .label(format!("{own_name} may not have returned yet"));
    for call in cycle.iter().filter(|call| **call != address) {
        diagnostic = diagnostic.also(places.span(*call), format!("{} is called here", name(call)));
    }
    diagnostic.note(IGNORED)
}
