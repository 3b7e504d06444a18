//! The same sessions against virtual modules and emulated chips: the same replies at the same ticks, byte for byte.
//!
//! `cargo xtask firmware` builds the images first. With `UPDATE_SESSIONS=1` the virtual module's replies are written into the
//! sessions' files.
#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests that read and write files")]

use std::fs;
use std::path::{Path, PathBuf};

use emulated_module::{Counting, EmulatedChip, Session, VirtualTarget, play};
use virtual_bench::ModuleKind;

/// Of the 3600 cycles of a control period at 72 MHz, with 1.5 cycles an instruction.
const BUDGET: u64 = 2400;

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn image(module: &str) -> PathBuf {
    let image =
        folder().join("../../firmware/target/thumbv7m-none-eabi/release").join(format!("{module}-bench"));
    assert!(image.exists(), "{} is missing: `cargo xtask firmware` builds it", image.display());
    image
}

/// A file of its own in a place for such.
fn memory(name: &str) -> PathBuf {
    let memory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.psram"));
    let _ = fs::remove_file(&memory);
    memory
}

fn kind(module: &str) -> ModuleKind {
    match module {
        "tmcm-1311" => ModuleKind::Tmcm1311,
        _ => ModuleKind::Tmcm1640,
    }
}

/// Every session of a module: its name and its text.
fn sessions(module: &str) -> Vec<(String, PathBuf, Session)> {
    let mut sessions: Vec<_> = fs::read_dir(folder().join("sessions").join(module))
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let session = Session::parse(&fs::read_to_string(&path).unwrap())
                .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            (name, path, session)
        })
        .collect();
    sessions.sort_by(|one, other| one.0.cmp(&other.0));
    assert!(!sessions.is_empty());
    sessions
}

fn virtual_module_answers_as_recorded(module: &str) {
    for (name, path, recorded) in sessions(module) {
        let Ok(played) = play(&recorded, &mut VirtualTarget::new(kind(module)));
        if std::env::var_os("UPDATE_SESSIONS").is_some() {
            fs::write(&path, played.to_string()).unwrap();
        } else {
            assert_eq!(played.to_string(), recorded.to_string(), "{name}");
        }
    }
}

fn emulated_chip_answers_as_recorded(module: &str) {
    for (name, _, recorded) in sessions(module) {
        let memory = memory(&format!("{module}-{name}"));
        let mut chip = EmulatedChip::start(&image(module), &memory, Counting::Instructions).unwrap();
        let played = play(&recorded, &mut chip).unwrap();
        let measured = chip.measure().unwrap();
        println!("{module} {name}: {measured:?}, {:?}", chip.stack().unwrap());
        assert_eq!(played.to_string(), recorded.to_string(), "{name}");
        assert!(measured.longest <= BUDGET, "{name}: {measured:?}");
    }
}

#[test]
fn a_virtual_tmcm_1311_answers_as_recorded() {
    virtual_module_answers_as_recorded("tmcm-1311");
}

#[test]
fn a_virtual_tmcm_1640_answers_as_recorded() {
    virtual_module_answers_as_recorded("tmcm-1640");
}

#[test]
fn an_emulated_tmcm_1311_answers_as_recorded() {
    emulated_chip_answers_as_recorded("tmcm-1311");
}

#[test]
fn an_emulated_tmcm_1640_answers_as_recorded() {
    emulated_chip_answers_as_recorded("tmcm-1640");
}
