//! What changed since somebody asked, for those who keep an image.

use core::ops::Range;

use super::layout::{PAGE, SIZE};

/// Neighbouring bytes of an image that changed, to be written from the first to the last.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Where in the image they begin.
    pub offset: usize,
    /// What they are now.
    pub bytes: Vec<u8>,
}

impl Patch {
    fn end(&self) -> usize {
        self.offset + self.bytes.len()
    }
}

/// Patches in the order of the byte writes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Patches {
    patches: Vec<Patch>,
    /// From the first to the last page written to.
    pages: Range<usize>,
}

impl Patches {
    pub(super) fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// A byte was written.
    pub(super) fn note(&mut self, address: usize, byte: u8) {
        let page = address / PAGE;
        self.pages = match self.patches.is_empty() {
            true => page..page + 1,
            false => self.pages.start.min(page)..self.pages.end.max(page + 1),
        };
        match self.patches.last_mut().filter(|last| last.end() == address) {
            Some(last) => last.bytes.push(byte),
            None => self.patches.push(Patch { offset: address, bytes: vec![byte] }),
        }
    }

    /// All of them, and the wear of the pages they are in.
    pub(super) fn take(&mut self, wear: &[u32]) -> Vec<Patch> {
        let mut patches = core::mem::take(&mut self.patches);
        if !patches.is_empty() {
            let pages = core::mem::take(&mut self.pages);
            let offset = SIZE + 4 * pages.start;
            let counters = wear.get(pages).unwrap_or_default();
            patches.push(Patch {
                offset,
                bytes: counters.iter().flat_map(|writes| writes.to_le_bytes()).collect(),
            });
        }
        patches
    }
}
