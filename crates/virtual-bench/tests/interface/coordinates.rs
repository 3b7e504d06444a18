//! Coordinates in RAM and EEPROM (§5.7.25 to §5.7.27, global parameter 84; decisions "SCO" and 2a.4).

use crate::common::{EEPROM, Module};
use tmcl_tables::tmcm_1311::AxisParameter;
use tmcl_tables::{Command, GlobalParameter};

fn value(number: u8) -> i32 {
    i32::from(number) * -1_000_003 + 5
}

fn set_all(module: &mut Module) {
    for number in 0..=20 {
        module.ok(Command::SetCoordinate, number, 0, value(number));
    }
}

#[track_caller]
fn assert_all(module: &mut Module, expected: impl Fn(u8) -> i32) {
    for number in 0..=20 {
        assert_eq!(module.coordinate(number), expected(number), "coordinate {number}");
    }
}

#[test]
fn coordinates_never_set_read_0() {
    assert_all(&mut Module::new(), |_| 0);
}

/// "24 bit" in §5.7.26 is a leftover.
#[test]
fn coordinates_hold_32_bits() {
    let mut module = Module::new();
    for extreme in [i32::MIN, -1, i32::MAX] {
        module.ok(Command::SetCoordinate, 20, 0, extreme);
        assert_eq!(module.coordinate(20), extreme);
    }
}

/// The default, GP 84 = 0.
#[test]
fn coordinates_live_in_ram_only_by_default() {
    let mut module = Module::new();
    set_all(&mut module);
    assert_all(&mut module, value);
    module.power_cycle();
    assert_all(&mut module, |_| 0);
}

#[test]
fn sco_0_255_copies_all_but_coordinate_0_to_the_eeprom_and_gco_0_255_back() {
    let mut module = Module::new();
    set_all(&mut module);
    module.ok(Command::SetCoordinate, 0, EEPROM, 0);
    assert_all(&mut module, value);
    for number in 0..=20 {
        module.ok(Command::SetCoordinate, number, 0, 1);
    }
    module.ok(Command::GetCoordinate, 0, EEPROM, 0);
    assert_all(&mut module, |number| if number == 0 { 1 } else { value(number) });
    module.power_cycle();
    assert_all(&mut module, |_| 0);
    module.ok(Command::GetCoordinate, 0, EEPROM, 0);
    assert_all(&mut module, |number| if number == 0 { 0 } else { value(number) });
}

#[test]
fn sco_n_255_copies_one_coordinate_to_the_eeprom_and_gco_n_255_back() {
    let mut module = Module::new();
    set_all(&mut module);
    module.ok(Command::SetCoordinate, 7, EEPROM, 0);
    module.power_cycle();
    module.ok(Command::SetCoordinate, 8, 0, 88);
    module.ok(Command::GetCoordinate, 7, EEPROM, 0);
    assert_all(&mut module, |number| match number {
        7 => value(7),
        8 => 88,
        _ => 0,
    });
}

#[test]
fn with_storage_on_coordinates_1_to_20_survive_power_off_whichever_command_set_them() {
    let mut module = Module::new();
    module.sgp(GlobalParameter::CoordinateStorage, 1);
    set_all(&mut module);
    module.sap(AxisParameter::ActualPosition, 333);
    module.ok(Command::CaptureCoordinate, 3, 0, 0);
    module.ok(Command::CaptureCoordinate, 0, 0, 0);
    module.ok(Command::Calculate, 9, 0, 444);
    module.ok(Command::AccumulatorToCoordinate, 4, 0, 0);
    let expected = |number| match number {
        3 => 333,
        4 => 444,
        _ => value(number),
    };
    assert_all(&mut module, |number| if number == 0 { 333 } else { expected(number) });
    module.power_cycle();
    assert_all(&mut module, |number| if number == 0 { 0 } else { expected(number) });
}

/// Decisions 2a.4: CCO captures axis parameter 1.
#[test]
fn a_captured_coordinate_is_the_actual_position_in_mid_move() {
    let mut module = Module::new();
    module.ok(Command::MoveToPosition, 0, 0, 51_200);
    module.run_ms(700);
    module.ok(Command::CaptureCoordinate, 3, 0, 0);
    let position = module.gap(AxisParameter::ActualPosition);
    assert!((1000..50_000).contains(&position), "{position}: on the way");
    assert_eq!(module.coordinate(3), position);
}

#[test]
fn a_move_to_a_coordinate_ends_there() {
    let mut module = Module::new();
    module.ok(Command::SetCoordinate, 20, 0, -12_345);
    module.ok(Command::SetCoordinate, 0, 0, 54_321);
    for (number, position) in [(20, -12_345), (0, 54_321), (1, 0)] {
        assert_eq!(module.ok(Command::MoveToPosition, 2, 0, number), number);
        assert_eq!(module.gap(AxisParameter::TargetPosition), position);
        module.run_ms(5000);
        assert_eq!(module.gap(AxisParameter::ActualPosition), position);
        assert_eq!(module.gap(AxisParameter::PositionReached), 1);
    }
}

/// Reading in direct mode never touches the accumulator (§5.5), nor do the copying forms anywhere (decisions 2a.4).
#[test]
fn coordinates_leave_the_accumulator_alone() {
    let mut module = Module::new();
    module.ok(Command::Calculate, 9, 0, 77);
    set_all(&mut module);
    module.coordinate(5);
    module.ok(Command::SetCoordinate, 0, EEPROM, 0);
    module.ok(Command::GetCoordinate, 0, EEPROM, 0);
    module.ok(Command::GetCoordinate, 5, EEPROM, 0);
    module.ok(Command::CaptureCoordinate, 5, 0, 0);
    assert_eq!(module.ok(Command::Calculate, 0, 0, 0), 77);
}
