//! Settings of the module itself (§10.1): addresses, lock, resets, silence, timers.

use crate::common::{EEPROM, Module, TICKS_PER_MS, VARIABLES};
use tmcl_tables::tmcm_1311::AxisParameter;
use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::{Request, serial};

use Status::{EepromLocked, InvalidValue, Ok};

/// GP 66 is reached through what this sends, so that the address can be foreign.
fn ask(module: &mut Module, address: u8) -> Vec<u8> {
    module.exchange(&serial::encode_request(address, Request::new(Command::GetGlobalParameter, 76, 0, 0)))
}

mod addresses {
    use super::*;

    /// Decisions 2a.11: the reply still carries the old one.
    #[test]
    fn a_new_module_address_takes_effect_after_the_reply() {
        let mut module = Module::new();
        module.sgp(GlobalParameter::SerialAddress, 3);
        assert_eq!(ask(&mut module, 1), []);
        module.address = 3;
        assert_eq!(module.ggp(GlobalParameter::SerialAddress), 3);
        module.power_cycle();
        assert_eq!(module.ggp(GlobalParameter::SerialAddress), 3, "stored by setting it");
        for address in [0, 255] {
            module.sgp(GlobalParameter::SerialAddress, i32::from(address));
            module.address = address;
            assert_eq!(
                module.ggp(GlobalParameter::SerialAddress),
                i32::from(address),
                "no special addresses"
            );
        }
    }

    #[test]
    fn a_new_host_address_takes_effect_after_the_reply() {
        let mut module = Module::new();
        module.sgp(GlobalParameter::HostAddress, 200);
        module.host = 200;
        assert_eq!(module.ggp(GlobalParameter::HostAddress), 200);
        module.power_cycle();
        assert_eq!(module.ggp(GlobalParameter::HostAddress), 200);
        let version = serial::encode_request(1, Request::new(Command::FirmwareVersion, 0, 0, 0));
        assert_eq!(module.exchange(&version), b"\xC81311V111");
    }

    /// The group address of global parameter 87 is obeyed and never answered, whatever is wrong.
    #[test]
    fn the_secondary_address_executes_and_sends_nothing() {
        let mut module = Module::new();
        let silent = |module: &mut Module, bytes: &[u8]| assert_eq!(module.exchange(bytes), [], "{bytes:?}");
        let set =
            |value| serial::encode_request(9, Request::new(Command::SetGlobalParameter, 7, VARIABLES, value));
        silent(&mut module, &set(41));
        assert_eq!(module.variable(7), 0, "not heard yet");
        module.sgp(GlobalParameter::SerialSecondaryAddress, 9);
        silent(&mut module, &set(42));
        assert_eq!(module.variable(7), 42);
        let mut spoiled = set(43);
        spoiled[8] ^= 1;
        silent(&mut module, &spoiled);
        module.run_ms(101);
        for request in [
            Request::new(Command::GetAxisParameter, 0, 0, 0),
            Request::new(Command::GetAxisParameter, 21, 0, 0),
            Request::new(Command::FirmwareVersion, 0, 0, 0),
            Request::new(Command::RequestPositionReachedEvent, 0, 0, 0),
        ] {
            silent(&mut module, &serial::encode_request(9, request));
        }
        module.run_ms(1);
        assert_eq!(module.unasked(), [], "no event for the group either");
        assert_eq!(module.variable(7), 42);
        module.power_cycle();
        silent(&mut module, &set(44));
        assert_eq!(module.variable(7), 44, "stored by setting it");
        module.sgp(GlobalParameter::SerialSecondaryAddress, 0);
        silent(&mut module, &set(45));
        assert_eq!(module.variable(7), 44);
    }

    #[test]
    fn secondary_address_0_is_none() {
        let mut module = Module::new();
        let request = Request::new(Command::SetGlobalParameter, 7, VARIABLES, 1);
        assert_eq!(module.exchange(&serial::encode_request(0, request)), []);
        assert_eq!(module.variable(7), 0);
    }
}

mod lock {
    use super::*;

    fn locked() -> Module {
        let mut module = Module::new();
        module.sgp(GlobalParameter::EepromLock, 1234);
        module
    }

