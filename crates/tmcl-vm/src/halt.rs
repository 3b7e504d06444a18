//! Where a debugger wants to look.

/// Asked before each instruction whether to halt there. It sees everything and can change nothing.
pub trait Halt<M> {
    /// Whether to halt before the instruction at `address`.
    fn before(&mut self, machine: &M, address: u16) -> bool;
}

/// Never halts.
#[derive(Clone, Copy, Debug, Default)]
pub struct NeverHalt;

impl<M> Halt<M> for NeverHalt {
    #[inline]
    fn before(&mut self, _machine: &M, _address: u16) -> bool {
        false
    }
}

/// Watch conditions: any function of machine and address.
impl<M, F: FnMut(&M, u16) -> bool> Halt<M> for F {
    fn before(&mut self, machine: &M, address: u16) -> bool {
        self(machine, address)
    }
}

/// Addresses to halt at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breakpoints {
    words: [u64; Self::WORDS],
}

impl Breakpoints {
    const WORDS: usize = 2048 / 64;

    /// None.
    #[must_use]
    pub const fn new() -> Self {
        Self { words: [0; Self::WORDS] }
    }

    /// Sets or removes one. False when the address is beyond every program memory, 2048.
    pub fn set(&mut self, address: u16, on: bool) -> bool {
        let Some(word) = self.words.get_mut(usize::from(address / 64)) else { return false };
        let bit = 1 << (address % 64);
        *word = if on { *word | bit } else { *word & !bit };
        true
    }

    /// Whether there is one.
    #[must_use]
    pub fn contains(&self, address: u16) -> bool {
        self.words.get(usize::from(address / 64)).is_some_and(|word| (word >> (address % 64)) & 1 != 0)
    }
}

impl Default for Breakpoints {
    fn default() -> Self {
        Self::new()
    }
}

impl<M> Halt<M> for Breakpoints {
    fn before(&mut self, _machine: &M, address: u16) -> bool {
        self.contains(address)
    }
}
