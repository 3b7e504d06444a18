use std::collections::BTreeMap;

use module_firmware::{ERASED, Storage};
use proptest::prelude::*;

use super::layout::{self, RECORDS};
use super::*;

const NEW: ModuleKind = ModuleKind::Tmcm1311;

/// What the firmware does with it.
#[derive(Clone, Copy, Debug)]
enum Operation {
    Write(RecordKey, i32),
    WriteInstruction(u16, u8),
    Erase,
    EraseProgram,
}

use Operation::{Erase, EraseProgram, Write, WriteInstruction};

impl Operation {
    /// False when the power failed meanwhile.
    fn apply(self, eeprom: &mut Eeprom) -> bool {
        let result = match self {
            Write(key, value) => eeprom.write(key, &value.to_le_bytes()),
            WriteInstruction(address, byte) => eeprom.write_instruction(address, [byte; 7]),
            Erase => eeprom.erase(),
            EraseProgram => eeprom.erase_program(),
        };
        result.is_ok()
    }
}

/// What it shall hold.
#[derive(Clone, Debug, Default, PartialEq)]
struct Contents {
    records: BTreeMap<u16, i32>,
    program: BTreeMap<u16, u8>,
}

impl Contents {
    fn after(&self, operation: Operation) -> Self {
        let mut after = self.clone();
        match operation {
            Write(key, value) => {
                after.records.insert(key.to_u16(), value);
            }
            WriteInstruction(address, byte) => {
                after.program.insert(address, byte);
            }
            Erase => after.records.clear(),
            EraseProgram => after.program.clear(),
        }
        after
    }

    /// What it holds, by everything that can be asked.
    #[track_caller]
    fn of(eeprom: &mut Eeprom) -> Self {
        let records: BTreeMap<_, _> = eeprom.records().map(|(key, value)| (key.to_u16(), value)).collect();
        for key in layout::records() {
            let mut bytes = [0; 4];
            let length = eeprom.read(key, &mut bytes).expect("it reads");
            let read = (length == 4).then(|| i32::from_le_bytes(bytes));
            assert_eq!(read, records.get(&key.to_u16()).copied(), "{key:?}");
        }
        let program = eeprom.program();
        let mut read = vec![[0; 7]; 2048];
        eeprom.read_program(&mut read).expect("it reads");
        assert_eq!(read[..program.len()], program[..]);
        assert!(read[program.len()..].iter().all(|instruction| *instruction == ERASED));
        let written = (0..).zip(read).filter(|(_, instruction)| *instruction != ERASED);
        let program = written.map(|(address, instruction)| {
            assert_eq!(instruction, [instruction[0]; 7], "{address}");
            (address, instruction[0])
        });
        Self { records, program: program.collect() }
    }
}

/// Does one operation after the other until the power fails, and looks what there is when it is back.
#[track_caller]
fn assert_old_or_new(mut eeprom: Eeprom, operations: &[Operation]) -> bool {
    let mut old = Contents::of(&mut eeprom);
    for operation in operations {
        let new = old.after(*operation);
        if !operation.apply(&mut eeprom) {
            eeprom.power_on();
            let found = Contents::of(&mut eeprom);
            assert!(found == old || found == new, "{operation:?} left {found:?}, and not {old:?}");
            // It goes on as if nothing had been.
            assert!(operation.apply(&mut eeprom));
            assert_eq!(Contents::of(&mut eeprom), new);
            return true;
        }
        old = new;
    }
    assert_eq!(Contents::of(&mut eeprom), old);
    false
}

/// Each kind of write: to a cell that is new, that holds one value, and that holds two.
const SCENARIO: [Operation; 16] = [
    Write(RecordKey::Axis(4), 1000),
    Write(RecordKey::Axis(4), -1),
    Write(RecordKey::Axis(4), 2000),
    Write(RecordKey::Coordinate(20), i32::MIN),
    Write(RecordKey::Global(0, 81), 3),
    WriteInstruction(0, 5),
    WriteInstruction(1, 6),
    WriteInstruction(2047, 7),
    WriteInstruction(0, 8),
    EraseProgram,
    WriteInstruction(0, 9),
    WriteInstruction(0, 0xFF),
    Write(RecordKey::Global(2, 255), i32::MAX),
    Erase,
    Write(RecordKey::Axis(4), 3000),
    Write(RecordKey::Axis(5), 0),
];

#[test]
fn a_cut_between_any_two_byte_writes_leaves_the_old_or_the_new() {
    for writes in 0.. {
        let mut eeprom = Eeprom::new(NEW);
        eeprom.cut_after(writes);
        if !assert_old_or_new(eeprom, &SCENARIO) {
            assert!(writes > 100, "{writes}");
            return;
        }
    }
}

