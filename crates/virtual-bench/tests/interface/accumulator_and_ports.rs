//! Calculation in direct mode (§5.5, §5.7.16, §5.7.28 to §5.7.30; decisions §3) and the ports (§5.7.14, §5.7.15).

use crate::common::{Module, VARIABLES};
use tmcl_tables::tmcm_1311::{AxisParameter, SPEC};
use tmcl_tables::{Command, Direction, GlobalParameter, Status};

use Status::{InvalidValue, Ok, WrongType};

const LOAD: u8 = 9;
const OUTPUTS: u8 = 2;

/// A op v, by decisions 3.2: wraps, division by zero is 0, modulo by zero leaves A, MIN / -1 = MIN, MIN % -1 = 0.
static CALCULATIONS: &[(u8, i32, i32, i32)] = &[
    (0, 2, 3, 5),
    (0, i32::MAX, 1, i32::MIN),
    (1, 2, 3, -1),
    (1, i32::MIN, 1, i32::MAX),
    (2, -7, 6, -42),
    (2, 65_536, 65_536, 0),
    (2, 123_456_789, 10, 1_234_567_890),
    (2, 123_456_789, 100, -539_222_988),
    (3, 7, 2, 3),
    (3, -7, 2, -3),
    (3, 7, 0, 0),
    (3, i32::MIN, -1, i32::MIN),
    (4, 7, 4, 3),
    (4, -7, 4, -3),
    (4, 7, 0, 7),
    (4, i32::MIN, -1, 0),
    (5, 0b1100, 0b1010, 0b1000),
    (6, 0b1100, 0b1010, 0b1110),
    (7, 0b1100, 0b1010, 0b0110),
];

#[test]
fn calc_works_on_the_accumulator_and_replies_with_it() {
    let mut module = Module::new();
    assert_eq!(module.ok(Command::Calculate, 0, 0, 0), 0, "cleared at power-on (decisions 2a.19)");
    for &(operation, a, value, result) in CALCULATIONS {
        assert_eq!(module.ok(Command::Calculate, LOAD, 0, a), a);
        assert_eq!(module.ok(Command::Calculate, operation, 0, value), result, "{a} op {operation} {value}");
        assert_eq!(module.ok(Command::Calculate, 6, 0, 0), result, "it stayed");
    }
    module.ok(Command::Calculate, LOAD, 0, 0x00FF_00FF);
    assert_eq!(module.ok(Command::Calculate, 8, 0, 12_345), !0x00FF_00FF, "NOT ignores its operand");
}

#[test]
fn calcx_takes_its_second_operand_from_x() {
    let mut module = Module::new();
    for &(operation, a, x, result) in CALCULATIONS {
        module.ok(Command::Calculate, LOAD, 0, x);
        assert_eq!(module.ok(Command::CalculateX, LOAD, 0, 0), x, "X = A, replying with A");
        module.ok(Command::Calculate, LOAD, 0, a);
        assert_eq!(module.ok(Command::CalculateX, operation, 0, 77), result, "{a} op {operation} {x}");
        assert_eq!(module.ok(Command::CalculateX, 10, 0, 0), x, "SWAP, X unharmed");
        assert_eq!(module.ok(Command::CalculateX, 10, 0, 0), result, "SWAP back");
    }
    // NOT inverts X and leaves A (decisions 3.3).
    module.ok(Command::Calculate, LOAD, 0, 5);
    module.ok(Command::CalculateX, LOAD, 0, 0);
    module.ok(Command::Calculate, LOAD, 0, 6);
    assert_eq!(module.ok(Command::CalculateX, 8, 0, 0), 6);
    assert_eq!(module.ok(Command::CalculateX, 10, 0, 0), !5);
}

/// §5.5, decisions 3.9.
#[test]
fn reading_in_direct_mode_leaves_the_accumulator_alone() {
    let mut module = Module::new();
    module.ok(Command::Calculate, LOAD, 0, 77);
    module.gap(AxisParameter::MaxVelocity);
    module.ggp(GlobalParameter::SerialAddress);
    module.variable(3);
    module.coordinate(3);
    module.ok(Command::GetInput, 8, 1, 0);
    module.ok(Command::ApplicationStatus, 0, 0, 0);
    assert_eq!(module.ok(Command::Calculate, 0, 0, 0), 77);
}

#[test]
fn aap_agp_and_aco_write_the_accumulator_and_reply_with_it() {
    let mut module = Module::new();
    module.ok(Command::Calculate, LOAD, 0, 1234);
    assert_eq!(module.ok(Command::AccumulatorToAxisParameter, 4, 0, -1), 1234);
    assert_eq!(module.gap(AxisParameter::MaxVelocity), 1234);
    assert_eq!(module.ok(Command::AccumulatorToGlobalParameter, 200, VARIABLES, -1), 1234);
    assert_eq!(module.variable(200), 1234);
    assert_eq!(module.ok(Command::AccumulatorToCoordinate, 9, 0, -1), 1234);
    assert_eq!(module.coordinate(9), 1234);
    assert_eq!(
        module.status(Command::AccumulatorToAxisParameter, 6, 0, 0),
        InvalidValue,
        "1234 is no current"
    );
    assert_eq!(module.status(Command::AccumulatorToAxisParameter, 8, 0, 0), WrongType, "read-only");
    assert_eq!(module.status(Command::AccumulatorToGlobalParameter, 77, 0, 0), InvalidValue);
    assert_eq!(module.status(Command::AccumulatorToGlobalParameter, 128, 0, 0), WrongType);
    assert_eq!(module.ok(Command::Calculate, 0, 0, 0), 1234);
    // A setting that AGP writes is stored as SGP would (§10.1).
    module.ok(Command::Calculate, LOAD, 0, 5);
    module.ok(Command::AccumulatorToGlobalParameter, 69, 0, 0);
    module.power_cycle();
    assert_eq!(module.ggp(GlobalParameter::CanBitRate), 5);
}

