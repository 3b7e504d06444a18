//! One instruction of a program, as the modules keep it.

use tmcl_tables::Command;

/// Stands for all ports of a bank in SIO and GIO, for all interrupts in EI and DI, and for the EEPROM in place of a motor in
/// SCO and GCO (TMCM-1311 §5.7.14, §5.7.15, §5.7.24, §5.7.25, §5.7.33).
pub(crate) const ALL: u8 = 255;

/// The seven bytes of an instruction, by their fields (TMCM-1311 §4.1: a command without address and checksum).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Instruction {
    /// The command number.
    pub command: u8,
    /// The type byte.
    pub kind: u8,
    /// The motor or bank byte.
    pub motor: u8,
    /// The value.
    pub value: i32,
}

impl Instruction {
    /// What ends a program, and what erased program memory reads as.
    pub const STOP: Self = Self { command: Command::Stop.number(), kind: 0, motor: 0, value: 0 };

    /// Command, type, motor or bank, and the value with its most significant byte first.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; 7] {
        let [a, b, c, d] = self.value.to_be_bytes();
        [self.command, self.kind, self.motor, a, b, c, d]
    }

    /// The instruction that these seven bytes are; every seven bytes are one.
    #[must_use]
    pub const fn from_bytes(bytes: [u8; 7]) -> Self {
        let [command, kind, motor, a, b, c, d] = bytes;
        Self { command, kind, motor, value: i32::from_be_bytes([a, b, c, d]) }
    }

    /// The command, where the number is one of the family's.
    #[must_use]
    pub fn known_command(self) -> Option<Command> {
        Command::try_from(self.command).ok()
    }

    /// Whether nothing can run on behind it, so that the assembler appends no STOP to a program that ends with it.
    pub(crate) fn ends_a_program(self) -> bool {
        use Command::{Jump, ReturnFromInterrupt, ReturnFromSubroutine, Stop};
        matches!(self.known_command(), Some(Stop | Jump | ReturnFromSubroutine | ReturnFromInterrupt))
    }
}
