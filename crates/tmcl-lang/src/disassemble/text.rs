//! The text of an instruction.

use tmcl_tables::{Operand, TypeField};

use crate::instruction::Instruction;

use super::refusal::Taken;

/// The mnemonic that says an instruction byte by byte.
pub(crate) const DATA: &str = "DATA";

/// Any instruction.
pub(super) fn data(instruction: Instruction) -> String {
    let Instruction { command, kind, motor, value } = instruction;
    format!("{DATA} {command}, {kind}, {motor}, {value}")
}

/// An instruction that operands can say; `label` is what it names.
pub(super) fn command(instruction: Instruction, taken: Taken, label: Option<&str>) -> String {
    let spec = taken.command.spec;
    let operands = spec.operands.iter().map(|operand| match operand {
        Operand::Type => kind(instruction, taken),
        Operand::Motor => instruction.motor.to_string(),
        Operand::Value => match (label, taken.parameter) {
            (Some(label), _) => label.to_owned(),
            (None, Some(parameter)) => parameter.from_wire(instruction.value).to_string(),
            (None, None) => instruction.value.to_string(),
        },
    });
    let operands: Vec<_> = operands.collect();
    format!("{} {}", spec.mnemonic, operands.join(", ")).trim_end().to_owned()
}

fn kind(instruction: Instruction, taken: Taken) -> String {
    let mut types = taken.command.named_types();
    match types.find(|named| named.value == instruction.kind) {
        Some(named) if taken.command.spec.type_field == TypeField::Named => named.keyword.to_owned(),
        _ => instruction.kind.to_string(),
    }
}
