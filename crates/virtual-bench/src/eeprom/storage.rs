//! The EEPROM as the firmware sees it.

use module_firmware::{ERASED, Instruction, RecordKey, Storage, StorageError};

use super::cell;
use super::layout::{self, ERASURE, PROGRAM, RECORD, RECORDS, Region};
use super::{Eeprom, medium};

/// What is being erased. While this stands in its cell, all that it covers reads as erased, whatever the bytes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Erasing {
    Records,
    Program,
}

impl Erasing {
    const fn to_bytes(self) -> [u8; RECORD] {
        match self {
            Self::Records => [1, 0, 0, 0],
            Self::Program => [2, 0, 0, 0],
        }
    }

    fn from_bytes(bytes: [u8; RECORD]) -> Option<Self> {
        [Self::Records, Self::Program].into_iter().find(|erasing| erasing.to_bytes() == bytes)
    }

    const fn region(self) -> Region {
        match self {
            Self::Records => RECORDS,
            Self::Program => PROGRAM,
        }
    }
}

/// Nothing is.
const NOTHING: [u8; RECORD] = [0; RECORD];

impl Eeprom {
    /// What was being erased when the power failed, or is now.
    pub(super) fn erasing(&self) -> Option<Erasing> {
        erasing(self.medium.bytes())
    }

    /// Clears what was being erased. Nothing is where nothing was.
    pub(super) fn finish_erasing(&mut self) {
        let Some(erasing) = self.erasing() else { return };
        let bytes = erasing.region().bytes();
        self.medium.write(bytes.start, bytes.map(|_| medium::ERASED));
        cell::write(&mut self.medium, ERASURE, 0, NOTHING);
    }

    fn erase_region(&mut self, erasing: Erasing) -> Result<(), StorageError> {
        let bytes = self.medium.bytes().get(erasing.region().bytes()).unwrap_or_default();
        if bytes.iter().any(|byte| *byte != medium::ERASED) {
            cell::write(&mut self.medium, ERASURE, 0, erasing.to_bytes());
            self.finish_erasing();
        }
        self.written()
    }

    /// Nobody is told that something was written after the power failed.
    fn written(&self) -> Result<(), StorageError> {
        if self.is_cut() { Err(StorageError::Medium) } else { Ok(()) }
    }
}

/// What is being erased on a medium with these bytes.
pub(super) fn erasing(bytes: &[u8]) -> Option<Erasing> {
    cell::read(bytes, ERASURE, 0).and_then(Erasing::from_bytes)
}

impl Storage for Eeprom {
    fn read(&mut self, key: RecordKey, out: &mut [u8]) -> Result<usize, StorageError> {
        let Some(record) = self.record(key) else { return Ok(0) };
        let target = out.get_mut(..record.len()).ok_or(StorageError::Medium)?;
        target.copy_from_slice(&record);
        Ok(record.len())
    }

    /// There is room for records of four bytes, and none for global parameters of banks other than 0 and 2.
    fn write(&mut self, key: RecordKey, value: &[u8]) -> Result<(), StorageError> {
        let cell = layout::record_cell(key).ok_or(StorageError::Full)?;
        let value: [u8; RECORD] = value.try_into().map_err(|_| StorageError::Full)?;
        cell::write(&mut self.medium, RECORDS, cell, value);
        self.written()
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.erase_region(Erasing::Records)
    }

    fn read_program(&mut self, out: &mut [Instruction]) -> Result<(), StorageError> {
        out.fill(ERASED);
        for (slot, instruction) in out.iter_mut().zip(self.instructions()) {
            *slot = instruction.unwrap_or(ERASED);
        }
        Ok(())
    }

    fn write_instruction(&mut self, address: u16, instruction: Instruction) -> Result<(), StorageError> {
        let cell = usize::from(address);
        if cell >= PROGRAM.cells {
            return Err(StorageError::Full);
        }
        cell::write(&mut self.medium, PROGRAM, cell, instruction);
        self.written()
    }

    fn erase_program(&mut self) -> Result<(), StorageError> {
        self.erase_region(Erasing::Program)
    }
}
