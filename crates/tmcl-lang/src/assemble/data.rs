//! `DATA command, type, motor, value`: an instruction as four numbers, with no questions asked.
//!
//! The disassembler writes it for what has no other text, so that every program can be written down.

use super::builder::Builder;
use super::check;
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::instruction::Instruction;
use crate::syntax::{DATA, InstructionSyntax};

impl Builder<'_> {
    /// The instruction; None where an operand was complained about.
    pub(super) fn data(&mut self, syntax: &InstructionSyntax) -> Option<Instruction> {
        let [command, kind, motor, value] = syntax.operands.as_slice() else {
            let message = format!("{DATA} takes four operands, not {}", syntax.operands.len());
            let diagnostic = Diagnostic::new(Code::OperandCount, syntax.span, message);
            self.complain(diagnostic.note(format!("`{DATA} <command>, <type>, <motor>, <value>`")));
            return None;
        };
        let bytes = [(command, "a command"), (kind, "a type"), (motor, "a motor or bank")]
            .map(|(operand, noun)| self.byte(DATA, operand, noun));
        let number = self.number(DATA, "a value", value);
        let [Some(command), Some(kind), Some(motor)] = bytes else { return None };
        match check::bits(number?, true) {
            Some(value) => Some(Instruction { command, kind, motor, value }),
            None => {
                let diagnostic =
                    Diagnostic::new(Code::OperandRange, value.span, "the value does not fit 32 bits");
                self.complain(diagnostic.note(format!("it takes {}…{}", i32::MIN, u32::MAX)));
                None
            }
        }
    }
}
