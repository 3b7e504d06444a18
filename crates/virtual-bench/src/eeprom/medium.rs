//! The bytes, how worn they are, and whether there is power to write them.

use super::layout::{IMAGE_LENGTH, PAGE, PAGES, SIZE};
use super::patch::{Patch, Patches};

/// An erased byte.
pub(super) const ERASED: u8 = 0xFF;

/// Bytes that are written one at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Medium {
    bytes: Vec<u8>,
    /// Byte writes in each page.
    wear: Vec<u32>,
    power: Power,
    /// Where somebody wants them.
    patches: Option<Patches>,
}

/// Whether there is power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Power {
    On,
    /// For so many byte writes more; then the byte under way may be torn.
    OnFor(u64, Option<u8>),
    Off,
}

impl Medium {
    /// Erased but for the bytes at its beginning, and not worn.
    pub(super) fn new(beginning: &[u8]) -> Self {
        let mut bytes = vec![ERASED; SIZE];
        bytes.iter_mut().zip(beginning).for_each(|(slot, byte)| *slot = *byte);
        Self { bytes, wear: vec![0; PAGES], power: Power::On, patches: None }
    }

    /// The image's; `None` when it has another length.
    pub(super) fn from_image(image: &[u8]) -> Option<Self> {
        if image.len() != IMAGE_LENGTH {
            return None;
        }
        let (bytes, wear) = image.split_at(SIZE);
        let (counters, _) = wear.as_chunks();
        let wear = counters.iter().map(|counter| u32::from_le_bytes(*counter)).collect();
        Some(Self { bytes: bytes.to_vec(), wear, power: Power::On, patches: None })
    }

    pub(super) fn to_image(&self) -> Vec<u8> {
        let mut image = Vec::with_capacity(IMAGE_LENGTH);
        image.extend_from_slice(&self.bytes);
        image.extend(self.wear.iter().flat_map(|writes| writes.to_le_bytes()));
        image
    }

    pub(super) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    pub(super) fn wear(&self) -> &[u32] {
        &self.wear
    }

    /// Writes bytes one after the other; those that hold already what they shall are left alone.
    pub(super) fn write(&mut self, address: usize, bytes: impl IntoIterator<Item = u8>) {
        for (address, byte) in (address..SIZE).zip(bytes) {
            self.write_byte(address, byte);
        }
    }

    fn write_byte(&mut self, address: usize, byte: u8) {
        let Some(slot) = self.bytes.get_mut(address).filter(|slot| **slot != byte) else { return };
        let byte = match &mut self.power {
            Power::On => byte,
            Power::OnFor(writes @ 1.., _) => {
                *writes -= 1;
                byte
            }
            Power::OnFor(0, torn) => {
                let torn = torn.unwrap_or(*slot);
                self.power = Power::Off;
                torn
            }
            Power::Off => return,
        };
        if *slot == byte {
            return;
        }
        *slot = byte;
        if let Some(writes) = self.wear.get_mut(address / PAGE) {
            *writes = writes.saturating_add(1);
        }
        if let Some(patches) = &mut self.patches {
            patches.note(address, byte);
        }
    }

    pub(super) fn cut_after(&mut self, writes: u64, torn: Option<u8>) {
        self.power = Power::OnFor(writes, torn);
    }

    pub(super) fn never_cut(&mut self) {
        if !self.is_cut() {
            self.power = Power::On;
        }
    }

    pub(super) fn is_cut(&self) -> bool {
        self.power == Power::Off
    }

    /// A cut that is still to come stays.
    pub(super) fn restore_power(&mut self) {
        if self.is_cut() {
            self.power = Power::On;
        }
    }

    pub(super) fn note_patches(&mut self) {
        self.patches.get_or_insert_default();
    }

    pub(super) fn has_patches(&self) -> bool {
        self.patches.as_ref().is_some_and(|patches| !patches.is_empty())
    }

    pub(super) fn take_patches(&mut self) -> Vec<Patch> {
        self.patches.as_mut().map_or_else(Vec::new, |patches| patches.take(&self.wear))
    }
}
