//! A queue of bytes in fixed memory.

/// Up to `N` bytes, first in, first out.
#[derive(Clone)]
pub(crate) struct Ring<const N: usize> {
    bytes: [u8; N],
    start: usize,
    length: usize,
}

impl<const N: usize> Ring<N> {
    pub(crate) const fn new() -> Self {
        Self { bytes: [0; N], start: 0, length: 0 }
    }

    /// Bytes that still fit.
    pub(crate) const fn room(&self) -> usize {
        N - self.length
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Appends a byte; false when it did not fit.
    pub(crate) fn push(&mut self, byte: u8) -> bool {
        let Some(slot) = self.bytes.get_mut((self.start + self.length) % N).filter(|_| self.length < N)
        else {
            return false;
        };
        *slot = byte;
        self.length += 1;
        true
    }

    /// The byte that is next.
    pub(crate) fn peek(&self) -> Option<u8> {
        self.bytes.get(self.start).copied().filter(|_| self.length > 0)
    }

    pub(crate) fn pop(&mut self) -> Option<u8> {
        let byte = self.peek()?;
        self.start = (self.start + 1) % N;
        self.length -= 1;
        Some(byte)
    }

    pub(crate) fn clear(&mut self) {
        self.length = 0;
    }
}

impl<const N: usize> core::fmt::Debug for Ring<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let bytes = self.bytes.iter().cycle().skip(self.start).take(self.length);
        f.debug_list().entries(bytes).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_in_first_out_and_nothing_beyond_its_size() {
        let mut ring = Ring::<3>::new();
        for round in 0..5 {
            assert_eq!(ring.room(), 3);
            assert!(ring.push(round) && ring.push(1) && ring.push(2) && !ring.push(3));
            assert_eq!(
                [ring.pop(), ring.pop(), ring.pop(), ring.pop()],
                [Some(round), Some(1), Some(2), None]
            );
        }
    }
}
