//! Program flow: jumps, conditions, calls, the end, and what the module refuses (TMCM-1311 §5.7.16 to §5.7.23; decisions
//! §3.1 to 3.6, 3.9, 3.11).

mod common;

use std::cmp::Ordering;

use common::*;
use tmcl_tables::{Command, Status};
use tmcl_vm::{DEPTH, ErrorFlag, Mode, Stepped};
use tmcl_wire::Request;

#[test]
fn instructions_are_executed_in_order_until_stop() {
    let mut machine = Bare::running(&[sap(1), sap(2), stop(), sap(3)]);
    assert_eq!(machine.trace(3), [0, 1, 2]);
    assert_eq!(machine.step(), Stepped::Idle);
    assert_eq!((machine.vm.mode(), machine.vm.is_active()), (Mode::Stop, false));
    assert_eq!(machine.log, [sap(1), sap(2)]);
}

#[test]
fn running_past_the_end_stops() {
    let mut machine = Bare::running(&[ja(63)]);
    machine.memory[63] = sap(1).to_bytes();
    assert_eq!(machine.trace(2), [0, 63]);
    assert_eq!(machine.step(), Stepped::Idle);
    assert_eq!(machine.vm.mode(), Mode::Stop);
}

#[test]
fn ja_goes_anywhere_in_memory_and_is_refused_outside() {
    for (target, goes) in [(0, true), (63, true), (64, false), (65_536, false), (65_537, false), (-1, false)]
    {
        let mut machine = Bare::running(&[ja(target), sap(1)]);
        let stepped = machine.step();
        if goes {
            assert_eq!((stepped, machine.vm.address()), (Stepped::Executed { address: 0 }, target as u16));
        } else {
            let refused = Stepped::Refused { address: 0, status: Status::InvalidValue };
            assert_eq!((stepped, machine.vm.address()), (refused, 1), "JA {target} is skipped");
            assert_eq!(machine.trace(1), [1]);
        }
    }
}

/// Conditions 0 to 7 against what they are called.
#[test]
fn jc_jumps_on_what_comp_found() {
    let numbers = [i32::MIN, i32::MIN + 1, -2, -1, 0, 1, 2, i32::MAX - 1, i32::MAX];
    for a in numbers {
        for value in numbers {
            let expected = [
                a == value,
                a != value,
                a == value,
                a != value,
                a > value,
                a >= value,
                a < value,
                a <= value,
            ];
            for (condition, jumps) in (0_u8..).zip(expected) {
                let mut machine = Bare::running(&[load(a), comp(value), jc(condition, 10)]);
                machine.trace(3);
                let address = if jumps { 10 } else { 3 };
                assert_eq!(machine.vm.address(), address, "{a} against {value}, condition {condition}");
                assert_eq!(machine.a(), a);
            }
        }
    }
}

/// ETO, EAL, EDV, EPO, ESD are conditions 8 to 12, and 1 to 5 of CLE; 0 clears all (decisions 3.5).
#[test]
fn jc_jumps_on_error_flags_and_cle_clears_them() {
    let flags = [
        ErrorFlag::Timeout,
        ErrorFlag::ExternalAlarm,
        ErrorFlag::Deviation,
        ErrorFlag::Position,
        ErrorFlag::Shutdown,
    ];
    for (index, flag) in (0_u8..).zip(flags) {
        for (condition, jumps) in (8..=12).map(|condition| (condition, condition == 8 + index)) {
            let mut machine = Bare::running(&[jc(condition, 10)]);
            machine.vm.set_error(flag);
            machine.trace(1);
            assert_eq!(machine.vm.address() == 10, jumps, "{flag:?}, condition {condition}");
            assert!(machine.vm.has_error(flag), "it stays until CLE");
        }
        for clearing in 0..=5 {
            let mut machine = Bare::running(&[cle(clearing)]);
            for flag in flags {
                machine.vm.set_error(flag);
            }
            machine.trace(1);
            let cleared = clearing == 0 || clearing == index + 1;
            assert_eq!(machine.vm.has_error(flag), !cleared, "CLE {clearing}, {flag:?}");
        }
    }
}

#[test]
fn unknown_types_are_refused_and_skipped() {
    for instruction in [
        jc(13, 0),
        jc(255, 0),
        calc(10, 0),
        calcx(11),
        wait(5, 1),
        cle(6),
        vect(4, 0),
        ei(4),
        di(47),
        ei(254),
        vect(255, 0),
    ] {
        let mut machine = Bare::running(&[instruction, sap(1)]);
        let refused = Stepped::Refused { address: 0, status: Status::WrongType };
        assert_eq!(machine.step(), refused, "{instruction:?}");
        assert_eq!(machine.trace(1), [1]);
    }
}

