//! The board's 16 MiB of PSRAM as the media of a module: a NOR flash for its records, an EEPROM for its program.
//!
//! QEMU can keep this memory in a file, and then it survives the emulator as flash and EEPROM survive a power cut. The flash
//! behaves as one: words are written, bits only ever fall, and pages are erased to ones.

use core::convert::Infallible;
use core::ops::Range;

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use embedded_storage::{ReadStorage, Storage};
use module_firmware::{ERASED, Instruction, ProgramMemory, StorageError};
use module_storage::ModuleStorage;

/// Where the PSRAM lies (Arm DAI 0385, memory map).
const BASE: usize = 0x2100_0000;

/// Of it, the flash: four pages.
const FLASH_PAGE: usize = 4096;
const FLASH_BYTES: usize = 4 * FLASH_PAGE;

/// And the EEPROM.
const EEPROM_START: usize = 0x1_0000;
const EEPROM_BYTES: usize = 0x1_0000;

/// A module's media.
pub type Media = ModuleStorage<Flash, Eeprom>;

/// Opens the media of a module with a program memory of so many instructions.
///
/// # Errors
/// [`StorageError`] when the program memory is too large for the EEPROM.
pub fn open(instructions: u16) -> Result<Media, StorageError> {
    const PAGES: Range<u32> = 0..FLASH_BYTES as u32;
    ModuleStorage::open(Flash(()), PAGES, Eeprom(()), instructions)
}

/// A program memory of `N` instructions that is executed where it is stored: this memory is as fast as any.
#[derive(Clone, Copy, Debug, Default)]
pub struct InPlacePrograms<const N: u16>;

impl<const N: u16> ProgramMemory for InPlacePrograms<N> {
    fn length(&self) -> u16 {
        N
    }

    fn get(&self, address: u16) -> Option<Instruction> {
        (address < N).then(|| module_storage::read_instruction(&mut Eeprom(()), address).unwrap_or(ERASED))
    }

    /// The storage has written it.
    fn set(&mut self, _: u16, _: Instruction) {}

    /// The storage erases it: this medium never fails.
    fn erase(&mut self) {}

    fn restore<S: module_firmware::Storage>(&mut self, _: &mut S) -> Result<(), StorageError> {
        Ok(())
    }
}

/// The flash: 16 KiB in four pages.
pub struct Flash(());

/// The EEPROM: 64 KiB.
pub struct Eeprom(());

/// A byte of the PSRAM that has `offset` from its start, less than 16 MiB.
fn byte(offset: usize) -> *mut u8 {
    (BASE + offset) as *mut u8
}

fn read(start: usize, bytes: &mut [u8]) {
    for (offset, byte_read) in (start..).zip(bytes) {
        // SAFETY: the callers stay within the PSRAM, which is nobody else's.
        *byte_read = unsafe { byte(offset).read_volatile() };
    }
}

impl ErrorType for Flash {
    type Error = Infallible;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        read(offset as usize, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        FLASH_BYTES
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = FLASH_PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
        for offset in (from..to).step_by(4) {
            // SAFETY: pages are made of words, and these lie in the PSRAM.
            unsafe { byte(offset as usize).cast::<u32>().write_volatile(u32::MAX) };
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
        for (offset, word) in (offset as usize..).step_by(4).zip(bytes.as_chunks().0) {
            let word = u32::from_le_bytes(*word);
            let place = byte(offset).cast::<u32>();
            // SAFETY: `WRITE_SIZE` makes these whole words, at addresses of words in the PSRAM.
            unsafe { place.write_volatile(place.read_volatile() & word) };
        }
        Ok(())
    }
}

impl ReadStorage for Eeprom {
    type Error = Infallible;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        read(EEPROM_START + offset as usize, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        EEPROM_BYTES
    }
}

impl Storage for Eeprom {
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
        for (offset, value) in (EEPROM_START + offset as usize..).zip(bytes) {
            // SAFETY: `ModuleStorage` stays within the capacity.
            unsafe { byte(offset).write_volatile(*value) };
        }
        Ok(())
    }
}
