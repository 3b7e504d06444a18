//! Loading a program and reading it back (commands 132 to 134; sibling manuals), as far as its protection lets (TMCM-1311
//! §10.1, GP 81).
//!
//! A download belongs to the port it was begun at (decision): others go on talking to the module as ever, and cannot end it.

use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::Request;

use crate::axis::Axis;
use crate::dispatch::Outcome;
use crate::firmware::Firmware;
use crate::jobs::Job;
use crate::port::PortId;
use crate::program_memory::ProgramMemory;

/// The bit of global parameter 81 that keeps a program from being read back.
pub(crate) const READ_PROTECTION: i32 = 1;

/// The bit that keeps it from being overwritten.
const OVERWRITE_PROTECTION: i32 = 2;

/// A download under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Download {
    pub(crate) port: PortId,
    next: u16,
}

impl<A: Axis> Firmware<A> {
    /// 132: what comes next over this port is stored from `value` on. A running program is stopped. One port at a time.
    pub(crate) fn start_download(&mut self, port: PortId, value: i32) -> Result<(), Status> {
        if self.is_overwriting_protected() {
            return Err(Status::NotAvailable);
        }
        if self.download.is_some_and(|download| download.port != port) {
            return Err(Status::NotAvailable);
        }
        let next = self.program_address(value)?;
        self.vm.stop();
        self.download = Some(Download { port, next });
        Ok(())
    }

    /// 133: ends the download of this port, if it has one.
    pub(crate) fn end_download(&mut self, port: PortId) {
        if self.download.is_some_and(|download| download.port == port) {
            self.download = None;
        }
    }

    /// 134.
    pub(crate) fn read_program(&self, value: i32) -> Result<Outcome, Status> {
        if self.code_protection() & READ_PROTECTION != 0 {
            return Err(Status::NotAvailable);
        }
        let address = u16::try_from(value).ok();
        let instruction =
            address.and_then(|address| self.programs.get(address)).ok_or(Status::InvalidValue)?;
        Ok(Outcome::Instruction(instruction))
    }

    /// While a port downloads, everything but commands 128 to 139 is stored instead of executed.
    pub(crate) fn store_instruction(
        &mut self,
        request: &Request,
        port: PortId,
    ) -> Option<Result<Outcome, Status>> {
        let protected = self.is_overwriting_protected();
        let download = self.download.as_mut().filter(|download| download.port == port)?;
        if (Command::ApplicationStop.number()..=Command::EnterAsciiMode.number()).contains(&request.command) {
            return None;
        }
        // Another port may have set the protection since the download began.
        if protected {
            return Some(Err(Status::NotAvailable));
        }
        let (address, instruction) = (download.next, request.to_bytes());
        if self.programs.get(address).is_none() {
            return Some(Err(Status::InvalidValue));
        }
        download.next += 1;
        Some(Ok(Outcome::Loaded(Job::WriteInstruction(address, instruction), request.value)))
    }

    fn code_protection(&self) -> i32 {
        self.globals.setting(GlobalParameter::CodeProtection)
    }

    fn is_overwriting_protected(&self) -> bool {
        self.code_protection() & OVERWRITE_PROTECTION != 0
    }
}
