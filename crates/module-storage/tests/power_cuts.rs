//! Power that fails at every single write: every record and instruction is then what it was or what it was to become.
#![allow(
    clippy::disallowed_types,
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "tests: the board outlives its media, which share it"
)]

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use embedded_storage::{ReadStorage, Storage as ByteStorage};
use module_firmware::{ERASED, Instruction, RecordKey, Storage};
use module_storage::ModuleStorage;
use proptest::prelude::*;

const PAGE: usize = 512;
const PAGES: usize = 4;
const INSTRUCTIONS: u16 = 6;

/// What both media hold, and how many writes are left until the power fails.
struct Board {
    flash: Vec<u8>,
    eeprom: Vec<u8>,
    writes_left: u64,
    writes: u64,
}

impl Board {
    fn new(blank: u8) -> Self {
        let eeprom = ModuleStorage::<Flash, Eeprom>::eeprom_bytes(INSTRUCTIONS) as usize;
        Self {
            flash: vec![blank; PAGE * PAGES],
            eeprom: vec![blank; eeprom],
            writes_left: u64::MAX,
            writes: 0,
        }
    }

    /// Whether there is power for one more write.
    fn write(&mut self) -> Result<(), PowerFailed> {
        self.writes += 1;
        self.writes_left = self.writes_left.checked_sub(1).ok_or(PowerFailed)?;
        Ok(())
    }
}

type Shared = Arc<Mutex<Board>>;

#[derive(Clone)]
struct Flash(Shared);
#[derive(Clone)]
struct Eeprom(Shared);

#[derive(Debug)]
struct PowerFailed;

