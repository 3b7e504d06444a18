//! Whether a command's operands can say an instruction, so that the assembler takes it.

use tmcl_tables::{
    Command, CommandSpec, Direction, ModuleCommand, ModuleSpec, MotorField, Operand, ParameterSpec,
    TypeField, ValueField,
};

use crate::instruction::Instruction;

/// Stands for every port of a bank, for all interrupts, and for the EEPROM in SCO and GCO.
pub(super) const ALL: u8 = 255;
/// The bank of the inputs that GIO 255 reads.
const INPUT_BANK: u8 = 0;
/// The bank of the outputs that SIO 255 sets.
const OUTPUT_BANK: u8 = 2;
/// The axis parameter that ROR and ROL set.
const TARGET_VELOCITY: u8 = 2;

/// An instruction that operands can say.
#[derive(Clone, Copy)]
pub(super) struct Taken {
    pub(super) command: &'static ModuleCommand,
    /// The parameter it is about.
    pub(super) parameter: Option<&'static ParameterSpec>,
    /// The address it names.
    pub(super) address: Option<u16>,
}

/// Why operands cannot say an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// No command that the module has in programs.
    Command,
    /// A field is not 0 that the command has no operand for.
    UnusedField,
    /// No such type, parameter, port, coordinate or interrupt.
    Kind,
    /// No such motor or bank.
    Motor,
    /// The parameter or port cannot be used so.
    Access,
    /// A value that is not taken.
    Value,
}

impl Refusal {
    /// What the comment says.
    pub(super) fn text(self, instruction: Instruction, module: &ModuleSpec) -> String {
        let spec = instruction.known_command().map(Command::spec);
        let Some(spec) = spec.filter(|spec| !spec.mnemonic.is_empty()) else {
            return "no command of a program".to_owned();
        };
        let mnemonic = spec.mnemonic;
        match self {
            Self::Command => format!("{mnemonic}, which no program of the {} can hold", module.name),
            Self::UnusedField => format!("{mnemonic}, with fields set that it does not use"),
            Self::Kind => format!("{mnemonic} of something that the {} does not have", module.name),
            Self::Motor => format!("{mnemonic} with a motor or bank that the {} does not have", module.name),
            Self::Access => format!("{mnemonic} of something that cannot be used so"),
            Self::Value => format!("{mnemonic} with a value that is not taken"),
        }
    }
}

/// Whether operands can say an instruction, and why not.
pub(super) fn refusal(instruction: Instruction, module: &'static ModuleSpec) -> Result<Taken, Refusal> {
    let command =
        module.command(instruction.command).filter(|entry| entry.modes.program).ok_or(Refusal::Command)?;
    let spec = command.spec;
    let unused = |field: Operand| !spec.operands.contains(&field);
    if unused(Operand::Type) && instruction.kind != 0
        || unused(Operand::Motor) && instruction.motor != 0
        || unused(Operand::Value) && instruction.value != 0
    {
        return Err(Refusal::UnusedField);
    }
    motor(instruction, spec)?;
    let parameter = kind(instruction, command, module)?;
    value(instruction, spec, parameter, module)?;
    let names_address = spec.value_field == ValueField::Address;
    let address = names_address.then(|| u16::try_from(instruction.value).ok()).flatten();
    Ok(Taken { command, parameter, address })
}

fn motor(instruction: Instruction, spec: &CommandSpec) -> Result<(), Refusal> {
    let is_taken = match spec.motor_field {
        MotorField::Motor => instruction.motor == 0,
        MotorField::CoordinateStore => matches!(instruction.motor, 0 | ALL),
        MotorField::Bank | MotorField::Unused => true,
    };
    is_taken.then_some(()).ok_or(Refusal::Motor)
}

/// The parameter, for a command that is about one.
fn kind(
    instruction: Instruction,
    command: &ModuleCommand,
    module: &'static ModuleSpec,
) -> Result<Option<&'static ParameterSpec>, Refusal> {
    let number = instruction.kind;
    let parameter = match command.spec.type_field {
        TypeField::AxisParameter => module.axis_parameter(number).ok_or(Refusal::Kind)?,
        TypeField::GlobalParameter => {
            &module.global_parameter(instruction.motor, number).ok_or(Refusal::Kind)?.parameter
        }
        TypeField::Port => return port(instruction, module).map(|()| None),
        other => {
            let is_taken = match other {
                TypeField::Named => {
                    command.named_types().any(|named| named.value == number && !named.keyword.is_empty())
                }
                TypeField::Coordinate => number < module.coordinates,
                TypeField::Interrupt if command.spec.command == Command::SetInterruptVector => {
                    module.interrupt(number).is_some()
                }
                TypeField::Interrupt => number == ALL || module.interrupt(number).is_some(),
                _ => true,
            };
            return is_taken.then_some(None).ok_or(Refusal::Kind);
        }
    };
    let access = parameter.access;
    let is_allowed = match command.spec.command {
        Command::GetAxisParameter | Command::GetGlobalParameter => access.read,
        Command::StoreAxisParameter
        | Command::RestoreAxisParameter
        | Command::StoreGlobalParameter
        | Command::RestoreGlobalParameter => access.store,
        _ => access.write,
    };
    is_allowed.then_some(Some(parameter)).ok_or(Refusal::Access)
}

fn port(instruction: Instruction, module: &ModuleSpec) -> Result<(), Refusal> {
    if is_all_ports(instruction) {
        return Ok(());
    }
    let port = module.port(instruction.motor, instruction.kind).ok_or(Refusal::Kind)?;
    let sets = instruction.known_command() == Some(Command::SetOutput);
    if sets && port.direction == Direction::Input {
        return Err(Refusal::Access);
    }
    let is_taken = !sets || port.range.contains(i64::from(instruction.value));
    is_taken.then_some(()).ok_or(Refusal::Value)
}

/// SIO 255 and GIO 255.
pub(super) fn is_all_ports(instruction: Instruction) -> bool {
    let bank = match instruction.known_command() {
        Some(Command::SetOutput) => OUTPUT_BANK,
        _ => INPUT_BANK,
    };
    instruction.kind == ALL && instruction.motor == bank
}

fn value(
    instruction: Instruction,
    spec: &CommandSpec,
    parameter: Option<&ParameterSpec>,
    module: &ModuleSpec,
) -> Result<(), Refusal> {
    let value = instruction.value;
    let named = spec.types.iter().find(|named| named.value == instruction.kind);
    let is_taken = match spec.value_field {
        ValueField::ParameterValue => parameter.is_none_or(|parameter| parameter.allows_write(value)),
        ValueField::PortValue => !is_all_ports(instruction) || (-1..=255).contains(&value),
        ValueField::Velocity => {
            module.axis_parameter(TARGET_VELOCITY).is_none_or(|velocity| velocity.allows_write(value))
        }
        ValueField::Position if named.is_some_and(|named| named.id == "coordinate") => {
            u8::try_from(value).is_ok_and(|coordinate| coordinate < module.coordinates)
        }
        ValueField::Address => u16::try_from(value).is_ok_and(|address| address < module.program_memory),
        _ => true,
    };
    is_taken.then_some(()).ok_or(Refusal::Value)
}