/// Whatever the byte is that was under way.
#[test]
fn a_cut_in_the_middle_of_a_byte_write_does_too() {
    for writes in 0.. {
        for torn in [0x00, 0x01, 0x0F, 0x33, 0x55, 0x66, 0x80, 0xA5, 0xFE] {
            let mut eeprom = Eeprom::new(NEW);
            eeprom.cut_within(writes, torn);
            if !assert_old_or_new(eeprom, &SCENARIO) {
                return;
            }
        }
    }
}

/// Erasing that is cut again and again is finished in the end, and what it covers reads as erased all along.
#[test]
fn erasing_goes_on_at_power_on() {
    let mut full = Eeprom::new(NEW);
    for address in 0..40 {
        full.write_instruction(address, [7; 7]).expect("room");
    }
    for writes in 0.. {
        let mut eeprom = full.clone();
        eeprom.cut_after(writes);
        if eeprom.erase_program().is_ok() {
            break;
        }
        let begun = eeprom.program().is_empty();
        for _ in 0..3 {
            eeprom.cut_after(20);
            eeprom.power_on();
            assert_eq!(eeprom.program().is_empty(), begun, "{writes}");
            Eeprom::from_image(&eeprom.to_image()).expect("an image of something under way is in order");
        }
        assert_eq!(begun, writes >= 8, "the eighth byte write decides");
    }
}

/// A keeper of its image who is stopped at any byte has what a power cut leaves.
#[test]
fn patches_lead_from_image_to_image_by_way_of_good_ones() {
    let mut eeprom = Eeprom::new(NEW);
    eeprom.note_patches();
    let mut image = eeprom.to_image();
    let mut old = Contents::default();
    for operation in SCENARIO {
        assert!(operation.apply(&mut eeprom) && eeprom.has_patches());
        let new = old.after(operation);
        for Patch { offset, bytes } in eeprom.take_patches() {
            for (address, byte) in (offset..).zip(bytes) {
                image[address] = byte;
                let mut kept = Eeprom::from_image(&image).expect("a good image");
                let found = Contents::of(&mut kept);
                assert!(found == old || found == new, "{operation:?} left {found:?} by way of {address}");
            }
        }
        assert_eq!(image, eeprom.to_image());
        assert!(!eeprom.has_patches() && eeprom.take_patches().is_empty());
        old = new;
    }
}

/// Where the bits lie that hold something.
fn used(image: &[u8]) -> impl Iterator<Item = usize> + '_ {
    (0..SIZE).filter(|address| image[*address] != 0xFF)
}

#[test]
fn a_flipped_bit_is_noticed_or_does_not_matter() {
    let mut eeprom = Eeprom::new(NEW);
    for operation in SCENARIO {
        operation.apply(&mut eeprom);
    }
    let image = eeprom.to_image();
    let contents = Contents::of(&mut eeprom);
    let mut noticed = 0;
    for (address, bit) in used(&image).flat_map(|address| (0..8).map(move |bit| (address, bit))) {
        let mut damaged = image.clone();
        damaged[address] ^= 1 << bit;
        match Eeprom::from_image(&damaged) {
            Ok(mut eeprom) => assert_eq!(Contents::of(&mut eeprom), contents, "{address}"),
            Err(_) => noticed += 1,
        }
    }
    assert!(noticed > 300, "{noticed}");
}

/// 4 KiB that read 0, as after a crash of the machine, wherever they lie.
#[test]
fn a_zeroed_block_is_noticed() {
    let mut eeprom = Eeprom::new(NEW);
    let image = eeprom.to_image();
    eeprom.write(RecordKey::Axis(4), &[1, 2, 3, 4]).expect("room");
    for block in (0..layout::PROGRAM.bytes().end).step_by(4096) {
        let mut damaged = image.clone();
        damaged[block..block + 4096].fill(0);
        assert!(Eeprom::from_image(&damaged).is_err(), "{block}");
    }
}

