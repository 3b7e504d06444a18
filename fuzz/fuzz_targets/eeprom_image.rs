//! Any bytes as the image of an EEPROM, and any bytes over an intact one: opening does not panic, and what opens reads the same
//! by every way, can be switched on and written, and opens again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use virtual_bench::{Eeprom, Instruction, ModuleKind, RecordKey, Storage};

/// An intact image that holds something.
fn intact(kind: ModuleKind) -> Vec<u8> {
    let mut eeprom = Eeprom::new(kind);
    for value in 0..3_i32 {
        eeprom.write(RecordKey::Axis(4), &value.to_le_bytes()).expect("room");
        eeprom.write(RecordKey::Global(0, 81), &value.to_le_bytes()).expect("room");
        eeprom.write_instruction(7, [value as u8; 7]).expect("room");
    }
    eeprom.to_image()
}

fn read(eeprom: &mut Eeprom, key: RecordKey) -> Option<i32> {
    let mut bytes = [0; 4];
    (eeprom.read(key, &mut bytes) == Ok(4)).then(|| i32::from_le_bytes(bytes))
}

fn examine(image: &[u8]) {
    let Ok(mut eeprom) = Eeprom::from_image(image) else { return };
    assert_eq!(eeprom.to_image(), image);
    let records: Vec<_> = eeprom.records().collect();
    for (key, value) in records {
        assert_eq!(read(&mut eeprom, key), Some(value));
    }
    let written = eeprom.program();
    let mut program: Vec<Instruction> = vec![[0; 7]; 2048];
    eeprom.read_program(&mut program).expect("it reads");
    assert_eq!(program[..written.len()], written[..]);
    eeprom.power_on();
    eeprom.write(RecordKey::Axis(4), &77_i32.to_le_bytes()).expect("room");
    let mut again = Eeprom::from_image(&eeprom.to_image()).expect("what is written leaves an intact image");
    assert_eq!(read(&mut again, RecordKey::Axis(4)), Some(77));
    assert_eq!(again.program(), written);
}

fuzz_target!(|data: &[u8]| {
    examine(data);
    let Some((&kind, changes)) = data.split_first() else { return };
    let mut image = intact(ModuleKind::ALL[usize::from(kind) % ModuleKind::ALL.len()]);
    for change in changes.chunks_exact(3) {
        let address = usize::from(u16::from_be_bytes([change[0], change[1]]));
        image[address] = change[2];
    }
    examine(&image);
});
