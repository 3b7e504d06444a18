//! Sessions against emulated chips: byte for byte what virtual modules answered, at the same ticks; what a control period
//! takes.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use emulated_module::{Counting, EmulatedChip, play};

/// Instructions of a control period at most. The aim is 2400, of the 3600 cycles at 72 MHz with 1.5 cycles an instruction; one
/// session is above it, closed loop where the I²t window and the brake fall into one period (2955).
const BUDGET: u64 = 3000;

/// Bytes of RAM at most: what is static, and the stack at its deepest; the images with physics need more.
const STACK: u32 = 24 * 1024;

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
