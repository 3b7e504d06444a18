//! One command: its number, mnemonic, and what its fields hold.

use crate::Command;

/// The chapter a command belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Moves the motor or keeps its coordinates.
    Motion,
    /// Reads and writes parameters.
    Parameter,
    /// Program flow.
    Control,
    /// Inputs and outputs.
    Io,
    /// Arithmetic on the accumulator.
    Calculation,
    /// Interrupts of stand-alone programs.
    Interrupt,
    /// Customer-specific functions.
    User,
    /// Sent by a host to run, download, identify and reset (128 to 139 and 255).
    Host,
}

/// Where a command may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Sent by a host.
    Direct,
    /// In a stand-alone program.
    Program,
}

/// The set of [`Mode`]s of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Modes {
    /// A host may send it.
    pub direct: bool,
    /// A stand-alone program may hold it.
    pub program: bool,
}

impl Modes {
    /// Whether `mode` is in the set.
    #[must_use]
    pub const fn allow(self, mode: Mode) -> bool {
        match mode {
            Mode::Direct => self.direct,
            Mode::Program => self.program,
        }
    }
}

/// A field that program text writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// The type byte.
    Type,
    /// The motor or bank byte.
    Motor,
    /// The value.
    Value,
}

/// What the type byte holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TypeField {
    /// Nothing; any value is accepted.
    Unused,
    /// One of [`CommandSpec::types`].
    Named,
    /// An axis parameter number.
    AxisParameter,
    /// A global parameter number; the bank is in the motor field.
    GlobalParameter,
    /// An I/O port; the bank is in the motor field.
    Port,
    /// A coordinate number.
    Coordinate,
    /// An interrupt number.
    Interrupt,
}

/// What the motor/bank byte holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorField {
    /// Nothing; any value is accepted.
    Unused,
    /// The axis.
    Motor,
    /// The bank of parameters or ports.
    Bank,
    /// The axis, or 255 for the forms that copy between RAM and EEPROM.
    CoordinateStore,
}

/// What the value holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueField {
    /// Nothing; any value is accepted.
    Unused,
    /// A parameter's value.
    ParameterValue,
    /// A velocity.
    Velocity,
    /// A position, an offset or a coordinate number, as the type says.
    Position,
    /// The value of a coordinate.
    CoordinateValue,
    /// The state of an output.
    PortValue,
    /// Any number.
    Number,
    /// An address in program memory.
    Address,
    /// A number of 10 ms ticks.
    Ticks,
    /// A motor number.
    Motor,
    /// 1234, or nothing happens.
    Magic,
}

/// A type byte with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NamedType {
    /// The type byte.
    pub value: u8,
    /// The identifier.
    pub id: &'static str,
    /// What program text writes; empty where there is no such text.
    pub keyword: &'static str,
    /// The name, for people.
    pub name: &'static str,
}

/// One command of the family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandSpec {
    /// Which.
    pub command: Command,
    /// The number on the wire.
    pub number: u8,
    /// What program text writes; empty for commands that only a host sends.
    pub mnemonic: &'static str,
    /// OpenTMCL's identifier.
    pub id: &'static str,
    /// The manual's name.
    pub name: &'static str,
    /// What it does, in a line.
    pub summary: &'static str,
    /// The chapter it belongs to.
    pub group: Group,
    /// The fields program text writes, in order.
    pub operands: &'static [Operand],
    /// What the type byte holds.
    pub type_field: TypeField,
    /// What the motor/bank byte holds.
    pub motor_field: MotorField,
    /// What the value holds.
    pub value_field: ValueField,
    /// The type bytes with names.
    pub types: &'static [NamedType],
    /// Where it may be used.
    pub modes: Modes,
    /// Whether it can set the motor moving.
    pub starts_motion: bool,
    /// Whether sending it twice is the same as once.
    pub repeat_safe: bool,
    /// How a slip or contradiction in the manuals was decided; empty otherwise.
    pub note: &'static str,
}

/// A command as one module has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModuleCommand {
    /// The command.
    pub spec: &'static CommandSpec,
    /// The section of the module's manual.
    pub section: &'static str,
    /// The named types this module has.
    pub types: &'static [u8],
    /// Where it may be used; a module without program memory has direct mode only.
    pub modes: Modes,
    /// Where it comes from when the manual does not have it; empty otherwise.
    pub beyond_manual: &'static str,
}

impl ModuleCommand {
    /// The named types this module has, with their names.
    pub fn named_types(&self) -> impl Iterator<Item = &'static NamedType> + '_ {
        self.spec.types.iter().filter(|named| self.types.contains(&named.value))
    }
}
