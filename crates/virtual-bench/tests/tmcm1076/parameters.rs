//! What the TMCM-1076 answers: its parameters' defaults, ranges, access and storage, its inputs, commands and identity
//! (§3.5, §4; decisions 1.5, 2, 7).

use crate::common::step::{CHOP, ENABLE, STANDSTILL, StepDriver};
use tmcl_tables::tmcm_1076::{AxisParameter as Ap, SPEC};
use tmcl_tables::{Command, Status};
use tmcl_wire::{Request, serial};

use Status::{InvalidValue, Ok, WrongType};

/// Axis parameters as chapter 4 prints them: number, default, least, most, access. AP 135 is a measurement (decisions 7.5), and
/// AP 180 reads what flows: the standby current.
const AXIS: [(u8, i64, i64, i64, &str); 22] = [
    (6, 24, 0, 31, "RWE"),
    (7, 3, 0, 31, "RWE"),
    (9, 0, 0, 15, "RWE"),
    (22, 0, 0, 1_048_575, "RWE"),
    (135, STANDSTILL as i64, 0, 1_048_575, "RWE"),
    (136, 0, 0, 1_048_575, "RWE"),
    (137, 328_136, 0, 4_294_967_295, "RWE"),
    (138, 33_011, 0, 4_294_967_295, "RWE"),
    (139, 33_011, 0, 4_294_967_295, "RWE"),
    (140, 4, 0, 8, "RWE"),
    (141, 1, 0, 1, "RWE"),
    (142, 0, 0, 1, "RWE"),
    (168, 0, 0, 1, "RWE"),
    (169, 0, 0, 3, "RW"),
    (170, 0, 0, 15, "RW"),
    (171, 0, 0, 3, "RW"),
    (172, 0, 0, 15, "RW"),
    (173, 0, 0, 1, "RW"),
    (174, 0, -64, 63, "RW"),
    (180, 3, 0, 31, "R"),
    (182, 0, 0, 1_048_575, "RWE"),
    (206, 0, 0, 1023, "R"),
];

fn get(module: &mut StepDriver, number: u8) -> (Status, i32) {
    let reply = module.send(Command::GetAxisParameter, number, 0, 0);
    (reply.status, reply.value)
}

fn set(module: &mut StepDriver, number: u8, value: i64) -> Status {
    module.status(Command::SetAxisParameter, number, 0, value as i32)
}

#[test]
fn every_number_has_the_default_and_the_access_of_chapter_4() {
    let mut module = StepDriver::new();
    module.run_ms(1);
    for number in 0..=255 {
        let Some((_, default, _, _, access)) = AXIS.into_iter().find(|entry| entry.0 == number) else {
            assert_eq!(get(&mut module, number), (WrongType, 0), "AP {number}");
            for command in
                [Command::SetAxisParameter, Command::StoreAxisParameter, Command::RestoreAxisParameter]
            {
                assert_eq!(module.status(command, number, 0, 0), WrongType, "{command:?} {number}");
            }
            continue;
        };
        assert_eq!(get(&mut module, number), (Ok, default as i32), "AP {number}");
        let stored = if access.contains('E') { Ok } else { WrongType };
        let mut fresh = StepDriver::new();
        let written = if access.contains('W') { Ok } else { WrongType };
        assert_eq!(set(&mut fresh, number, default), written, "SAP {number}");
        assert_eq!(fresh.status(Command::StoreAxisParameter, number, 0, 0), stored, "STAP {number}");
        assert_eq!(fresh.status(Command::RestoreAxisParameter, number, 0, 0), stored, "RSAP {number}");
        assert_eq!(module.status(Command::GetAxisParameter, number, 1, 0), InvalidValue, "motor 1");
    }
    assert_eq!(SPEC.axis_parameters.len(), AXIS.len());
}

#[test]
fn every_range_ends_where_chapter_4_says() {
    for (number, _, least, most, access) in AXIS {
        let mut module = StepDriver::new();
        if !access.contains('W') {
            continue;
        }
        for value in [least, most] {
            assert_eq!(set(&mut module, number, value), Ok, "AP {number} = {value}");
            let expected = match number {
                // A measurement, and CHOPCONF without its microstep resolution.
                135 => STANDSTILL,
                139 => (value & 0xF0FF_FFFF) as i32,
                _ => value as i32,
            };
            assert_eq!(get(&mut module, number), (Ok, expected), "AP {number} = {value}");
        }
        // Registers of 32 bits have no outside.
        if most < i64::from(i32::MAX) {
            for value in [least - 1, most + 1, i64::from(i32::MIN), i64::from(i32::MAX)] {
                assert_eq!(set(&mut module, number, value), InvalidValue, "AP {number} = {value}");
            }
            if number != 135 {
                assert_eq!(get(&mut module, number), (Ok, most as i32), "unchanged");
            }
        }
    }
}

