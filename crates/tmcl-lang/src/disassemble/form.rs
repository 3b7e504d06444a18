//! Which instructions the assembler takes in their operand form.
//!
//! What it takes is for the assembler alone to know: it is asked, once for all instructions.

use tmcl_tables::{Command, CommandSpec, ModuleSpec};

use crate::assemble::{Assembly, assemble};
use crate::code::Code;
use crate::diagnostic::{Diagnostic, Severity};
use crate::instruction::Instruction;
use crate::resolver::NoIncludes;
use crate::source::SourceFile;

use super::{NO_FINAL_STOP, text};

/// How an instruction is written.
#[derive(Debug)]
pub(super) enum Form {
    /// With the mnemonic and the operands of its command.
    Operands(&'static CommandSpec),
    /// As DATA, and why.
    Data(String),
}

/// How each instruction is written.
pub(super) fn forms(instructions: &[Instruction], module: &'static ModuleSpec) -> Vec<Form> {
    let assembly = assembled(instructions, module);
    let complaints = complaints(&assembly, instructions.len());
    let outcomes = assembly.program.instructions.iter().zip(complaints);
    instructions.iter().zip(outcomes).map(|(it, (came_out, why))| form(*it, *came_out, why)).collect()
}

/// The command that program text can name.
fn in_programs(instruction: Instruction) -> Option<&'static CommandSpec> {
    instruction.known_command().map(Command::spec).filter(|spec| !spec.mnemonic.is_empty())
}

/// What the assembler makes of the operand forms: one line and one instruction for each, whatever is wrong with it.
fn assembled(instructions: &[Instruction], module: &'static ModuleSpec) -> Assembly {
    let mut candidates = NO_FINAL_STOP.to_owned();
    for instruction in instructions {
        candidates += &match in_programs(*instruction) {
            Some(spec) => text::operands(*instruction, spec, module, None),
            None => text::data(*instruction),
        };
        candidates.push('\n');
    }
    let root = SourceFile { name: String::new(), bytes: candidates.into_bytes(), builtin: false };
    assemble(root, Some(module), &mut NoIncludes)
}

/// The first error of each line. That the program is too long is the fault of none of them.
fn complaints(assembly: &Assembly, count: usize) -> Vec<Option<&Diagnostic>> {
    let mut first = vec![None; count];
    let is_of_a_line = |it: &&Diagnostic| it.severity() == Severity::Error && it.code != Code::ProgramTooLong;
    for diagnostic in assembly.diagnostics.iter().filter(is_of_a_line) {
        let start = diagnostic.primary.span.start;
        let lines = assembly.program.origins.partition_point(|origin| origin.start <= start);
        if let Some(line) = lines.checked_sub(1).and_then(|index| first.get_mut(index)) {
            line.get_or_insert(diagnostic);
        }
    }
    first
}

fn form(instruction: Instruction, came_out: Instruction, complaint: Option<&Diagnostic>) -> Form {
    match (in_programs(instruction), complaint) {
        (None, _) => Form::Data("no command of a program".to_owned()),
        (Some(_), Some(complaint)) => Form::Data(complaint.message.clone()),
        (Some(spec), None) if came_out == instruction => Form::Operands(spec),
        (Some(spec), None) => Form::Data(format!("{}, with fields set that it does not use", spec.mnemonic)),
    }
}