    #[test]
    fn locks_with_1234_and_unlocks_with_4321_and_survives_power_off() {
        let mut module = locked();
        assert_eq!(module.ggp(GlobalParameter::EepromLock), 1);
        module.power_cycle();
        assert_eq!(module.ggp(GlobalParameter::EepromLock), 1);
        for value in [0, 1, 1233, 4322, -1234] {
            assert_eq!(module.status(Command::SetGlobalParameter, 73, 0, value), InvalidValue);
        }
        assert_eq!(module.ggp(GlobalParameter::EepromLock), 1);
        module.sgp(GlobalParameter::EepromLock, 4321);
        assert_eq!(module.ggp(GlobalParameter::EepromLock), 0);
        module.sgp(GlobalParameter::AutoStart, 1);
        module.power_cycle();
        assert_eq!(module.ggp(GlobalParameter::EepromLock), 0);
        assert_eq!(module.ggp(GlobalParameter::AutoStart), 1);
    }

    /// Decisions 2a.10.
    #[test]
    fn covers_whatever_writes_settings() {
        let mut module = locked();
        for number in [64, 65, 66, 67, 68, 69, 70, 71, 75, 76, 77, 79, 81, 83, 84, 85, 87, 88] {
            let value = if number == 69 { 5 } else { 0 };
            assert_eq!(
                module.status(Command::SetGlobalParameter, number, 0, value),
                EepromLocked,
                "SGP {number}"
            );
            // What AGP writes is what SGP writes.
            let agp = module.status(Command::AccumulatorToGlobalParameter, number, 0, 0);
            assert_eq!(agp, EepromLocked, "AGP {number}");
        }
        assert_eq!(module.status(Command::StoreAxisParameter, 4, 0, 0), EepromLocked);
        assert_eq!(module.status(Command::StoreGlobalParameter, 0, VARIABLES, 0), EepromLocked);
        assert_eq!(module.status(Command::SetCoordinate, 0, EEPROM, 0), EepromLocked);
        assert_eq!(module.status(Command::SetCoordinate, 5, EEPROM, 0), EepromLocked);
        assert_eq!(module.ggp(GlobalParameter::CanBitRate), 8, "nothing was set");
    }

    #[test]
    fn leaves_everything_else_alone() {
        let mut module = locked();
        for (command, kind, motor, value) in [
            (Command::SetAxisParameter, 4, 0, 1000),
            (Command::RestoreAxisParameter, 4, 0, 0),
            (Command::SetGlobalParameter, 0, VARIABLES, 5),
            (Command::RestoreGlobalParameter, 0, VARIABLES, 0),
            (Command::SetGlobalParameter, 0, 3, 5),
            (Command::SetGlobalParameter, 132, 0, 5),
            (Command::AccumulatorToGlobalParameter, 1, VARIABLES, 0),
            (Command::SetCoordinate, 5, 0, 1000),
            (Command::GetCoordinate, 5, EEPROM, 0),
            (Command::GetCoordinate, 0, EEPROM, 0),
            (Command::CaptureCoordinate, 6, 0, 0),
            (Command::AccumulatorToCoordinate, 7, 0, 0),
            (Command::SetOutput, 0, 2, 1),
            (Command::MoveToPosition, 0, 0, 100),
        ] {
            assert_eq!(module.status(command, kind, motor, value), Ok, "{command:?} {kind}, {motor}");
        }
    }

    /// With GP 84 = 1 coordinates 1 to 20 are written through, and that is locked too; coordinate 0 is in RAM only.
    #[test]
    fn covers_coordinates_that_go_to_the_eeprom() {
        let mut module = Module::new();
        module.sgp(GlobalParameter::CoordinateStorage, 1);
        module.sgp(GlobalParameter::EepromLock, 1234);
        for (number, expected) in [(0, Ok), (1, EepromLocked), (20, EepromLocked)] {
            assert_eq!(module.status(Command::SetCoordinate, number, 0, 5), expected, "SCO {number}");
            assert_eq!(module.status(Command::CaptureCoordinate, number, 0, 0), expected, "CCO {number}");
            assert_eq!(
                module.status(Command::AccumulatorToCoordinate, number, 0, 0),
                expected,
                "ACO {number}"
            );
        }
        assert_eq!(module.coordinate(1), 0);
    }

    /// Decisions 2a.10: ignored while locked.
    #[test]
    fn covers_the_factory_reset() {
        let mut module = Module::new();
        module.sgp(GlobalParameter::AutoStart, 1);
        module.sgp(GlobalParameter::EepromLock, 1234);
        module.unanswered(Command::FactoryReset, 0, 0, 1234);
        module.run_ms(100);
        module.power_cycle();
        assert_eq!(module.ggp(GlobalParameter::AutoStart), 1);
        assert_eq!(module.ggp(GlobalParameter::EepromLock), 1);
    }
}

mod resets {
    use super::*;

