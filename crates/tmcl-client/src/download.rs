//! Storing programs and reading them back (commands 132 to 134; decisions of the project, "Wire").
//!
//! An instruction is the seven bytes of a request without address and checksum.

use tmcl_link::Link;
use tmcl_tables::{Command, Group, Status};
use tmcl_wire::Request;

use crate::answer::Question;
use crate::{Client, ClientError};

impl<L: Link> Client<L> {
    /// Stores a program at address 0 on: 132, every instruction as a request that must be answered with status 101, 133.
    /// Calls `progress` with the number of instructions stored, after each.
    ///
    /// A running program should be stopped first. What lies behind the program in the memory stays.
    ///
    /// # Errors
    /// [`ClientError::NotStorable`] before anything is sent. Errors of 132, as status 6 of a module that protects its
    /// program. [`ClientError::Download`] with the first instruction that was not stored, [`ClientError::DownloadEnd`] when
    /// all were and 133 failed. Whatever happens, 133 is sent.
    pub fn download(
        &mut self,
        program: &[[u8; 7]],
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), ClientError> {
        check_storable(program)?;
        let started = self.execute(Command::DownloadStart, 0, 0, 0);
        let stored = started.map(|_| self.store_all(program, progress));
        let ended = self.execute(Command::DownloadEnd, 0, 0, 0);
        let count = program.len();
        match (stored?, ended) {
            (Ok(()), Ok(_)) => Ok(()),
            (Ok(()), Err(error)) => Err(ClientError::DownloadEnd { count, source: Box::new(error) }),
            (Err((address, error)), ended) => {
                Err(ClientError::Download { address, count, ended: ended.is_ok(), source: Box::new(error) })
            }
        }
    }

    /// Reads the instruction at `address` (command 134).
    ///
    /// One instruction cannot be read: `01 01 00 00 00 00 00` from a module with address 1 looks like its complaint about a
    /// wrong checksum, and is reported as that. No assembler writes it: it is a rotation with a type, which has none.
    ///
    /// # Errors
    /// As [`Client::request`]; status 4 when the address is outside the program memory, 6 when the program is protected.
    pub fn read_program_instruction(&mut self, address: u32) -> Result<[u8; 7], ClientError> {
        let request = Request::new(Command::ReadProgramMemory, 0, 0, address.cast_signed());
        self.exchange(request, Question::instruction)
    }

    /// Reads the first `count` instructions of the program memory. Calls `progress` with the number read, after each.
    ///
    /// # Errors
    /// As [`Client::read_program_instruction`].
    pub fn read_program(
        &mut self,
        count: usize,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Vec<[u8; 7]>, ClientError> {
        let mut program = Vec::new();
        for address in 0..count {
            program.push(self.read_program_instruction(memory_address(address))?);
            progress(program.len());
        }
        Ok(program)
    }

    /// Reads the program memory and compares it with `program`. Calls `progress` with the number of instructions that
    /// agree, after each.
    ///
    /// # Errors
    /// [`ClientError::Differs`] with the first that does not agree; as [`Client::read_program_instruction`].
    pub fn verify(
        &mut self,
        program: &[[u8; 7]],
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), ClientError> {
        for (address, &expected) in program.iter().enumerate() {
            let found = self.read_program_instruction(memory_address(address))?;
            if found != expected {
                return Err(ClientError::Differs { address, expected, found });
            }
            progress(address + 1);
        }
        Ok(())
    }

    /// Sends all instructions; on failure tells which was not stored.
    fn store_all(
        &mut self,
        program: &[[u8; 7]],
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), (usize, ClientError)> {
        for (address, instruction) in program.iter().enumerate() {
            self.store(Request::from_bytes(*instruction)).map_err(|error| (address, error))?;
            progress(address + 1);
        }
        Ok(())
    }

    fn store(&mut self, instruction: Request) -> Result<(), ClientError> {
        match self.request(instruction)?.status {
            Status::Loaded => Ok(()),
            _ => Err(ClientError::Executed { request: instruction }),
        }
    }
}

/// A module in download mode executes a host's commands, one of which sets it back to the factory's settings.
fn check_storable(program: &[[u8; 7]]) -> Result<(), ClientError> {
    for (address, instruction) in program.iter().enumerate() {
        let request = Request::from_bytes(*instruction);
        let command = Command::try_from(request.command).map(Command::spec);
        if command.is_ok_and(|spec| spec.group == Group::Host) {
            return Err(ClientError::NotStorable { address, request });
        }
    }
    Ok(())
}

/// An address beyond 32 bits is beyond every memory, and the module says so.
fn memory_address(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests;
