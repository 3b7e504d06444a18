//! A non-volatile memory that survives a power cycle of the virtual module, though not the end of the process.

use std::collections::BTreeMap;

use module_firmware::{ERASED, Instruction, RecordKey, Storage, StorageError};

/// Records in memory.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Eeprom {
    records: BTreeMap<u16, Vec<u8>>,
    /// The program as far as it was written.
    program: Vec<Instruction>,
    writes: u64,
}

impl Eeprom {
    /// Records written since it was new.
    #[must_use]
    pub fn writes(&self) -> u64 {
        self.writes
    }
}

impl Storage for Eeprom {
    fn read(&mut self, key: RecordKey, out: &mut [u8]) -> Result<usize, StorageError> {
        let Some(record) = self.records.get(&key.to_u16()) else { return Ok(0) };
        let target = out.get_mut(..record.len()).ok_or(StorageError::Medium)?;
        target.copy_from_slice(record);
        Ok(record.len())
    }

    fn write(&mut self, key: RecordKey, value: &[u8]) -> Result<(), StorageError> {
        self.records.insert(key.to_u16(), value.to_vec());
        self.writes += 1;
        Ok(())
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.records.clear();
        Ok(())
    }

    fn read_program(&mut self, out: &mut [Instruction]) -> Result<(), StorageError> {
        out.fill(ERASED);
        for (slot, instruction) in out.iter_mut().zip(&self.program) {
            *slot = *instruction;
        }
        Ok(())
    }

    fn write_instruction(&mut self, address: u16, instruction: Instruction) -> Result<(), StorageError> {
        let index = usize::from(address);
        if self.program.len() <= index {
            self.program.resize(index + 1, ERASED);
        }
        let slot = self.program.get_mut(index).ok_or(StorageError::Medium)?;
        *slot = instruction;
        self.writes += 1;
        Ok(())
    }

    fn erase_program(&mut self) -> Result<(), StorageError> {
        self.program.clear();
        self.writes += 1;
        Ok(())
    }
}