/// Decisions §2: an unknown command is status 2, one that is known but not for programs 6; the module's own refusals keep
/// their status. A stays (decisions 3.11).
#[test]
fn what_the_module_refuses_is_skipped_with_its_status() {
    let unknown = Request { command: UNKNOWN, ..Request::default() };
    for (instruction, status) in [
        (unknown, Status::InvalidCommand),
        (op(Command::SoftwareReset, 0, 1234), Status::NotAvailable),
        (Request::new(Command::GetAxisParameter, 4, 7, 5), Status::InvalidValue),
        (Request::new(Command::Wait, 1, 7, 5), Status::InvalidValue),
    ] {
        let mut machine = Bare::running(&[load(77), instruction, sap(1)]);
        machine.trace(1);
        assert_eq!(machine.step(), Stepped::Refused { address: 1, status }, "{instruction:?}");
        assert_eq!((machine.a(), machine.trace(1)), (77, vec![2]));
    }
}

/// Every instruction that writes A compares it with 0; the others leave the comparison alone (decisions 3.4).
#[test]
fn what_writes_a_compares_it_with_0() {
    for value in [-5, 0, 5] {
        let writers: &[&[Request]] = &[
            &[gap(value)],
            &[op(Command::GetGlobalParameter, 4, value)],
            &[op(Command::GetInput, 4, value)],
            &[op(Command::GetCoordinate, 4, value)],
            &[op(Command::ReferenceSearch, 2, value)],
            &[load(value)],
            &[load(value), calcx(LOAD), load(1), calcx(10)],
        ];
        for writer in writers {
            let mut machine = Bare::running(writer);
            machine.vm.registers.accumulator = 1;
            machine.vm.registers.compare(1);
            machine.trace(writer.len());
            assert_eq!(machine.a(), value, "{writer:?}");
            assert_eq!(machine.vm.registers.comparison, value.cmp(&0), "{writer:?}");
        }
    }
    let others = [
        sap(5),
        op(Command::ReferenceSearch, 0, 5),
        op(Command::ReferenceSearch, 1, 5),
        Request::new(Command::GetCoordinate, 4, 255, 5),
        op(Command::SetOutput, 4, 5),
        op(Command::CaptureCoordinate, 4, 5),
        op(Command::AccumulatorToAxisParameter, 4, 5),
        op(Command::AccumulatorToGlobalParameter, 4, 5),
        op(Command::AccumulatorToCoordinate, 4, 5),
        calcx(8),
        calcx(LOAD),
        cle(0),
        wait(TICKS, 0),
    ];
    for other in others {
        let mut machine = Bare::running(&[other]);
        machine.vm.registers.accumulator = 3;
        machine.vm.registers.compare(4);
        machine.trace(1);
        assert_eq!((machine.a(), machine.vm.registers.comparison), (3, Ordering::Less), "{other:?}");
    }
}

#[test]
fn jc_that_does_not_hold_goes_on() {
    let mut machine = Bare::running(&[load(0), jc(NZ, 40), jc(ZE, 40)]);
    assert_eq!(machine.trace(4), [0, 1, 2, 40]);
}

#[test]
fn a_subroutine_returns_behind_its_call() {
    let mut machine = Bare::running(&[csub(10), csub(20), stop()]);
    machine.memory[10] = csub(20).to_bytes();
    machine.memory[11] = rsub().to_bytes();
    machine.memory[20] = rsub().to_bytes();
    assert_eq!(machine.trace(7), [0, 10, 20, 11, 1, 20, 2]);
    assert_eq!(machine.vm.calls(), []);
}

/// A call from the last instruction returns to where there is nothing: it stops.
#[test]
fn a_call_from_the_last_instruction_returns_past_the_end() {
    let mut machine = Bare::running(&[ja(63), rsub()]);
    machine.memory[63] = csub(1).to_bytes();
    assert_eq!(machine.trace(3), [0, 63, 1]);
    assert_eq!(machine.step(), Stepped::Idle);
    assert_eq!(machine.vm.mode(), Mode::Stop);
}

#[test]
fn calls_nest_8_deep_and_the_ninth_is_ignored() {
    let mut program: Vec<_> = (1..=9).map(csub).collect();
    program.push(sap(1));
    let mut machine = Bare::running(&program);
    assert_eq!(machine.trace(8), [0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!((machine.vm.calls(), DEPTH), (&[1, 2, 3, 4, 5, 6, 7, 8][..], 8));

    let mut ninth = Bare::running(&[csub(30)]);
    ninth.vm = machine.vm;
    ninth.memory[8] = csub(30).to_bytes();
    ninth.memory[9] = rsub().to_bytes();
    assert_eq!(ninth.trace(2), [8, 9], "the ninth call goes nowhere, and execution on");
    assert_eq!(ninth.vm.address(), 8, "RSUB returns from the eighth");
}

#[test]
fn rsub_on_an_empty_stack_is_ignored() {
    let mut machine = Bare::running(&[rsub(), rsub(), csub(5), stop()]);
    machine.memory[5] = rsub().to_bytes();
    assert_eq!(machine.trace(5), [0, 1, 2, 5, 3]);
}

#[test]
fn csub_outside_memory_is_refused_and_keeps_no_return_address() {
    for target in [64, -1, i32::MAX] {
        let mut machine = Bare::running(&[csub(target), sap(1)]);
        assert_eq!(machine.step(), Stepped::Refused { address: 0, status: Status::InvalidValue });
        assert_eq!((machine.vm.calls(), machine.vm.address()), (&[][..], 1));
    }
}
