//! Sessions against emulated chips: byte for byte what virtual modules answered, at the same ticks; what a control period
//! takes.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use emulated_module::{Counting, EmulatedChip, play};

/// Instructions of a control period at most, of the 3600 cycles at 72 MHz with 1.5 cycles an instruction.
const BUDGET: u64 = 2400;

/// Bytes of stack at most, of the images with physics. `cargo xtask firmware` says how deep it could get.
const STACK: u32 = 14 * 1024;

fn answers_as_recorded(module: &str) {
    for (name, _, recorded) in common::sessions(module) {
        let memory = common::memory(&format!("{module}-{name}"));
        let mut chip = EmulatedChip::start(&common::image(module), &memory, Counting::Instructions).unwrap();
        let played = play(&recorded, &mut chip).unwrap();
        let (measured, stack) = (chip.measure().unwrap(), chip.stack().unwrap());
        println!("{module}, {name}: {measured:?}, {stack:?}");
        assert_eq!(played.to_string(), recorded.to_string(), "{name}");
        assert!(measured.longest <= BUDGET, "{name}: {measured:?}");
        assert!(stack.used <= STACK, "{name}: {stack:?}");
    }
}

#[test]
fn an_emulated_tmcm_1311_answers_as_recorded() {
    answers_as_recorded("tmcm-1311");
}

#[test]
fn an_emulated_tmcm_1640_answers_as_recorded() {
    answers_as_recorded("tmcm-1640");
}
