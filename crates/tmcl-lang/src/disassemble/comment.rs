//! What the numbers of an instruction are called.

use tmcl_tables::{CommandSpec, ModuleSpec, ParameterSpec, TypeField, ValueField};

use crate::instruction::{ALL, Instruction};

use super::text;

/// The name of the parameter, port or interrupt that an instruction is about; empty for others.
pub(super) fn comment(instruction: Instruction, spec: &CommandSpec, module: &'static ModuleSpec) -> String {
    let number = instruction.kind;
    let name = match spec.type_field {
        TypeField::AxisParameter | TypeField::GlobalParameter => {
            let parameter = text::parameter(instruction, spec, module);
            parameter.map(|parameter| parameter_name(parameter, instruction, spec.value_field))
        }
        TypeField::Port if number == ALL => Some("all at once".to_owned()),
        TypeField::Port => module.port(instruction.motor, number).map(|port| port.name.to_owned()),
        TypeField::Interrupt if number == ALL => Some("interrupts as a whole".to_owned()),
        TypeField::Interrupt => module.interrupt(number).map(|interrupt| interrupt.name.to_owned()),
        TypeField::Unused | TypeField::Named | TypeField::Coordinate => None,
    };
    name.unwrap_or_default()
}

fn parameter_name(parameter: &ParameterSpec, instruction: Instruction, field: ValueField) -> String {
    let unit = if parameter.unit.is_empty() { String::new() } else { format!(" [{}]", parameter.unit) };
    let writes = field == ValueField::ParameterValue;
    let value = writes.then(|| parameter.value_name(parameter.from_wire(instruction.value))).flatten();
    let value = value.map(|name| format!(": {name}")).unwrap_or_default();
    format!("{}{unit}{value}", parameter.name)
}