impl NorFlashError for PowerFailed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for Flash {
    type Error = PowerFailed;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerFailed> {
        let offset = offset as usize;
        bytes.copy_from_slice(&self.0.lock().unwrap().flash[offset..offset + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        PAGE * PAGES
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerFailed> {
        for page in (from..to).step_by(PAGE) {
            let mut board = self.0.lock().unwrap();
            board.write()?;
            let page = page as usize;
            board.flash[page..page + PAGE].fill(0xFF);
        }
        Ok(())
    }

    /// A word at a time, and bits only ever fall.
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerFailed> {
        for (start, word) in (offset as usize..).step_by(4).zip(bytes.chunks(4)) {
            let mut board = self.0.lock().unwrap();
            board.write()?;
            for (held, byte) in board.flash[start..].iter_mut().zip(word) {
                assert_eq!(*held & byte, *byte, "a bit that was 0 is written as 1");
                *held &= byte;
            }
        }
        Ok(())
    }
}

impl ReadStorage for Eeprom {
    type Error = PowerFailed;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerFailed> {
        let offset = offset as usize;
        bytes.copy_from_slice(&self.0.lock().unwrap().eeprom[offset..offset + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.lock().unwrap().eeprom.len()
    }
}

impl ByteStorage for Eeprom {
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerFailed> {
        for (place, byte) in (offset as usize..).zip(bytes) {
            let mut board = self.0.lock().unwrap();
            board.write()?;
            board.eeprom[place] = *byte;
        }
        Ok(())
    }
}

/// What a module writes.
#[derive(Clone, Debug)]
enum Write {
    Record(u8, u32),
    Instruction(u16, Instruction),
    EraseRecords,
    EraseProgram,
}

/// What the media must read as.
#[derive(Clone, Debug, Default, PartialEq)]
struct Contents {
    records: BTreeMap<u8, u32>,
    program: BTreeMap<u16, Instruction>,
}

impl Contents {
    fn apply(&mut self, write: &Write) {
        match write {
            Write::Record(number, value) => drop(self.records.insert(*number, *value)),
            Write::Instruction(address, instruction) => drop(self.program.insert(*address, *instruction)),
            Write::EraseRecords => self.records.clear(),
            Write::EraseProgram => self.program.clear(),
        }
    }
}

fn open(board: &Shared) -> Result<ModuleStorage<Flash, Eeprom>, module_firmware::StorageError> {
    let end = (PAGE * PAGES) as u32;
    ModuleStorage::open(Flash(board.clone()), 0..end, Eeprom(board.clone()), INSTRUCTIONS)
}

fn apply(storage: &mut impl Storage, write: &Write) -> Result<(), module_firmware::StorageError> {
    match write {
        Write::Record(number, value) => storage.write(RecordKey::Axis(*number), &value.to_le_bytes()),
        Write::Instruction(address, instruction) => storage.write_instruction(*address, *instruction),
        Write::EraseRecords => storage.erase(),
        Write::EraseProgram => storage.erase_program(),
    }
}

fn contents(storage: &mut impl Storage) -> Contents {
    let mut contents = Contents::default();
    for number in 0..8 {
        let mut value = [0; 4];
        match storage.read(RecordKey::Axis(number), &mut value).unwrap() {
            0 => {}
            length => {
                assert_eq!(length, 4);
                contents.records.insert(number, u32::from_le_bytes(value));
            }
        }
    }
    let mut program = [ERASED; INSTRUCTIONS as usize];
    storage.read_program(&mut program).unwrap();
    let written = (0..).zip(program).filter(|(_, instruction)| *instruction != ERASED);
    contents.program = written.collect();
    contents
}

fn writes() -> impl Strategy<Value = Vec<Write>> {
    let write = prop_oneof![
        12 => (0..8_u8, any::<u32>()).prop_map(|(number, value)| Write::Record(number, value)),
        6 => (0..INSTRUCTIONS, any::<Instruction>())
            .prop_filter("erased", |(_, instruction)| *instruction != ERASED)
            .prop_map(|(address, instruction)| Write::Instruction(address, instruction)),
        1 => Just(Write::EraseRecords),
        1 => Just(Write::EraseProgram),
    ];
    proptest::collection::vec(write, 1..150)
}

/// Writes until the power fails after so many of the media's writes; opens again with power, and looks.
fn cut(writes: &[Write], blank: u8, power: u64) -> Result<bool, TestCaseError> {
    let mut board = Board::new(blank);
    board.writes_left = power;
    let board = Arc::new(Mutex::new(board));
    let mut before = Contents::default();
    let mut after = Contents::default();
    let mut failed = true;
    if let Ok(mut storage) = open(&board) {
        failed = writes.iter().any(|write| {
            before = after.clone();
            after.apply(write);
            apply(&mut storage, write).is_err()
        });
    }
    if !failed {
        before = after.clone();
    }
    board.lock().unwrap().writes_left = u64::MAX;
    let mut storage = open(&board).unwrap();
    let found = contents(&mut storage);
    prop_assert!(
        found == before || found == after,
        "cut after {power} writes: found {found:?}, neither {before:?} nor {after:?}"
    );
    // It goes on working.
    let write = Write::Record(3, 0xAFFE);
    apply(&mut storage, &write).unwrap();
    let mut expected = found;
    expected.apply(&write);
    prop_assert_eq!(contents(&mut open(&board).unwrap()), expected);
    Ok(failed)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_write_is_whole_or_not_at_all(
        writes in writes(),
        blank in prop_oneof![Just(0_u8), Just(0xFF)],
        power in 0..3000_u64,
    ) {
        cut(&writes, blank, power)?;
    }
}

/// One story that fills pages, erases and rewrites, cut at each of its writes.
#[test]
fn cut_at_every_single_write() {
    let mut story = Vec::new();
    for round in 0..18_u32 {
        for number in 0..8_u8 {
            story.push(Write::Record(number, round * 256 + u32::from(number)));
        }
        story.push(Write::Instruction((round % 6) as u16, [round as u8; 7]));
        if round == 9 {
            story.push(Write::EraseProgram);
            story.push(Write::EraseRecords);
        }
    }
    let mut power = 0;
    while cut(&story, 0xFF, power).unwrap() {
        power += 1;
    }
    assert!(power > 500, "only {power} writes");
}

#[test]
fn media_that_are_too_small_are_refused() {
    let board = Arc::new(Mutex::new(Board::new(0xFF)));
    let page = PAGE as u32;
    let one_page = ModuleStorage::open(Flash(board.clone()), 0..page, Eeprom(board.clone()), INSTRUCTIONS);
    assert_eq!(one_page.err(), Some(module_firmware::StorageError::Full));
    let too_long = ModuleStorage::open(Flash(board.clone()), 0..2 * page, Eeprom(board), INSTRUCTIONS + 1);
    assert_eq!(too_long.err(), Some(module_firmware::StorageError::Full));
}

/// As many records as the modules have, in pages as large as theirs.
#[test]
fn a_full_medium_says_so_and_keeps_what_it_holds() {
    let board = Arc::new(Mutex::new(Board::new(0xFF)));
    let mut storage = open(&board).unwrap();
    let mut kept = BTreeMap::new();
    let full = (0..=255_u8).find(|number| {
        let written = storage.write(RecordKey::Global(2, *number), &[*number; 4]);
        match written {
            Ok(()) => drop(kept.insert(*number, [*number; 4])),
            Err(error) => assert_eq!(error, module_firmware::StorageError::Full),
        }
        written.is_err()
    });
    assert!(full.is_some(), "2 KiB take 256 records?");
    for (number, value) in kept {
        let mut found = [0; 4];
        assert_eq!(storage.read(RecordKey::Global(2, number), &mut found), Ok(4));
        assert_eq!(found, value);
    }
}
