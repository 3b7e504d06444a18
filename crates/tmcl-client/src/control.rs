//! Running the stored program (commands 128 to 131 and 135; decisions of the project, "Wire").

use std::fmt;
use std::ops::ControlFlow;

use tmcl_link::Link;
use tmcl_tables::Command;
use tmcl_wire::Request;

use crate::{Client, ClientError};

/// Type of command 129: go on where the program counter stands.
const FROM_HERE: u8 = 0;

/// Type of command 129: from the address given.
const FROM_ADDRESS: u8 = 1;

/// What the stored program does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramMode {
    /// Nothing: it ended, or was stopped.
    Stopped,
    /// It runs.
    Running,
    /// It is executed one instruction at a time.
    Stepping,
    /// Nothing: it was reset.
    Reset,
}

impl fmt::Display for ProgramMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Stopped => "stopped",
            Self::Running => "running",
            Self::Stepping => "stepping",
            Self::Reset => "reset",
        })
    }
}

/// The state of the stored program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProgramStatus {
    /// What it does.
    pub mode: ProgramMode,
    /// The address of the instruction that is executed next.
    pub address: u32,
}

impl ProgramStatus {
    /// The state that the value of a reply to command 135 stands for: mode in the top byte, program counter in the others
    /// (decision); `None` when there is no such mode.
    #[must_use]
    pub const fn from_value(value: i32) -> Option<Self> {
        let [mode, high, middle, low] = value.to_be_bytes();
        let mode = match mode {
            0 => ProgramMode::Stopped,
            1 => ProgramMode::Running,
            2 => ProgramMode::Stepping,
            3 => ProgramMode::Reset,
            _ => return None,
        };
        Some(Self { mode, address: u32::from_be_bytes([0, high, middle, low]) })
    }
}

impl<L: Link> Client<L> {
    /// Starts the stored program: at `address`, or where its program counter stands (command 129). The tables do not let it
    /// be sent again: it would start the program afresh.
    ///
    /// # Errors
    /// As [`Client::request`]; status 4 when the address is outside the program memory.
    pub fn run(&mut self, address: Option<u32>) -> Result<(), ClientError> {
        let (kind, value) = match address {
            None => (FROM_HERE, 0),
            Some(address) => (FROM_ADDRESS, address.cast_signed()),
        };
        self.execute(Command::ApplicationRun, kind, 0, value).map(drop)
    }

    /// Stops the stored program (command 128). It can go on from where it was; the motor moves on.
    ///
    /// # Errors
    /// As [`Client::request`].
    pub fn stop_program(&mut self) -> Result<(), ClientError> {
        self.execute(Command::ApplicationStop, 0, 0, 0).map(drop)
    }

    /// Executes one instruction of the stored program (command 130).
    ///
    /// # Errors
    /// As [`Client::request`].
    pub fn step_program(&mut self) -> Result<(), ClientError> {
        self.execute(Command::ApplicationStep, 0, 0, 0).map(drop)
    }

    /// Stops the stored program and sets it back: program counter, stack, registers, flags and interrupts (command 131).
    ///
    /// # Errors
    /// As [`Client::request`].
    pub fn reset_program(&mut self) -> Result<(), ClientError> {
        self.execute(Command::ApplicationReset, 0, 0, 0).map(drop)
    }

    /// Asks what the stored program does (command 135).
    ///
    /// # Errors
    /// As [`Client::request`]; [`ClientError::Meaningless`] when the reply names no mode.
    pub fn program_status(&mut self) -> Result<ProgramStatus, ClientError> {
        let value = self.execute(Command::ApplicationStatus, 0, 0, 0)?;
        let request = Request::new(Command::ApplicationStatus, 0, 0, 0);
        ProgramStatus::from_value(value).ok_or(ClientError::Meaningless { request, value })
    }

    /// Asks what the stored program does until it does not run any more, or `between` breaks off. `between` is called after
    /// each look at a running program; it is the place to wait, to show the state, and to give up.
    ///
    /// # Errors
    /// As [`Client::program_status`].
    pub fn wait_until_stopped(
        &mut self,
        mut between: impl FnMut(ProgramStatus) -> ControlFlow<()>,
    ) -> Result<ProgramStatus, ClientError> {
        loop {
            let status = self.program_status()?;
            if status.mode != ProgramMode::Running || between(status).is_break() {
                return Ok(status);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fake::{FakeModule, Fault};

    #[test]
    fn the_numbers_are_those_of_the_tables() {
        let type_of = |id: &str| {
            let types = Command::ApplicationRun.spec().types;
            types.iter().find(|named| named.id == id).map(|named| named.value)
        };
        assert_eq!((type_of("current"), type_of("address")), (Some(FROM_HERE), Some(FROM_ADDRESS)));
    }

    #[test]
    fn the_state_is_in_the_bytes_of_the_value() {
        let running = ProgramStatus { mode: ProgramMode::Running, address: 2047 };
        assert_eq!(ProgramStatus::from_value(0x0100_07FF), Some(running));
        let reset = ProgramStatus { mode: ProgramMode::Reset, address: 0 };
        assert_eq!(ProgramStatus::from_value(0x0300_0000), Some(reset));
        assert_eq!(ProgramStatus::from_value(0x0400_0000), None);
        assert_eq!(ProgramStatus::from_value(-1), None);
    }

    #[test]
    fn a_program_is_run_stopped_stepped_and_reset() {
        let mut client = Client::new(FakeModule::default());
        let mut status_after = |call: &dyn Fn(&mut Client<FakeModule>) -> Result<(), ClientError>| {
            call(&mut client).expect("the module does it");
            client.program_status().expect("it says so")
        };
        let status = |mode, address| ProgramStatus { mode, address };
        assert_eq!(status_after(&|client| client.run(Some(5))), status(ProgramMode::Running, 5));
        assert_eq!(status_after(&Client::stop_program), status(ProgramMode::Stopped, 5));
        assert_eq!(status_after(&|client| client.run(None)), status(ProgramMode::Running, 5));
        assert_eq!(status_after(&Client::step_program), status(ProgramMode::Stepping, 6));
        assert_eq!(status_after(&Client::reset_program), status(ProgramMode::Reset, 0));
    }

    /// A step that may have been executed is not sent again.
    #[test]
    fn a_lost_reply_does_not_step_twice() {
        let mut client = Client::new(FakeModule::with_faults([Fault::LoseReply]));
        assert!(matches!(client.step_program(), Err(ClientError::NoReply { attempts: 1, .. })));
        assert_eq!(client.program_status().expect("it answers").address, 1);
    }

    #[test]
    fn waiting_ends_with_the_program_or_with_patience() {
        let mut client = Client::new(FakeModule::default());
        client.run(Some(0)).expect("the module does it");
        let mut looks = 0;
        let status = client.wait_until_stopped(|_| {
            looks += 1;
            if looks == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!((status.expect("it answers").mode, looks), (ProgramMode::Running, 3));
        client.stop_program().expect("the module does it");
        let status = client.wait_until_stopped(|_| panic!("it does not run"));
        assert_eq!(status.expect("it answers").mode, ProgramMode::Stopped);
    }

    #[test]
    fn a_mode_that_does_not_exist_is_reported() {
        let mut client = Client::new(FakeModule { mode: 9, ..FakeModule::default() });
        assert!(matches!(client.program_status(), Err(ClientError::Meaningless { value: 0x0900_0000, .. })));
    }
}
