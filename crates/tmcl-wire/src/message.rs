//! What travels: a request to a module and its reply.

use tmcl_tables::{Command, Status};

/// A command on its way to a module (TMCM-1311 §4.1).
///
/// The command number is raw: whether the module has such a command is not this crate's business.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// The command number.
    pub command: u8,
    /// The type byte: a parameter, port or coordinate number, or a variant of the command.
    pub kind: u8,
    /// The motor or bank byte.
    pub motor: u8,
    /// The value.
    pub value: i32,
}

impl Request {
    /// A request for a command of the family.
    #[must_use]
    pub const fn new(command: Command, kind: u8, motor: u8, value: i32) -> Self {
        Self { command: command.number(), kind, motor, value }
    }

    /// The seven bytes that are the same on every carrier and in program memory.
    #[must_use]
    pub const fn to_bytes(self) -> [u8; 7] {
        let [a, b, c, d] = self.value.to_be_bytes();
        [self.command, self.kind, self.motor, a, b, c, d]
    }

    /// The request that these seven bytes stand for; every seven bytes stand for one.
    #[must_use]
    pub const fn from_bytes(bytes: [u8; 7]) -> Self {
        let [command, kind, motor, a, b, c, d] = bytes;
        Self { command, kind, motor, value: i32::from_be_bytes([a, b, c, d]) }
    }
}

/// A module's answer (TMCM-1311 §4.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reply {
    /// How it went.
    pub status: Status,
    /// The command that is answered; 0 after a wrong checksum.
    pub command: u8,
    /// The value read, or the value sent; 0 with an error status.
    pub value: i32,
}

impl Reply {
    /// The answer to a datagram with a wrong checksum, which may have been any command.
    pub const WRONG_CHECKSUM: Self = Self { status: Status::WrongChecksum, command: 0, value: 0 };
}
