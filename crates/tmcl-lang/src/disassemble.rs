//! Instructions to text.
//!
//! Whatever the bytes are, the text assembles to them again. What the module's commands can say is written with them;
//! anything else as `DATA <command>, <type>, <motor>, <value>`, the instruction as it stands, with a comment that says why.
//! Labels are called after their address, `L_12:`. The text begins with the lines
//!
//! ```text
//! //! module: tmcm-1311
//! //! no-final-stop
//! ```
//!
//! the second only where the assembler would append a STOP otherwise. All of this form is a decision of OpenTMCL's.

mod comment;
mod refusal;
mod text;

#[cfg(test)]
mod tests;

use core::fmt::Write;
use std::collections::BTreeSet;

use tmcl_tables::{Command, ModuleSpec};

use crate::format::format;
use crate::instruction::Instruction;

use refusal::refusal;

/// Text that assembles to these instructions again, laid out as [`crate::format()`] does.
#[must_use]
pub fn disassemble(instructions: &[Instruction], module: &'static ModuleSpec) -> String {
    let mut out = format!("//! module: {}\n", module.id);
    if !ends_program(instructions.last().copied(), module) {
        out += "//! no-final-stop\n";
    }
    let program = Program { module, len: instructions.len() };
    let targets: BTreeSet<_> = instructions.iter().filter_map(|it| program.label(*it)).collect();
    for (address, instruction) in instructions.iter().enumerate() {
        if address == 0 {
            out.push('\n');
        }
        if targets.contains(&address) {
            // A blank line, so that comments are aligned from label to label.
            let _ = writeln!(out, "{}{}:", if address == 0 { "" } else { "\n" }, label_name(address));
        }
        let line = line(*instruction, program);
        let _ = writeln!(out, "{}", line.trim_end());
    }
    String::from_utf8_lossy(&format(out.as_bytes())).into_owned()
}

/// What instructions are read against.
#[derive(Clone, Copy)]
struct Program {
    module: &'static ModuleSpec,
    /// How many instructions there are.
    len: usize,
}

impl Program {
    /// The address that an instruction names as a label.
    fn label(self, instruction: Instruction) -> Option<usize> {
        let named = match refusal(instruction, self.module) {
            Ok(taken) => taken.address,
            Err(_) => None,
        };
        // Labels have addresses of 16 bits.
        named.map(usize::from).filter(|address| *address < self.len)
    }
}

fn label_name(address: usize) -> String {
    format!("L_{address}")
}

fn line(instruction: Instruction, program: Program) -> String {
    let (text, comment) = match refusal(instruction, program.module) {
        Ok(taken) => {
            let label = program.label(instruction).map(label_name);
            (
                text::command(instruction, taken, label.as_deref()),
                comment::comment(instruction, program.module),
            )
        }
        Err(refusal) => (text::data(instruction), refusal.text(instruction, program.module)),
    };
    if comment.is_empty() { format!("    {text}") } else { format!("    {text}  // {comment}") }
}

/// Whether the assembler appends no STOP behind this instruction, for all that its text says.
fn ends_program(last: Option<Instruction>, module: &'static ModuleSpec) -> bool {
    let ends = [Command::Stop, Command::Jump, Command::ReturnFromSubroutine, Command::ReturnFromInterrupt];
    let taken = last.and_then(|last| refusal(last, module).ok());
    taken.is_some_and(|taken| ends.contains(&taken.command.spec.command))
}
