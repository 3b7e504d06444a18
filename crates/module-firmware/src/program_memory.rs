//! The memory of a stand-alone program: a raw region of the EEPROM, mirrored in RAM.

use tmcl_tables::Command;

/// Seven bytes: a command without address and checksum.
pub type Instruction = [u8; 7];

/// What erased memory reads as: STOP (decision).
pub const ERASED: Instruction = [Command::Stop.number(), 0, 0, 0, 0, 0, 0];

/// Program memory of some size.
pub trait ProgramMemory: Clone + Default {
    /// All of it.
    fn instructions(&self) -> &[Instruction];
    /// All of it, to be changed.
    fn instructions_mut(&mut self) -> &mut [Instruction];

    /// The instruction at an address; None beyond the end.
    #[inline]
    fn get(&self, address: u16) -> Option<Instruction> {
        self.instructions().get(usize::from(address)).copied()
    }

    /// Writes an instruction; nothing happens beyond the end.
    fn set(&mut self, address: u16, instruction: Instruction) {
        if let Some(slot) = self.instructions_mut().get_mut(usize::from(address)) {
            *slot = instruction;
        }
    }

    /// As new.
    fn erase(&mut self) {
        self.instructions_mut().fill(ERASED);
    }
}

/// Memory for `N` instructions.
#[derive(Clone, PartialEq, Eq)]
pub struct Programs<const N: usize>([Instruction; N]);

impl<const N: usize> Default for Programs<N> {
    fn default() -> Self {
        Self([ERASED; N])
    }
}

impl<const N: usize> ProgramMemory for Programs<N> {
    fn instructions(&self) -> &[Instruction] {
        &self.0
    }

    fn instructions_mut(&mut self) -> &mut [Instruction] {
        &mut self.0
    }
}

impl<const N: usize> core::fmt::Debug for Programs<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let used = self.0.iter().rposition(|instruction| *instruction != ERASED).map_or(0, |last| last + 1);
        write!(f, "Programs({used} of {N})")
    }
}
