//! Values kept by index: parameters that are what was written to them.

/// `N` values of 32 bits. An index beyond them reads 0 and writes nothing; the generated `index()` never gives one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Values<const N: usize>([i32; N]);

impl<const N: usize> Values<N> {
    pub(crate) const fn zero() -> Self {
        Self([0; N])
    }

    pub(crate) fn clear(&mut self) {
        self.0.fill(0);
    }

    pub(crate) fn get(&self, index: usize) -> i32 {
        self.0.get(index).copied().unwrap_or(0)
    }

    pub(crate) fn set(&mut self, index: usize, value: i32) {
        if let Some(slot) = self.0.get_mut(index) {
            *slot = value;
        }
    }
}
