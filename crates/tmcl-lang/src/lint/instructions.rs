//! What single instructions tell: jumps beyond the program, waits without end.

use tmcl_tables::{Command, ModuleSpec, ValueField};

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::instruction::Instruction;

use super::Findings;
use super::flow::{Graph, Target, target};
use super::places::Places;

/// Reports both.
pub(super) fn report(graph: &Graph, places: &Places, found: &mut Findings) {
    for (address, command, instruction) in graph.commands() {
        let spec = command.spec();
        let diagnostic = match spec.value_field {
            ValueField::Address => beyond(graph, places, address, spec.mnemonic, instruction.value),
            ValueField::Ticks => without_timeout(graph.module, places, address, instruction),
            _ => None,
        };
        if let Some(diagnostic) = diagnostic {
            found.push(address, diagnostic);
        }
    }
}

fn beyond(graph: &Graph, places: &Places, address: usize, mnemonic: &str, value: i32) -> Option<Diagnostic> {
    let note = match target(value, graph.len(), graph.module) {
        Target::Inside(_) => return None,
        Target::Behind if mnemonic == Command::SetInterruptVector.spec().mnemonic => {
            "erased program memory reads as STOP: there the interrupt ends the program".to_owned()
        }
        Target::Behind => "erased program memory reads as STOP: there the program ends".to_owned(),
        Target::Outside => {
            format!(
                "the program memory ends at address {}; the module skips this {mnemonic}",
                last_address(graph.module)
            )
        }
    };
    let message = format!("{mnemonic} names address {value}, where the program has no instruction");
    let label = match graph.len().checked_sub(1) {
        Some(last) => format!("the last instruction is at address {last}"),
        None => String::new(),
    };
    Some(Diagnostic::new(Code::JumpBeyondProgram, places.span(address), message).label(label).note(note))
}

fn last_address(module: &ModuleSpec) -> u16 {
    module.program_memory.saturating_sub(1)
}

fn without_timeout(
    module: &ModuleSpec,
    places: &Places,
    address: usize,
    instruction: Instruction,
) -> Option<Diagnostic> {
    let entry = module.command(instruction.command)?;
    let condition = entry.named_types().find(|named| named.value == instruction.kind)?;
    if condition.id == "ticks" || instruction.value != 0 {
        return None;
    }
    let message = format!("WAIT {} has no timeout", condition.keyword);
    let diagnostic = Diagnostic::new(Code::WaitWithoutTimeout, places.span(address), message)
        .label("the program stands here for as long as it takes, even for ever")
        .note("the value is a timeout in ticks of 10 ms, 0 for none; JC ETO tells whether it ran out (TMCM-1311 §5.7.22)");
    Some(diagnostic)
}
