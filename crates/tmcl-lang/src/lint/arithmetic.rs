//! Divisions by a zero that is plain to see.

use tmcl_tables::Command;

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::instruction::Instruction;

use super::Findings;
use super::flow::{Graph, Step};
use super::places::Places;

/// The instruction that made a register zero; None where it may be anything.
type Zero = Option<usize>;

/// Reports CALC DIV and MOD with 0, and CALCX DIV and MOD after an X that was loaded with 0 in the same straight line.
pub(super) fn report(graph: &Graph, places: &Places, found: &mut Findings) {
    let begins_line = line_beginnings(graph);
    let (mut accumulator, mut x): (Zero, Zero) = (None, None);
    for (address, instruction) in graph.instructions.iter().enumerate() {
        if begins_line[address] {
            (accumulator, x) = (None, None);
        }
        let Some(operation) = operation(graph, *instruction) else {
            // Whatever else it is, it may write the accumulator, and never X.
            accumulator = None;
            continue;
        };
        match (operation, instruction.known_command()) {
            ("divide" | "modulo", Some(Command::Calculate)) if instruction.value == 0 => {
                found.push(address, division(places, address, operation, None));
            }
            ("divide" | "modulo", Some(Command::CalculateX)) if x.is_some() => {
                found.push(address, division(places, address, operation, x));
            }
            _ => {}
        }
        (accumulator, x) = after(*instruction, operation, address, accumulator, x);
    }
}

/// The identifier of what a CALC or CALCX does.
fn operation(graph: &Graph, instruction: Instruction) -> Option<&'static str> {
    let entry = graph.module.command(instruction.command)?;
    if !matches!(entry.spec.command, Command::Calculate | Command::CalculateX) {
        return None;
    }
    entry.named_types().find(|named| named.value == instruction.kind).map(|named| named.id)
}

/// Accumulator and X after a CALC or CALCX.
fn after(
    instruction: Instruction,
    operation: &str,
    address: usize,
    accumulator: Zero,
    x: Zero,
) -> (Zero, Zero) {
    match (instruction.known_command(), operation) {
        (Some(Command::Calculate), "load") => ((instruction.value == 0).then_some(address), x),
        (Some(Command::CalculateX), "load") => (accumulator, accumulator),
        (Some(Command::CalculateX), "swap") => (x, accumulator),
        (Some(Command::CalculateX), "not") => (accumulator, None),
        _ => (None, x),
    }
}

/// Instructions that are reached from elsewhere than the one before, or after a subroutine.
fn line_beginnings(graph: &Graph) -> Vec<bool> {
    let mut begins = vec![false; graph.len() + 1];
    for start in graph.entries.iter().copied().chain(graph.routines.iter().map(|routine| routine.start)) {
        begins[start] = true;
    }
    for (address, step) in graph.steps.iter().enumerate() {
        match *step {
            Step::Jump(target) | Step::Branch(target) => begins[target] = true,
            Step::Call(target) => {
                begins[target] = true;
                begins[address + 1] = true;
            }
            _ => {}
        }
    }
    begins
}

fn division(places: &Places, address: usize, operation: &str, x: Zero) -> Diagnostic {
    let (message, note) = match operation {
        "divide" => ("division by zero", "the module has no error for it: the accumulator becomes 0"),
        _ => (
            "remainder of a division by zero",
            "the module has no error for it: the accumulator stays as it is",
        ),
    };
    let diagnostic = Diagnostic::new(Code::DivisionByZero, places.span(address), message).note(note);
    match x {
        Some(zero) => diagnostic.label("X is 0 here").also(places.span(zero), "0 is loaded here"),
        None => diagnostic,
    }
}
