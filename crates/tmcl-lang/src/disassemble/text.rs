//! The text of an instruction.

use tmcl_tables::{CommandSpec, ModuleSpec, Operand, ParameterSpec, TypeField, ValueField};

use crate::instruction::Instruction;
use crate::syntax::DATA;

/// Any instruction.
pub(super) fn data(instruction: Instruction) -> String {
    let Instruction { command, kind, motor, value } = instruction;
    format!("{DATA} {command}, {kind}, {motor}, {value}")
}

/// The mnemonic and the operands of an instruction's command; `label` is what it names.
pub(super) fn operands(
    instruction: Instruction,
    spec: &CommandSpec,
    module: &'static ModuleSpec,
    label: Option<&str>,
) -> String {
    let operands = spec.operands.iter().map(|operand| match (operand, label) {
        (Operand::Type, _) => kind(instruction, spec),
        (Operand::Motor, _) => instruction.motor.to_string(),
        (Operand::Value, Some(label)) => label.to_owned(),
        (Operand::Value, None) => value(instruction, spec, module).to_string(),
    });
    let operands: Vec<_> = operands.collect();
    format!("{} {}", spec.mnemonic, operands.join(", ")).trim_end().to_owned()
}

fn kind(instruction: Instruction, spec: &CommandSpec) -> String {
    let named = spec.types.iter().find(|named| named.value == instruction.kind);
    match named.filter(|named| spec.type_field == TypeField::Named && !named.keyword.is_empty()) {
        Some(named) => named.keyword.to_owned(),
        None => instruction.kind.to_string(),
    }
}

/// The number that the value stands for, which depends on the parameter that it is for.
fn value(instruction: Instruction, spec: &CommandSpec, module: &'static ModuleSpec) -> i64 {
    let written = match spec.value_field {
        ValueField::ParameterValue => parameter(instruction, spec, module),
        _ => None,
    };
    written.map_or(i64::from(instruction.value), |parameter| parameter.from_wire(instruction.value))
}

/// The parameter that an instruction is about.
pub(super) fn parameter(
    instruction: Instruction,
    spec: &CommandSpec,
    module: &'static ModuleSpec,
) -> Option<&'static ParameterSpec> {
    let number = instruction.kind;
    match spec.type_field {
        TypeField::AxisParameter => module.axis_parameter(number),
        TypeField::GlobalParameter => {
            module.global_parameter(instruction.motor, number).map(|entry| &entry.parameter)
        }
        _ => None,
    }
}
