//! An intact image of a module's EEPROM, changed as its module, power cuts and chance change it: opening does not panic, and what
//! opens reads the same by every way, can be switched on, runs a module and is written, and opens again. What stores and power
//! cuts leave always opens.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use virtual_bench::{Bench, BenchConfig, Eeprom, Instruction, ModuleId, ModuleKind, RecordKey, Storage};

/// An EEPROM that holds something, of each kind of module; and what is left of it when the power fails in the middle of a store,
/// of forgetting the settings, and of forgetting the program.
static INTACT: LazyLock<Vec<Eeprom>> =
    LazyLock::new(|| ModuleKind::ALL.into_iter().flat_map(intact).collect());

fn intact(kind: ModuleKind) -> [Eeprom; 4] {
    let mut eeprom = Eeprom::new(kind);
    for value in 0..3_i32 {
        eeprom.write(RecordKey::Axis(4), &value.to_le_bytes()).expect("room");
        eeprom.write(RecordKey::Global(0, 81), &value.to_le_bytes()).expect("room");
        eeprom.write_instruction(7, [value as u8; 7]).expect("room");
    }
    let [mut store, mut forget, mut forget_program] = [3, 12, 20].map(|writes| {
        let mut cut = eeprom.clone();
        cut.cut_after(writes);
        cut
    });
    // What is lost with the power is refused.
    let _ = store.write(RecordKey::Axis(4), &[9; 4]);
    let _ = forget.erase();
    let _ = forget_program.erase_program();
    assert!(store.is_cut() && forget.is_cut() && forget_program.is_cut());
    [eeprom, store, forget, forget_program]
}

fn read(eeprom: &mut Eeprom, key: RecordKey) -> Option<i32> {
    let mut bytes = [0; 4];
    (eeprom.read(key, &mut bytes) == Ok(4)).then(|| i32::from_le_bytes(bytes))
}

/// Something happens to it. What a place refuses, or is lost with the power, is left out.
fn happen(eeprom: &mut Eeprom, input: &mut Unstructured<'_>) -> Result<()> {
    let _ = match input.int_in_range(0..=7)? {
        0 => eeprom.write(RecordKey::Axis(input.arbitrary()?), &input.arbitrary::<[u8; 4]>()?),
        1 => eeprom.write(RecordKey::Coordinate(input.arbitrary()?), &input.arbitrary::<[u8; 4]>()?),
        2 => {
            let key = RecordKey::Global(2 * input.int_in_range(0..=1)?, input.arbitrary()?);
            eeprom.write(key, &input.arbitrary::<[u8; 4]>()?)
        }
        3 => eeprom.write_instruction(input.int_in_range(0..=2048)?, input.arbitrary()?),
        4 => eeprom.erase(),
        5 => eeprom.erase_program(),
        6 => {
            eeprom.power_on();
            Ok(())
        }
        _ => {
            // The power fails after so many byte writes more, or in the middle of one.
            match input.arbitrary::<(u8, Option<u8>)>()? {
                (writes, Some(torn)) => eeprom.cut_within(writes.into(), torn),
                (writes, None) => eeprom.cut_after(writes.into()),
            }
            Ok(())
        }
    };
    Ok(())
}

/// A byte becomes another.
fn change(image: &mut [u8], input: &mut Unstructured<'_>) -> Result<()> {
    let address = input.choose_index(image.len())?;
    image[address] = input.arbitrary()?;
    Ok(())
}

/// Whether it opens.
fn examine(image: &[u8]) -> bool {
    let Ok(mut eeprom) = Eeprom::from_image(image) else { return false };
    assert_eq!(eeprom.to_image(), image);
    let records: Vec<_> = eeprom.records().collect();
    for &(key, value) in &records {
        assert_eq!(read(&mut eeprom, key), Some(value));
    }
    let written = eeprom.program();
    let mut program: Vec<Instruction> = vec![[0; 7]; 2048];
    eeprom.read_program(&mut program).expect("it reads");
    assert_eq!(program[..written.len()], written[..]);
    eeprom.power_on();
    assert!(eeprom.records().eq(records), "a power-on loses nothing");
    assert_eq!(eeprom.program(), written);
    run(&eeprom);
    eeprom.write(RecordKey::Axis(4), &77_i32.to_le_bytes()).expect("room");
    let mut again = Eeprom::from_image(&eeprom.to_image()).expect("what is written leaves an intact image");
    assert_eq!(read(&mut again, RecordKey::Axis(4)), Some(77));
    assert_eq!(again.program(), written);
    true
}

/// A module takes what it finds, and starts its program where that is set.
fn run(eeprom: &Eeprom) {
    let config = BenchConfig::default_for(eeprom.kind());
    let mut bench = Bench::with_eeproms(&config, |_| Some(eeprom.clone()));
    bench.advance_by(200_000);
    assert_eq!(bench.eeprom(ModuleId(0)).map(Eeprom::kind), Some(eeprom.kind()));
}

/// Lives through what the input says.
fn live(input: &mut Unstructured<'_>) -> Result<()> {
    let mut eeprom = input.choose(&INTACT)?.clone();
    let changes = input.int_in_range(0..=3)?;
    let mut image = eeprom.to_image();
    if changes == 0 {
        while !input.is_empty() {
            happen(&mut eeprom, input)?;
        }
        image = eeprom.to_image();
    }
    for _ in 0..changes {
        change(&mut image, input)?;
    }
    let opens = examine(&image);
    assert!(opens || changes > 0, "stores and power cuts leave an intact image");
    Ok(())
}

fuzz_target!(|data: &[u8]| {
    examine(data);
    // An input that ends early has said enough.
    let _ = live(&mut Unstructured::new(data));
});
