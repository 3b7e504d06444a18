//! The firmware's non-volatile memory on real media: [`module_firmware::Storage`] for a board with NOR flash and EEPROM.
//!
//! Records go to NOR flash, which wears and can only be erased in pages; `sequential-storage` writes them one behind the
//! other and moves what is still good when a page is full. The program goes to a region that can be written byte by byte: an
//! EEPROM, FRAM, or a flash behind a driver that makes it look so. Each instruction has two places there, and the one that
//! stands is never touched while the other is written. Power may fail before, within and after any write.
//!
//! This crate must never know which media it writes to, nor what a record means. It allocates nothing.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod blocking;
mod header;
mod in_place;
mod program;
mod records;

use core::ops::Range;

use embedded_storage::Storage as ByteStorage;
use embedded_storage::nor_flash::NorFlash;
use module_firmware::{Instruction, RecordKey, Storage, StorageError};

pub use in_place::InPlace;

use header::{Header, Part};
use records::Records;

/// The instruction at an address of the program in an EEPROM that [`ModuleStorage`] writes, for those who execute it in place.
///
/// # Errors
/// [`StorageError::Medium`] where the medium fails, or ends before the address.
pub fn read_instruction(eeprom: &mut impl ByteStorage, address: u16) -> Result<Instruction, StorageError> {
    program::read(eeprom, address)
}

/// Records in NOR flash `F`, the program in `E`, which is written byte by byte.
pub struct ModuleStorage<F: NorFlash, E: ByteStorage> {
    records: Records<F>,
    eeprom: E,
    instructions: u16,
}

impl<F: NorFlash, E: ByteStorage> ModuleStorage<F, E> {
    /// Bytes of `E` that a program memory of this many instructions takes.
    #[must_use]
    pub const fn eeprom_bytes(instructions: u16) -> u32 {
        program::START + program::SLOT * instructions as u32
    }

    /// Opens media for a program memory of so many instructions. What they hold is kept; media that were never opened before
    /// are formatted, and an erasure that a power failure interrupted is finished.
    ///
    /// # Errors
    /// [`StorageError::Full`] where `pages` are not two erasable pages of `F` or more, or `E` is smaller than
    /// [`ModuleStorage::eeprom_bytes`]; [`StorageError::Medium`] where a medium fails.
    pub fn open(flash: F, pages: Range<u32>, eeprom: E, instructions: u16) -> Result<Self, StorageError> {
        let bytes = usize::try_from(Self::eeprom_bytes(instructions)).map_err(|_| StorageError::Full)?;
        if eeprom.capacity() < bytes {
            return Err(StorageError::Full);
        }
        let mut storage = Self { records: Records::new(flash, pages)?, eeprom, instructions };
        let header = Header::read(&mut storage.eeprom)?;
        if !header.is_formatted() {
            storage.records.erase()?;
            program::format(&mut storage.eeprom, instructions)?;
            Header::format(&mut storage.eeprom)?;
        } else {
            if header.is_unfinished(Part::Records) {
                storage.erase_records()?;
            }
            if header.is_unfinished(Part::Program) {
                storage.erase_instructions()?;
            }
        }
        Ok(storage)
    }

    fn erase_records(&mut self) -> Result<(), StorageError> {
        Header::begin(&mut self.eeprom, Part::Records)?;
        self.records.erase()?;
        Header::finish(&mut self.eeprom, Part::Records)
    }

    fn erase_instructions(&mut self) -> Result<(), StorageError> {
        Header::begin(&mut self.eeprom, Part::Program)?;
        program::erase(&mut self.eeprom, self.instructions)?;
        Header::finish(&mut self.eeprom, Part::Program)
    }

    /// The media, for those who look on or cut the power.
    pub fn into_media(self) -> (F, E) {
        (self.records.into_flash(), self.eeprom)
    }
}

impl<F: NorFlash, E: ByteStorage> Storage for ModuleStorage<F, E> {
    fn read(&mut self, key: RecordKey, out: &mut [u8]) -> Result<usize, StorageError> {
        self.records.read(key.to_u16(), out)
    }

    fn write(&mut self, key: RecordKey, value: &[u8]) -> Result<(), StorageError> {
        self.records.write(key.to_u16(), value)
    }

    fn erase(&mut self) -> Result<(), StorageError> {
        self.erase_records()
    }

    fn read_program(&mut self, out: &mut [Instruction]) -> Result<(), StorageError> {
        for (address, slot) in (0..self.instructions).zip(out) {
            *slot = program::read(&mut self.eeprom, address)?;
        }
        Ok(())
    }

    fn write_instruction(&mut self, address: u16, instruction: Instruction) -> Result<(), StorageError> {
        if address >= self.instructions {
            return Err(StorageError::Full);
        }
        program::write(&mut self.eeprom, address, instruction)
    }

    fn erase_program(&mut self) -> Result<(), StorageError> {
        self.erase_instructions()
    }
}
