//! What lies where.
//!
//! | pages | what |
//! |---|---|
//! | 0 | the header |
//! | 1, 2 | what is being erased: one cell |
//! | 3 to 92 | the records: 800 cells |
//! | 93 to 434 | the program: 2048 cells |
//!
//! A cell's first slot lies in the first half of its pages, the second in the second half, so that the two wear different
//! pages. No slot lies across pages.

use crc::{CRC_16_IBM_3740, Crc};
use module_firmware::RecordKey;

use crate::ModuleKind;

/// Bytes of the memory.
pub const SIZE: usize = 0x1_0000;

/// Bytes of a page.
pub const PAGE: usize = 128;

/// Pages of the memory.
pub const PAGES: usize = SIZE / PAGE;

/// Bytes of an image: the memory, and how often each page was written, 32 bits each, the low byte first.
pub const IMAGE_LENGTH: usize = SIZE + 4 * PAGES;

/// The version of this layout, which stands in the header.
pub const FORMAT: u8 = 1;

/// Bytes of a record.
pub(super) const RECORD: usize = 4;

/// Bytes of an instruction.
pub(super) const INSTRUCTION: usize = 7;

/// Protects headers and slots: it notices every change within 16 neighbouring bits.
pub(super) static CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// Cells of one size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    first_page: usize,
    pub(super) cells: usize,
    /// Bytes of a slot: a mark, data, and two of checksum.
    pub(super) slot: usize,
}

impl Region {
    const fn new(first_page: usize, cells: usize, data: usize) -> Self {
        Self { first_page, cells, slot: data + 3 }
    }

    /// Slots of a page.
    const fn per_page(self) -> usize {
        PAGE / self.slot
    }

    /// Pages of the first slots, and of the second.
    const fn half(self) -> usize {
        self.cells.div_ceil(self.per_page())
    }

    /// The page behind the region.
    const fn end_page(self) -> usize {
        self.first_page + 2 * self.half()
    }

    /// Every byte of it.
    pub(super) const fn bytes(self) -> core::ops::Range<usize> {
        self.first_page * PAGE..self.end_page() * PAGE
    }

    /// Where a slot of a cell begins: the first (0) or the second (1).
    pub(super) const fn address(self, cell: usize, slot: usize) -> usize {
        let page = self.first_page + slot * self.half() + cell / self.per_page();
        page * PAGE + cell % self.per_page() * self.slot
    }
}

/// What is being erased.
pub(super) const ERASURE: Region = Region::new(1, 1, RECORD);

/// Axis parameters, coordinates, global parameters of bank 0 and bank 2.
pub(super) const RECORDS: Region = Region::new(ERASURE.end_page(), BANK_2 + 256, RECORD);

/// The program.
pub(super) const PROGRAM: Region = Region::new(RECORDS.end_page(), 2048, INSTRUCTION);

/// Where the cells of each kind of record begin.
const COORDINATES: usize = 256;
const BANK_0: usize = COORDINATES + COORDINATE_CELLS as usize;
const BANK_2: usize = BANK_0 + 256;

const COORDINATE_CELLS: u8 = 32;

/// The cell of a record; `None` where there is no room for such a one.
pub(super) fn record_cell(key: RecordKey) -> Option<usize> {
    match key {
        RecordKey::Axis(number) => Some(usize::from(number)),
        RecordKey::Coordinate(number) if number < COORDINATE_CELLS => Some(COORDINATES + usize::from(number)),
        RecordKey::Global(0, number) => Some(BANK_0 + usize::from(number)),
        RecordKey::Global(2, number) => Some(BANK_2 + usize::from(number)),
        RecordKey::Coordinate(_) | RecordKey::Global(..) => None,
    }
}

/// Every record there is room for, in the order of their cells.
pub(super) fn records() -> impl Iterator<Item = RecordKey> {
    let axis = (0..=u8::MAX).map(RecordKey::Axis);
    let coordinates = (0..COORDINATE_CELLS).map(RecordKey::Coordinate);
    let globals =
        [0, 2].into_iter().flat_map(|bank| (0..=u8::MAX).map(move |number| RecordKey::Global(bank, number)));
    axis.chain(coordinates).chain(globals)
}

/// What every header begins with.
pub(super) const SIGNATURE: &[u8; 8] = b"OpenTMCL";

/// Bytes of the header. They mean the same in every version of the format.
pub(super) const HEADER: usize = 13;

/// Signature, format, the module's number (high byte first) and their checksum (likewise).
pub(super) fn header(kind: ModuleKind) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    let (said, checksum) = header.split_at_mut(HEADER - 2);
    let [high, low] = kind.spec().number.to_be_bytes();
    for (slot, byte) in said.iter_mut().zip(SIGNATURE.iter().copied().chain([FORMAT, high, low])) {
        *slot = byte;
    }
    checksum.copy_from_slice(&CRC.checksum(said).to_be_bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_above_is_right() {
        assert_eq!(ERASURE.bytes(), PAGE..3 * PAGE);
        assert_eq!(RECORDS.bytes(), 3 * PAGE..93 * PAGE);
        assert_eq!(PROGRAM.bytes(), 93 * PAGE..435 * PAGE);
        assert_eq!((RECORDS.cells, PROGRAM.cells), (800, 2048));
        assert!(PROGRAM.end_page() <= PAGES);
    }

    #[test]
    fn every_record_has_a_cell_of_its_own() {
        let cells: Vec<_> = records().map(|key| record_cell(key).expect("a cell")).collect();
        assert_eq!(cells, (0..RECORDS.cells).collect::<Vec<_>>());
        assert_eq!(record_cell(RecordKey::Coordinate(32)), None);
        assert_eq!(record_cell(RecordKey::Global(3, 0)), None);
    }

    #[test]
    fn no_two_slots_overlap_and_none_lies_across_pages() {
        let mut taken = [false; SIZE];
        for region in [ERASURE, RECORDS, PROGRAM] {
            for (cell, slot) in (0..region.cells).flat_map(|cell| [(cell, 0), (cell, 1)]) {
                let begin = region.address(cell, slot);
                let end = begin + region.slot;
                assert_eq!(begin / PAGE, (end - 1) / PAGE);
                assert!(region.bytes().contains(&begin) && region.bytes().contains(&(end - 1)));
                assert!(!taken[begin..end].contains(&true), "{begin}");
                taken[begin..end].fill(true);
            }
        }
    }
}
