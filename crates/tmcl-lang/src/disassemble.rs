//! Instructions to text.
//!
//! Whatever the bytes are, the text assembles to them again. What the assembler takes in the form of the module's commands
//! is written so; anything else as `DATA <command>, <type>, <motor>, <value>`, the instruction as it stands, with a comment
//! that says why: what the assembler has against the other form.
//! Labels are called after their address, `L_12:`. The text begins with the lines
//!
//! ```text
//! //! module: tmcm-1311
//! //! no-final-stop
//! ```
//!
//! the second only where the assembler would append a STOP otherwise. All of this form is a decision of OpenTMCL's.

mod comment;
mod form;
mod text;

#[cfg(test)]
mod tests;

use core::fmt::Write;
use std::collections::BTreeSet;

use tmcl_tables::{CommandSpec, ModuleSpec, ValueField};

use crate::format::format;
use crate::instruction::Instruction;

use form::{Form, forms};

/// The line that keeps the assembler from appending a STOP.
const NO_FINAL_STOP: &str = "//! no-final-stop\n";

/// Text that assembles to these instructions again, laid out as [`crate::format()`] does.
#[must_use]
pub fn disassemble(instructions: &[Instruction], module: &'static ModuleSpec) -> String {
    let mut out = format!("//! module: {}\n", module.id);
    if !instructions.last().is_some_and(|last| last.ends_a_program()) {
        out += NO_FINAL_STOP;
    }
    let forms = forms(instructions, module);
    let lines = || instructions.iter().copied().zip(&forms);
    let label = |(instruction, form)| label(instruction, form, instructions.len());
    let targets: BTreeSet<_> = lines().filter_map(label).collect();
    for (address, line) in lines().enumerate() {
        if address == 0 {
            out.push('\n');
        }
        if targets.contains(&address) {
            // A blank line, so that comments are aligned from label to label.
            let _ = writeln!(out, "{}{}:", if address == 0 { "" } else { "\n" }, label_name(address));
        }
        let (code, comment) = written(line, label(line), module);
        let comment = if comment.is_empty() { comment } else { format!("  // {comment}") };
        let _ = writeln!(out, "    {code}{comment}");
    }
    String::from_utf8_lossy(&format(out.as_bytes())).into_owned()
}

/// The address that an instruction names as a label, in a program of `len` instructions.
fn label(instruction: Instruction, form: &Form, len: usize) -> Option<usize> {
    let Form::Operands(CommandSpec { value_field: ValueField::Address, .. }) = form else { return None };
    // Labels have addresses of 16 bits.
    let address = u16::try_from(instruction.value).ok().map(usize::from);
    address.filter(|address| *address < len)
}

fn label_name(address: usize) -> String {
    format!("L_{address}")
}

/// The code of a line, and its comment.
fn written(
    (instruction, form): (Instruction, &Form),
    label: Option<usize>,
    module: &'static ModuleSpec,
) -> (String, String) {
    match form {
        Form::Operands(spec) => {
            let label = label.map(label_name);
            let code = text::operands(instruction, spec, module, label.as_deref());
            (code, comment::comment(instruction, spec, module))
        }
        Form::Data(why) => (text::data(instruction), why.clone()),
    }
}
