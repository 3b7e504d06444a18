//! The call stack of CSUB and RSUB (TMCM-1311 §5.7.20, §5.7.21).

/// How deep subroutine calls can nest.
pub const DEPTH: usize = 8;

/// Return addresses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Stack {
    addresses: [u16; DEPTH],
    depth: u8,
}

impl Stack {
    /// Keeps a return address; false when there is no room.
    pub(crate) fn push(&mut self, address: u16) -> bool {
        match self.addresses.get_mut(usize::from(self.depth)) {
            Some(slot) => {
                *slot = address;
                self.depth += 1;
                true
            }
            None => false,
        }
    }

    /// The last return address.
    pub(crate) fn pop(&mut self) -> Option<u16> {
        self.depth = self.depth.checked_sub(1)?;
        self.addresses.get(usize::from(self.depth)).copied()
    }

    /// The return addresses, the innermost last.
    pub(crate) fn as_slice(&self) -> &[u16] {
        self.addresses.get(..usize::from(self.depth)).unwrap_or(&[])
    }
}