#[test]
fn what_is_wrong_is_said_and_where() {
    let mut eeprom = Eeprom::new(NEW);
    eeprom.write(RecordKey::Global(0, 66), &[7, 0, 0, 0]).expect("room");
    eeprom.write_instruction(3, [1; 7]).expect("room");
    let image = eeprom.to_image();
    let says = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut image = image.clone();
        change(&mut image);
        Eeprom::from_image(&image).expect_err("an error").to_string()
    };
    assert_eq!(says(&|image| image.truncate(1000)), "its length in bytes is 1000 instead of 67584");
    assert_eq!(says(&|image| image.clear()), "its length in bytes is 0 instead of 67584");
    assert_eq!(says(&|image| image[0] = b'o'), "at byte 0: it does not begin with \"OpenTMCL\"");
    assert_eq!(says(&|image| image[8] = 2), "at byte 11: the checksum of the header is wrong");
    let address = layout::record_cell(RecordKey::Global(0, 66)).map(|cell| RECORDS.address(cell, 0));
    let address = address.expect("a cell");
    assert_eq!(
        says(&|image| image[address + 1] = 8),
        "at byte 2900, global parameter 66 in bank 0: the checksum is wrong"
    );
    assert_eq!(
        says(&|image| image[12_000..12_040].fill(0)),
        "at byte 11994, instruction 9: it is erased in part; \
         at byte 12004, instruction 10: 0x00 is no mark that a write leaves; \
         at byte 12014, instruction 11: 0x00 is no mark that a write leaves; and 1 more"
    );
    let sealed = |image: &mut Vec<u8>| {
        let checksum = layout::CRC.checksum(&image[..11]).to_be_bytes();
        image[11..13].copy_from_slice(&checksum);
    };
    let future = says(&|image| {
        image[8] = 2;
        sealed(image);
    });
    assert_eq!(future, "it has format 2, and format 1 is known here");
    let foreign = says(&|image| {
        image[9..11].copy_from_slice(&1161_u16.to_be_bytes());
        sealed(image);
    });
    assert_eq!(foreign, "it is for a module with the number 1161, of which there is no virtual one here");
}

#[test]
fn what_is_written_again_wears_nothing() {
    let mut eeprom = Eeprom::new(NEW);
    assert_eq!((eeprom.writes(), eeprom.most_worn()), (0, (0, 0)));
    eeprom.write(RecordKey::Axis(4), &[1, 2, 3, 4]).expect("room");
    assert_eq!((eeprom.writes(), eeprom.most_worn()), (8, (3, 8)));
    eeprom.write(RecordKey::Axis(4), &[1, 2, 3, 4]).expect("room");
    eeprom.erase_program().expect("nothing to erase");
    assert_eq!(eeprom.writes(), 8);
    // The second slot lies in another page.
    eeprom.write(RecordKey::Axis(4), &[0; 4]).expect("room");
    assert_eq!((eeprom.writes(), eeprom.most_worn()), (16, (3, 8)));
}

#[test]
fn there_is_no_room_for_what_no_module_stores() {
    let mut eeprom = Eeprom::new(NEW);
    assert_eq!(eeprom.write(RecordKey::Axis(4), &[0; 5]), Err(module_firmware::StorageError::Full));
    assert_eq!(eeprom.write(RecordKey::Global(3, 0), &[0; 4]), Err(module_firmware::StorageError::Full));
    assert_eq!(eeprom.write_instruction(2048, ERASED), Err(module_firmware::StorageError::Full));
    assert_eq!(eeprom.writes(), 0);
}

fn operation() -> impl Strategy<Value = Operation> {
    let key = prop_oneof![
        (0..6_u8).prop_map(RecordKey::Axis),
        (1..4_u8).prop_map(RecordKey::Coordinate),
        (64..68_u8).prop_map(|number| RecordKey::Global(0, number)),
        (0..3_u8).prop_map(|number| RecordKey::Global(2, number)),
    ];
    prop_oneof![
        8 => (key, prop_oneof![-2..3_i32, any::<i32>()]).prop_map(|(key, value)| Write(key, value)),
        4 => (0..6_u16, 1..4_u8).prop_map(|(address, byte)| WriteInstruction(address, byte)),
        1 => Just(Erase),
        1 => Just(EraseProgram),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Operations, each of which may be cut, at power-on too; the wear never falls, and the image is good all along.
    #[test]
    fn nothing_is_lost_and_nothing_else_is_disturbed(
        steps in prop::collection::vec((operation(), prop::option::of((0..30_u64, 0..30_u64))), 1..60)
    ) {
        let mut eeprom = Eeprom::new(NEW);
        let mut holds = Contents::default();
        let mut writes = 0;
        for (operation, cut) in steps {
            let new = holds.after(operation);
            if let Some((during, _)) = cut {
                eeprom.cut_after(during);
            }
            let done = operation.apply(&mut eeprom);
            if let (false, Some((_, at_power_on))) = (done, cut) {
                eeprom.power_on();
                eeprom.cut_after(at_power_on);
                eeprom.finish_erasing();
            }
            eeprom.cut_after(u64::MAX);
            eeprom.power_on();
            let mut kept = Eeprom::from_image(&eeprom.to_image()).expect("a good image");
            let found = Contents::of(&mut kept);
            prop_assert!(found == new || (!done && found == holds), "{operation:?}: {found:?}");
            prop_assert!(eeprom.writes() >= writes);
            (holds, writes) = (found, eeprom.writes());
        }
    }
}
