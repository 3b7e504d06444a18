//! A serial EEPROM byte by byte: 64 KiB in pages of 128 bytes, erased to 0xFF, as a 25LC512 has them.
//!
//! All that is ever done to it is to write one byte, and the power may fail between any two of them (or in the middle of
//! one). Afterwards every record and every instruction holds its old or its new value, whole: each lives in a cell of two
//! slots ([`cell`]), and the slot that is written is never the one that counts. To forget all records, or the program, is one
//! write to such a cell too; what it covers is cleared thereafter, and a power-on goes on with that ([`storage`]).
//!
//! It must never know files. Whoever keeps its image somewhere asks for [`Eeprom::take_patches`], whose bytes are in the order
//! of the byte writes, so that a keeper who is stopped at any of them has what a power cut leaves.

mod cell;
mod check;
mod layout;
mod medium;
mod patch;
mod storage;
#[cfg(test)]
mod tests;

pub use check::{Damage, Fault, ImageError, Place};
pub use layout::{FORMAT, IMAGE_LENGTH, PAGE, PAGES, SIZE};
pub use patch::Patch;

use module_firmware::{ERASED, Instruction, RecordKey};

use crate::ModuleKind;
use layout::{PROGRAM, RECORDS};
use medium::Medium;
use storage::Erasing;

/// How often a page can be written: 25LC512, datasheet, "1M erase/write cycles".
pub const ENDURANCE: u32 = 1_000_000;

/// A non-volatile memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Eeprom {
    kind: ModuleKind,
    medium: Medium,
}

impl Eeprom {
    /// One that is new: it holds what kind of module it belongs to.
    #[must_use]
    pub fn new(kind: ModuleKind) -> Self {
        Self { kind, medium: Medium::new(&layout::header(kind)) }
    }

    /// What [`Eeprom::to_image`] gave, and perhaps [`Eeprom::take_patches`] changed.
    ///
    /// # Errors
    /// [`ImageError`] says what is wrong with it and where. What an interrupted write leaves is not wrong.
    pub fn from_image(image: &[u8]) -> Result<Self, ImageError> {
        check::open(image)
    }

    /// All of it, and what wear it has seen: [`IMAGE_LENGTH`] bytes.
    #[must_use]
    pub fn to_image(&self) -> Vec<u8> {
        self.medium.to_image()
    }

    /// The module it belongs to.
    #[must_use]
    pub fn kind(&self) -> ModuleKind {
        self.kind
    }

    /// The power comes back: a cut that happened is over, and what it interrupted is finished.
    pub fn power_on(&mut self) {
        self.medium.restore_power();
        self.finish_erasing();
    }

    /// The power fails after `writes` further byte writes: the next one is lost, and all that follow until
    /// [`Eeprom::power_on`].
    pub fn cut_after(&mut self, writes: u64) {
        self.medium.cut_after(writes, None);
    }

    /// The power fails in the middle of the byte write after `writes` further ones: the byte is `torn` then, and all that
    /// follow are lost until [`Eeprom::power_on`].
    pub fn cut_within(&mut self, writes: u64, torn: u8) {
        self.medium.cut_after(writes, Some(torn));
    }

    /// A cut that is still to come does not.
    pub fn never_cut(&mut self) {
        self.medium.never_cut();
    }

    /// Whether the power has failed.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.medium.is_cut()
    }

    /// Byte writes since it was new. A byte that holds already what it shall is not written.
    #[must_use]
    pub fn writes(&self) -> u64 {
        self.medium.wear().iter().copied().map(u64::from).sum()
    }

    /// The most worn page, and how often it was written; [`ENDURANCE`] is what it stands.
    #[must_use]
    pub fn most_worn(&self) -> (usize, u32) {
        let pages = self.medium.wear().iter().copied().enumerate();
        pages.max_by_key(|&(page, writes)| (writes, core::cmp::Reverse(page))).unwrap_or_default()
    }

    /// The records it holds, by their keys: axis parameters, coordinates, then global parameters.
    pub fn records(&self) -> impl Iterator<Item = (RecordKey, i32)> + '_ {
        layout::records().filter_map(|key| Some((key, i32::from_le_bytes(self.record(key)?))))
    }

    /// Its program, up to the last instruction that was ever written.
    #[must_use]
    pub fn program(&self) -> Vec<Instruction> {
        let cells: Vec<_> = self.instructions().collect();
        let length = cells.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        cells.into_iter().take(length).map(|instruction| instruction.unwrap_or(ERASED)).collect()
    }

    /// From now on every byte write is noted for [`Eeprom::take_patches`].
    pub fn note_patches(&mut self) {
        self.medium.note_patches();
    }

    /// Whether there is something to take.
    #[must_use]
    pub fn has_patches(&self) -> bool {
        self.medium.has_patches()
    }

    /// What to change in the image, in this order, since it was asked last; the wear comes at the end.
    pub fn take_patches(&mut self) -> Vec<Patch> {
        self.medium.take_patches()
    }

    fn record(&self, key: RecordKey) -> Option<[u8; layout::RECORD]> {
        let cell = layout::record_cell(key)?;
        let counts = self.erasing() != Some(Erasing::Records);
        counts.then(|| cell::read(self.medium.bytes(), RECORDS, cell)).flatten()
    }

    /// Every cell of the program.
    fn instructions(&self) -> impl Iterator<Item = Option<Instruction>> + '_ {
        let counts = self.erasing() != Some(Erasing::Program);
        let read = move |cell| counts.then(|| cell::read(self.medium.bytes(), PROGRAM, cell)).flatten();
        (0..PROGRAM.cells).map(read)
    }
}