    fn changed() -> Module {
        let mut module = Module::new();
        module.sap(AxisParameter::MaxVelocity, 777);
        module.ok(Command::StoreAxisParameter, 4, 0, 0);
        module.sgp(GlobalParameter::AutoStart, 1);
        module.sgp(GlobalParameter::CanBitRate, 5);
        module.ok(Command::SetGlobalParameter, 9, VARIABLES, 99);
        module.ok(Command::StoreGlobalParameter, 9, VARIABLES, 0);
        module
    }

    #[track_caller]
    fn assert_factory(module: &mut Module) {
        assert_eq!(module.gap(AxisParameter::MaxVelocity), 51_200);
        assert_eq!(module.ggp(GlobalParameter::AutoStart), 0);
        assert_eq!(module.ggp(GlobalParameter::CanBitRate), 8);
        assert_eq!(module.variable(9), 0);
        assert_eq!(module.ggp(GlobalParameter::EepromMagic), 228);
    }

    /// Decisions 2a.13.
    #[test]
    fn a_wrong_eeprom_magic_brings_the_factory_settings_at_the_next_power_on() {
        let mut module = changed();
        module.sgp(GlobalParameter::EepromMagic, 0);
        assert_eq!(module.gap(AxisParameter::MaxVelocity), 777, "not before");
        assert_eq!(module.ggp(GlobalParameter::AutoStart), 1, "not before");
        module.power_cycle();
        assert_factory(&mut module);
        module.sgp(GlobalParameter::AutoStart, 1);
        module.power_cycle();
        assert_eq!(module.ggp(GlobalParameter::AutoStart), 1, "once, not for ever");
    }

    #[test]
    fn the_right_eeprom_magic_resets_nothing() {
        let mut module = changed();
        module.sgp(GlobalParameter::EepromMagic, 1);
        module.sgp(GlobalParameter::EepromMagic, 228);
        module.power_cycle();
        assert_eq!(module.gap(AxisParameter::MaxVelocity), 777);
        assert_eq!(module.ggp(GlobalParameter::AutoStart), 1);
    }

    #[test]
    fn a_wrong_eeprom_magic_brings_the_addresses_back_too() {
        let mut module = Module::new();
        module.sgp(GlobalParameter::SerialAddress, 7);
        module.address = 7;
        module.sgp(GlobalParameter::HostAddress, 8);
        module.host = 8;
        module.sgp(GlobalParameter::EepromMagic, 255);
        module.power_cycle();
        (module.address, module.host) = (1, 2);
        assert_eq!(module.ggp(GlobalParameter::SerialAddress), 1);
    }

    /// §5.7.39: "Reset all settings stored in the EEPROM", without a reply.
    #[test]
    fn command_137_resets_the_stored_settings_without_a_reply() {
        let mut module = changed();
        module.unanswered(Command::FactoryReset, 0, 0, 1234);
        module.run_ms(100);
        module.power_cycle();
        assert_factory(&mut module);
    }

    /// Decisions 1.6: "the reply may be lost".
    #[test]
    fn command_255_restarts_the_module_as_if_switched_off_and_on() {
        let mut module = changed();
        module.sap(AxisParameter::MaxVelocity, 888);
        module.sap(AxisParameter::MaxAcceleration, 888);
        module.ok(Command::Calculate, 9, 0, 5);
        module.ok(Command::SetOutput, 3, 2, 1);
        module.ok(Command::SetGlobalParameter, 100, VARIABLES, 5);
        module.ok(Command::MoveToPosition, 0, 0, 1000);
        module.run_ms(50);
        let replies = module.replies(Request::new(Command::SoftwareReset, 0, 0, 1234));
        assert!(replies.len() <= 1, "{replies:?}");
        module.run_ms(1);
        assert_eq!(module.gap(AxisParameter::MaxVelocity), 777, "stored");
        assert_eq!(module.gap(AxisParameter::MaxAcceleration), 51_200, "not stored");
        assert_eq!(module.ggp(GlobalParameter::AutoStart), 1, "stored");
        assert_eq!(module.variable(9), 99, "stored");
        assert_eq!(module.variable(100), 0, "cannot be stored");
        assert_eq!(module.ok(Command::Calculate, 0, 0, 0), 0, "decisions 2a.19");
        assert_eq!(module.ok(Command::GetInput, 3, 2, 0), 0);
        assert_eq!(module.gap(AxisParameter::ActualPosition), 0);
        assert_eq!(module.gap(AxisParameter::TargetPosition), 0);
        assert_eq!(module.gap(AxisParameter::ActualVelocity), 0);
        module.run_ms(1000);
        assert_eq!(module.gap(AxisParameter::ActualPosition), 0, "the move is forgotten");
    }
}

