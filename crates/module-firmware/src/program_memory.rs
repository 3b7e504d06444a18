//! The memory of a stand-alone program: a raw region of the EEPROM, mirrored in RAM or executed in place.

use tmcl_tables::Command;

use crate::storage::{Storage, StorageError};

/// Seven bytes: a command without address and checksum.
pub type Instruction = [u8; 7];

/// What erased memory reads as: STOP (decision).
pub const ERASED: Instruction = [Command::Stop.number(), 0, 0, 0, 0, 0, 0];

/// Program memory of some size: what the program is executed from.
pub trait ProgramMemory: Clone + Default {
    /// Instructions that fit.
    fn length(&self) -> u16;
    /// The instruction at an address; None beyond the end.
    fn get(&self, address: u16) -> Option<Instruction>;
    /// Takes note of an instruction that the storage has written; nothing happens beyond the end.
    fn set(&mut self, address: u16, instruction: Instruction);
    /// As new.
    fn erase(&mut self);
    /// What the storage holds.
    ///
    /// # Errors
    /// [`StorageError::Medium`] when it cannot be read; then this memory holds anything.
    fn restore<S: Storage>(&mut self, storage: &mut S) -> Result<(), StorageError>;
}

/// A mirror in RAM of `N` instructions.
#[derive(Clone, PartialEq, Eq)]
pub struct Programs<const N: usize>([Instruction; N]);

impl<const N: usize> Default for Programs<N> {
    fn default() -> Self {
        Self([ERASED; N])
    }
}

impl<const N: usize> ProgramMemory for Programs<N> {
    fn length(&self) -> u16 {
        u16::try_from(N).unwrap_or(u16::MAX)
    }

    #[inline]
    fn get(&self, address: u16) -> Option<Instruction> {
        self.0.get(usize::from(address)).copied()
    }

    fn set(&mut self, address: u16, instruction: Instruction) {
        if let Some(slot) = self.0.get_mut(usize::from(address)) {
            *slot = instruction;
        }
    }

    fn erase(&mut self) {
        self.0.fill(ERASED);
    }

    fn restore<S: Storage>(&mut self, storage: &mut S) -> Result<(), StorageError> {
        storage.read_program(&mut self.0)
    }
}

impl<const N: usize> core::fmt::Debug for Programs<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let used = self.0.iter().rposition(|instruction| *instruction != ERASED).map_or(0, |last| last + 1);
        write!(f, "Programs({used} of {N})")
    }
}