#[test]
fn what_is_stored_survives_a_power_cycle_and_nothing_else() {
    let mut module = StepDriver::new();
    let value = |number: u8, most: i64| match number {
        137 => 0xC40C_001E_u32.cast_signed(),
        138 => 0x0105_8243, // with SEIMIN, as AP 168 below
        139 => 0x3001_80C3, // with intpol and dedge
        _ => (most - i64::from(number == 140)) as i32,
    };
    let written = |access: &str| access.contains('W');
    for (number, _, _, most, access) in AXIS.into_iter().filter(|entry| written(entry.4)) {
        assert_eq!(set(&mut module, number, value(number, most).into()), Ok);
        let stored = access.contains('E');
        let status = module.status(Command::StoreAxisParameter, number, 0, 0);
        assert_eq!(status, if stored { Ok } else { WrongType });
    }
    module.power_cycle();
    module.run_ms(1);
    for (number, _, _, most, access) in AXIS.into_iter().filter(|entry| entry.4.contains('E')) {
        let expected = if number == 135 { STANDSTILL } else { value(number, most) };
        assert_eq!(get(&mut module, number), (Ok, expected), "AP {number} {access}");
    }
    // Fields of the stored register 138.
    for (number, expected) in [(169, 0), (170, 2), (171, 2), (172, 3), (173, 1), (174, 5)] {
        assert_eq!(get(&mut module, number), (Ok, expected), "AP {number}");
    }
    module.unanswered(Command::FactoryReset, 0, 0, 1234);
    module.run_ms(1);
    for (number, default, ..) in AXIS {
        assert_eq!(get(&mut module, number).1, default as i32, "AP {number} after 137");
    }
}

#[test]
fn the_contradicting_defaults_are_read_until_one_is_written() {
    let mut module = StepDriver::new();
    assert_eq!([module.gap(Ap::Coolconf), module.gap(Ap::CoolstepHysteresisStart)], [33_011, 0]);
    module.sap(Ap::Stallguard2Threshold, -1);
    assert_eq!(module.gap(Ap::Coolconf), 0x7F << 16);
    module.sap(Ap::Coolconf, 33_011);
    let fields = [Ap::CoolstepMinCurrent, Ap::CoolstepUpStep, Ap::CoolstepHysteresisStart];
    assert_eq!(fields.map(|field| module.gap(field)), [1, 3, 3]);
    assert_eq!(module.gap(Ap::Stallguard2Threshold), 0);
    assert_eq!([module.gap(Ap::Chopconf), module.gap(Ap::MicrostepInterpolation)], [33_011, 1]);
    module.sap(Ap::DoubleEdgeSteps, 1);
    assert_eq!(module.gap(Ap::Chopconf), 33_011 | 3 << 28);
    module.sap(Ap::Chopconf, 33_011);
    let fields = [Ap::MicrostepInterpolation, Ap::DoubleEdgeSteps, Ap::MicrostepResolution];
    assert_eq!(fields.map(|field| module.gap(field)), [0, 0, 4]);
}

/// What the IDE's button does for a tab that nobody changed.
#[test]
fn storing_a_fresh_register_leaves_it_fresh() {
    let mut module = StepDriver::new();
    for parameter in [Ap::Coolconf, Ap::Chopconf, Ap::CoolstepMinCurrent, Ap::MicrostepInterpolation] {
        module.ok(Command::StoreAxisParameter, parameter.number(), 0, 0);
    }
    module.power_cycle();
    assert_eq!([module.gap(Ap::Coolconf), module.gap(Ap::CoolstepHysteresisStart)], [33_011, 0]);
    assert_eq!([module.gap(Ap::Chopconf), module.gap(Ap::MicrostepInterpolation)], [33_011, 1]);
}