/// Decisions 2a.12.
#[test]
fn suppressed_replies_are_not_sent_until_the_setting_is_0_again() {
    let mut module = Module::new();
    module.sgp(GlobalParameter::SuppressReply, 1);
    module.unanswered(Command::SetGlobalParameter, 3, VARIABLES, 33);
    module.unanswered(Command::GetGlobalParameter, 3, VARIABLES, 0);
    module.unanswered(Command::GetGlobalParameter, 255, 0, 0);
    module.unanswered(Command::GetAxisParameter, 21, 0, 0);
    module.unanswered(Command::FirmwareVersion, 0, 0, 0);
    module.unanswered(Command::RequestPositionReachedEvent, 0, 0, 0);
    module.unanswered(Command::MoveToPosition, 0, 0, 100);
    let mut spoiled = serial::encode_request(1, Request::default());
    spoiled[8] ^= 1;
    assert_eq!(module.exchange(&spoiled), []);
    module.run_ms(3000);
    assert_eq!(module.unasked(), []);
    assert_eq!(module.ok(Command::SetGlobalParameter, 255, 0, 1), 1, "itself it is answered");
    module.unanswered(Command::GetGlobalParameter, 3, VARIABLES, 0);
    module.sgp(GlobalParameter::SuppressReply, 0);
    assert_eq!(module.variable(3), 33, "executed all the same");
    assert_eq!(module.gap(AxisParameter::ActualPosition), 100);
    module.sgp(GlobalParameter::SuppressReply, 1);
    module.power_cycle();
    assert_eq!(module.ggp(GlobalParameter::SuppressReply), 0, "not stored");
}

/// Decisions 2a.13.
#[test]
fn variables_start_at_0_when_they_are_not_to_be_restored() {
    let mut module = Module::new();
    module.ok(Command::SetGlobalParameter, 5, VARIABLES, 55);
    module.ok(Command::StoreGlobalParameter, 5, VARIABLES, 0);
    module.sgp(GlobalParameter::DoNotRestoreVariables, 1);
    assert_eq!(module.variable(5), 55, "a matter of power-on");
    module.power_cycle();
    assert_eq!(module.variable(5), 0);
    module.ok(Command::RestoreGlobalParameter, 5, VARIABLES, 0);
    assert_eq!(module.variable(5), 55, "still in the EEPROM");
    module.sgp(GlobalParameter::DoNotRestoreVariables, 0);
    module.power_cycle();
    assert_eq!(module.variable(5), 55);
}

/// §10.1 and decisions 2a.13: milliseconds, any start value, wraps at 2^32.
#[test]
fn the_tick_timer_counts_milliseconds() {
    let mut module = Module::new();
    module.sgp(GlobalParameter::TickTimer, 1000);
    assert_eq!(module.ggp(GlobalParameter::TickTimer), 1000);
    for ms in 1..=100 {
        module.run_ms(1);
        let drift = module.ggp(GlobalParameter::TickTimer) - 1000 - ms;
        assert!((-1..=1).contains(&drift), "{ms} ms: {drift}");
    }
    module.sgp(GlobalParameter::TickTimer, -1);
    module.run_ms(10);
    assert!((8..=10).contains(&module.ggp(GlobalParameter::TickTimer)), "wraps to 0");
    module.sgp(GlobalParameter::TickTimer, i32::MAX);
    module.run_ms(10);
    let after = module.ggp(GlobalParameter::TickTimer);
    assert!((8..=10).contains(&after.wrapping_sub(i32::MAX)), "{after}: travels as two's complement");
    // It does not drift: a thousand seconds of reading it every now and then.
    module.sgp(GlobalParameter::TickTimer, 0);
    module.run_ticks(3 * TICKS_PER_MS / 2);
    for _ in 0..10 {
        module.run_ms(997);
        module.ggp(GlobalParameter::TickTimer);
    }
    assert!((9970..=9972).contains(&module.ggp(GlobalParameter::TickTimer)));
}

#[test]
fn random_numbers_are_not_negative_and_change_with_every_read() {
    let read = |module: &mut Module| {
        (0..1000).map(|_| module.ggp(GlobalParameter::RandomNumber)).collect::<Vec<_>>()
    };
    let numbers = read(&mut Module::new());
    assert!(numbers.iter().all(|number| *number >= 0));
    assert!(numbers.windows(2).all(|pair| pair[0] != pair[1]), "a new one with every read");
    // All of the range: among a thousand fair ones, every one of its upper bits is seen both set and clear.
    for bit in 0..31 {
        let set = numbers.iter().filter(|number| **number >> bit & 1 == 1).count();
        assert!((300..=700).contains(&set), "bit {bit}: {set} of 1000");
    }
    assert_eq!(read(&mut Module::new()), numbers, "a bench is a pure function of its inputs");
}
