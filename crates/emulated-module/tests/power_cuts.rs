//! An emulated chip whose plug is pulled while it stores, again and again: every parameter reads as the old or the new value.
#![allow(clippy::disallowed_methods, clippy::unwrap_used, reason = "tests that read and remove files")]

mod common;

use std::time::Duration;

use emulated_module::{Counting, EmulatedChip, Target};

/// How often the plug is pulled, unless POWER_CUTS says otherwise.
const CUTS: u32 = 12;

/// How long after a burst it is pulled, in steps of 400 µs.
const MOMENTS: u32 = 12;

/// User variables that are stored over and over.
const VARIABLES: usize = 8;

fn datagram(command: u8, kind: u8, motor: u8, value: i32) -> [u8; 9] {
    let [a, b, c, d] = value.to_be_bytes();
    let bytes = [1, command, kind, motor, a, b, c, d];
    let sum = bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    let [a, b, c, d, e, f, g, h] = bytes;
    [a, b, c, d, e, f, g, h, sum]
}

const SGP: u8 = 9;
const GGP: u8 = 10;
const STGP: u8 = 11;
const USER_VARIABLES: u8 = 2;

/// Status and value of the reply.
fn ask(chip: &mut EmulatedChip, datagram: [u8; 9]) -> (u8, i32) {
    let mut left = Vec::new();
    chip.send(0, &datagram).unwrap();
    chip.answers(&mut left).unwrap();
    let reply: Vec<u8> = left.into_iter().flat_map(|(_, _, bytes)| bytes).collect();
    let &[_, _, status, _, a, b, c, d, _] = reply.as_slice() else { panic!("{reply:?} is no reply") };
    (status, i32::from_be_bytes([a, b, c, d]))
}

#[test]
fn what_was_stored_is_there_and_what_was_being_stored_is_old_or_new() {
    let cuts = std::env::var("POWER_CUTS").map_or(CUTS, |cuts| cuts.parse().unwrap());
    for module in ["tmcm-1311", "tmcm-1640"] {
        cut_power(module, cuts);
    }
}

fn cut_power(module: &str, cuts: u32) {
    let image = common::image(module);
    let memory = common::memory(&format!("power-cuts-{module}"));
    let mut stored = [0; VARIABLES];
    let mut next = 1;
    let mut torn = 0;
    for cut in 0..cuts {
        let mut chip = EmulatedChip::start(&image, &memory, Counting::Clock).unwrap();
        assert_eq!(chip.tick(), 0);
        for (number, value) in (0..).zip(&mut stored) {
            let (status, found) = ask(&mut chip, datagram(GGP, number, USER_VARIABLES, 0));
            // What was being written last time may have become the new value.
            let may_be_new = number == torn && found == next - 1;
            assert_eq!(status, 100);
            assert!(found == *value || may_be_new, "cut {cut}: variable {number} is {found}, not {value}");
            *value = found;
        }
        // Some that are acknowledged, then a burst that the plug is pulled in.
        for round in 0..10 + cut % MOMENTS {
            let number = (round % VARIABLES as u32) as u8;
            assert_eq!(ask(&mut chip, datagram(SGP, number, USER_VARIABLES, next)).0, 100);
            assert_eq!(ask(&mut chip, datagram(STGP, number, USER_VARIABLES, 0)).0, 100);
            stored[usize::from(number)] = next;
            next += 1;
        }
        torn = (cut % VARIABLES as u32) as u8;
        assert_eq!(ask(&mut chip, datagram(SGP, torn, USER_VARIABLES, next)).0, 100);
        next += 1;
        chip.send(0, &datagram(STGP, torn, USER_VARIABLES, 0)).unwrap();
        // Anywhere within the write, before or after it: what is asserted holds wherever it falls.
        std::thread::sleep(Duration::from_micros(u64::from(cut % MOMENTS) * 400));
    }
}