/// The potentiometer example of §5.7.29 needs it (decisions 2a.1).
#[test]
fn aap_0_starts_a_move_and_aap_2_a_rotation() {
    let mut module = Module::new();
    module.ok(Command::Calculate, LOAD, 0, 500);
    module.ok(Command::AccumulatorToAxisParameter, 0, 0, 0);
    module.run_ms(3000);
    assert_eq!(module.gap(AxisParameter::ActualPosition), 500);
    module.ok(Command::AccumulatorToAxisParameter, 2, 0, 0);
    module.run_ms(1000);
    assert_eq!(module.gap(AxisParameter::ActualVelocity), 500);
}

#[test]
fn outputs_are_set_one_by_one_and_read_back() {
    let mut module = Module::new();
    for port in 0..8 {
        assert_eq!(module.ok(Command::GetInput, port, OUTPUTS, 0), 0, "low at power-on");
    }
    for port in 0..8 {
        module.ok(Command::SetOutput, port, OUTPUTS, 1);
        for other in 0..8 {
            let expected = i32::from(other == port);
            assert_eq!(module.ok(Command::GetInput, other, OUTPUTS, 0), expected, "SIO {port}, GIO {other}");
        }
        module.ok(Command::SetOutput, port, OUTPUTS, 0);
        assert_eq!(module.ok(Command::GetInput, port, OUTPUTS, 0), 0);
    }
    for value in [2, -1, 255, i32::MIN] {
        assert_eq!(module.status(Command::SetOutput, 0, OUTPUTS, value), InvalidValue, "SIO 0, 2, {value}");
    }
}

fn outputs(module: &mut Module) -> i32 {
    (0..8).map(|port| module.ok(Command::GetInput, port, OUTPUTS, 0) << port).sum()
}

/// §5.7.14: a bit for every line; -1 stands for the low byte of the accumulator (decisions 3.13).
#[test]
fn port_255_sets_all_outputs_at_once() {
    let mut module = Module::new();
    for value in 0..=255 {
        assert_eq!(module.ok(Command::SetOutput, 255, OUTPUTS, value), value);
        assert_eq!(outputs(&mut module), value);
    }
    for value in [256, -2, i32::MAX, i32::MIN] {
        assert_eq!(
            module.status(Command::SetOutput, 255, OUTPUTS, value),
            InvalidValue,
            "SIO 255, 2, {value}"
        );
    }
    assert_eq!(outputs(&mut module), 255);
    for a in [0, 0xA5, 0x1234, -1, i32::MIN] {
        module.ok(Command::Calculate, LOAD, 0, a);
        assert_eq!(module.ok(Command::SetOutput, 255, OUTPUTS, -1), -1, "the value sent");
        assert_eq!(outputs(&mut module), a & 0xFF);
    }
}

#[test]
fn inputs_read_what_the_tables_allow() {
    let mut module = Module::new();
    module.run_ms(1);
    for port in SPEC.ports {
        let value = module.ok(Command::GetInput, port.number, port.bank, 0);
        assert!(port.range.contains(i64::from(value)), "{}: {value}", port.id);
    }
    let lines: i32 = (0..8).map(|port| module.ok(Command::GetInput, port, 0, 0) << port).sum();
    assert_eq!(module.ok(Command::GetInput, 255, 0, 0), lines, "all digital inputs (§5.7.15.1)");
    // §5.7.15.2 and chapter 6 measure the same things.
    for (port, parameter) in [
        (8, AxisParameter::SupplyVoltage),
        (9, AxisParameter::ModuleTemperature),
        (10, AxisParameter::PhaseACurrent),
        (11, AxisParameter::PhaseBCurrent),
        (12, AxisParameter::DcCurrent),
    ] {
        assert_eq!(module.ok(Command::GetInput, port, 1, 0), module.gap(parameter), "GIO {port}, 1");
    }
}

#[test]
fn ports_that_are_not_there_are_wrong_types() {
    let mut module = Module::new();
    for bank in 0..=255 {
        for port in 0..=255 {
            let entry = SPEC.port(bank, port);
            // The manual documents GIO 255, 0 and SIO 255, 2; what GIO 255, 2 does it does not say (open point 190).
            if port == 255 && (bank == 0 || bank == 2) {
                continue;
            }
            let readable = if entry.is_some() { Ok } else { WrongType };
            assert_eq!(module.status(Command::GetInput, port, bank, 0), readable, "GIO {port}, {bank}");
            let writable = entry.is_some_and(|entry| entry.direction == Direction::Output);
            let expected = if writable { Ok } else { WrongType };
            assert_eq!(module.status(Command::SetOutput, port, bank, 0), expected, "SIO {port}, {bank}");
        }
    }
    assert_eq!(module.status(Command::SetOutput, 255, 0, 0), WrongType, "inputs cannot be set");
    assert_eq!(module.status(Command::SetOutput, 255, 1, 0), WrongType);
}