#[test]
fn restoring_brings_back_what_is_stored_or_the_factory_s() {
    let mut module = StepDriver::new();
    for (stored, value) in [(None, 24), (Some(10), 10)] {
        if let Some(stored) = stored {
            module.sap(Ap::MaxCurrent, stored);
            module.ok(Command::StoreAxisParameter, Ap::MaxCurrent.number(), 0, 0);
        }
        module.sap(Ap::MaxCurrent, 31);
        module.ok(Command::RestoreAxisParameter, Ap::MaxCurrent.number(), 0, 0);
        assert_eq!(module.gap(Ap::MaxCurrent), value);
    }
    module.sap(Ap::Coolconf, 0);
    module.ok(Command::RestoreAxisParameter, Ap::Coolconf.number(), 0, 0);
    assert_eq!([module.gap(Ap::Coolconf), module.gap(Ap::CoolstepHysteresisStart)], [33_011, 0]);
}

#[test]
fn the_inputs_read_their_levels() {
    let mut module = StepDriver::new();
    for (name, port) in [(CHOP, 0), (ENABLE, 1)] {
        for level in [1, 0] {
            module.set(name, level);
            module.run_ticks(1);
            assert_eq!(module.ok(Command::GetInput, port, 0, 0), level, "{name}");
        }
    }
    for (port, bank) in [(2, 0), (255, 0), (0, 1), (0, 2), (255, 2)] {
        assert_eq!(module.status(Command::GetInput, port, bank, 0), WrongType, "GIO {port}, {bank}");
    }
}

/// Direct mode only: SAP, GAP, STAP, RSAP, GIO, 136, 137 and 255; the user functions are empty (decisions 7.1).
#[test]
fn every_other_command_is_invalid() {
    let mut module = StepDriver::new();
    let known = [5, 6, 7, 8, 15, 136, 137, 255];
    for number in 0..=255_u8 {
        if !known.contains(&number) {
            let mut datagram = [1, number, 0, 0, 0, 0, 0, 0, 0];
            datagram[8] = datagram.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte));
            let expected = [2, 1, 2, number, 0, 0, 0, 0, 5_u8.wrapping_add(number)];
            assert_eq!(module.exchange(&datagram), expected, "command {number}");
        }
    }
    assert_eq!(SPEC.commands.len(), known.len() + 8);
}

#[test]
fn it_says_who_it_is_and_starts_anew() {
    let mut module = StepDriver::new();
    let version = serial::encode_request(1, Request::new(Command::FirmwareVersion, 0, 0, 0));
    assert_eq!(module.exchange(&version), *b"\x021076V102");
    assert_eq!(module.ok(Command::FirmwareVersion, 1, 0, 0), 0x0434_0102);
    assert_eq!(module.status(Command::FirmwareVersion, 2, 0, 0), WrongType);
    for command in [Command::FactoryReset, Command::SoftwareReset] {
        assert_eq!(module.status(command, 0, 0, 1233), InvalidValue);
    }
    module.sap(Ap::MaxCurrent, 10);
    module.ok(Command::SoftwareReset, 0, 0, 1234);
    assert_eq!(module.gap(Ap::MaxCurrent), 24);
}

/// The examples of §3.5, byte for byte: there is neither an AP 4 nor an AP 1 nor a bank 1, and RSAP's printed checksum is wrong.
#[test]
fn the_manuals_binary_examples() {
    let mut module = StepDriver::new();
    for (request, reply) in [
        ([1, 5, 4, 0, 0, 0, 0xC8, 0, 0xD2], [2, 1, 3, 5, 0, 0, 0, 0, 0x0B]),
        ([1, 6, 1, 0, 0, 0, 0, 0, 8], [2, 1, 3, 6, 0, 0, 0, 0, 0x0C]),
        ([1, 7, 6, 0, 0, 0, 0, 0, 0x0E], [2, 1, 100, 7, 0, 0, 0, 0, 0x6E]),
        ([1, 8, 6, 0, 0, 0, 0, 0, 0x0A], [2, 1, 1, 0, 0, 0, 0, 0, 4]),
        ([1, 8, 6, 0, 0, 0, 0, 0, 0x0F], [2, 1, 100, 8, 0, 0, 0, 0, 0x6F]),
        ([1, 15, 0, 1, 0, 0, 0, 0, 0x11], [2, 1, 3, 15, 0, 0, 0, 0, 0x15]),
    ] {
        assert_eq!(module.exchange(&request), reply, "{request:02x?}");
    }
}
