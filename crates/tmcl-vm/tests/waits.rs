//! WAIT in all its forms (TMCM-1311 §5.7.22; decisions 3.5, 3.7, 2a.18). A tick of WAIT is ten units of the machine's time,
//! and each unit the machine makes a step.

mod common;

use common::*;
use tmcl_vm::{ErrorFlag, Mode, Stepped};

/// A WAIT lasts as long as it says, counted from the step that meets it; what follows is executed the instant it ends.
#[test]
fn ticks_are_exact() {
    for ticks in [1, 2, 50, 1000] {
        let mut machine = Bare::running(&[wait(TICKS, ticks), sap(1)]);
        assert_eq!(machine.step(), Stepped::Waiting);
        while machine.log.is_empty() {
            assert_eq!(machine.vm.address(), 0, "the program counter is held");
            machine.tick();
        }
        assert_eq!(machine.now - 1, 10 * u64::try_from(ticks).unwrap());
        assert!(!machine.vm.has_error(ErrorFlag::Timeout), "TICKS do not time out");
    }
}

#[test]
fn no_ticks_are_no_wait() {
    for ticks in [0, -2, -1000, i32::MIN] {
        let mut machine = Bare::running(&[load(5), wait(TICKS, ticks), sap(1)]);
        assert_eq!(machine.trace(3), [0, 1, 2], "{ticks}");
        assert_eq!(machine.now, 0);
    }
}

/// -1 takes the ticks from the accumulator. Where there is nothing to wait for, WAIT is an instruction like any other.
#[test]
fn the_accumulator_says_how_many() {
    for (a, expected) in [(3, 30), (1, 10), (0, 1), (-1, 1), (i32::MIN, 1)] {
        let mut machine = Bare::running(&[load(a), wait(TICKS, -1), sap(1)]);
        machine.trace(1);
        while machine.log.is_empty() {
            machine.tick();
        }
        assert_eq!(machine.now - 1, expected, "A = {a}");
    }
}

#[test]
fn the_longest_wait_is_long() {
    let mut machine = Bare::running(&[wait(TICKS, i32::MAX), sap(1)]);
    machine.step();
    machine.now = i32::MAX as u64 * 10 - 1;
    assert_eq!(machine.step(), Stepped::Waiting);
    machine.now += 1;
    assert_eq!(machine.step(), Stepped::Executed { address: 1 });
}

/// Time that ends near the end of time does not wrap.
#[test]
fn a_wait_near_the_end_of_time_does_not_wrap() {
    let mut machine = Bare::running(&[wait(TICKS, i32::MAX), sap(1)]);
    machine.now = u64::MAX - 5;
    assert_eq!(machine.step(), Stepped::Waiting);
    machine.now += 1;
    assert_eq!(machine.step(), Stepped::Waiting);
}

#[test]
fn events_end_a_wait_whenever_they_come() {
    for (kind, index) in (1..=4).zip(0..) {
        for timeout in [0, -1, 100] {
            let mut machine = Bare::running(&[wait(kind, timeout), sap(1)]);
            for _ in 0..700 {
                assert_eq!(machine.tick(), Stepped::Waiting, "type {kind}, timeout {timeout}");
            }
            machine.happened = [true; 4];
            machine.happened[index] = false;
            assert_eq!(machine.tick(), Stepped::Waiting, "another event");
            machine.happened = [false; 4];
            machine.happened[index] = true;
            machine.tick();
            assert_eq!(machine.log, [sap(1)]);
            assert!(!machine.vm.has_error(ErrorFlag::Timeout));
        }
    }
}

#[test]
fn what_is_the_case_already_is_not_waited_for() {
    for kind in 1..=4 {
        let mut machine = Bare::running(&[wait(kind, 5), sap(1)]);
        machine.happened[usize::from(kind) - 1] = true;
        assert_eq!(machine.trace(2), [0, 1]);
    }
}

#[test]
fn a_timeout_goes_on_and_sets_eto_until_cle() {
    for kind in 1..=4 {
        let program = [
            wait(kind, 3),
            jc(ETO, 3),
            stop(),
            wait(kind, 0),
            jc(ETO, 6),
            stop(),
            cle(1),
            jc(ETO, 9),
            sap(8),
        ];
        let mut machine = Bare::running(&program);
        assert_eq!(machine.ticks_at(0), 31, "30 units, and JC in the step that ends it");
        assert_eq!(machine.vm.address(), 3, "type {kind}");
        // An event that comes leaves the flag of the one that did not.
        machine.happened = [true; 4];
        assert_eq!(machine.trace(5), [3, 4, 6, 7, 8]);
        assert!(!machine.vm.has_error(ErrorFlag::Timeout));
    }
}

/// The event that comes with the timeout came in time.
#[test]
fn an_event_at_the_last_moment_counts() {
    let mut machine = Bare::running(&[wait(POS, 1), sap(1)]);
    machine.step();
    machine.now = 10;
    machine.happened[0] = true;
    assert_eq!(machine.step(), Stepped::Executed { address: 1 });
    assert!(!machine.vm.has_error(ErrorFlag::Timeout));
}

#[test]
fn an_interrupted_wait_goes_on_with_what_was_left() {
    for (kind, timeout) in [(TICKS, 10), (POS, 10)] {
        for begins_at in [0, 1, 37, 99] {
            let mut machine = Bare::running(&[vect(0, 20), ei(0), ei(255), wait(kind, timeout), sap(1)]);
            machine.memory[20] = wait(TICKS, 4).to_bytes();
            machine.memory[21] = reti().to_bytes();
            machine.trace(3);
            machine.step();
            machine.now = begins_at;
            machine.vm.raise(0);
            machine.tick();
            while machine.vm.is_in_interrupt() {
                machine.tick();
            }
            assert_eq!((machine.vm.address(), machine.now - 1), (3, begins_at + 40), "back in the WAIT");
            let resumed = machine.now - 1;
            while machine.log.is_empty() {
                machine.tick();
            }
            let left = machine.now - 1 - resumed;
            assert_eq!(left, 100 - begins_at, "type {kind}, interrupted at {begins_at}");
            assert_eq!(machine.vm.has_error(ErrorFlag::Timeout), kind == POS);
        }
    }
}

#[test]
fn an_event_during_the_interrupt_routine_ends_the_wait_after_it() {
    let mut machine = Bare::running(&[vect(0, 20), ei(0), ei(255), wait(POS, 0), sap(1)]);
    machine.memory[20] = sap(7).to_bytes();
    machine.memory[21] = reti().to_bytes();
    machine.trace(3);
    machine.step();
    machine.vm.raise(0);
    machine.step();
    machine.happened[0] = true;
    assert_eq!(machine.trace(2), [21, 4]);
}

/// An interrupt at the end of a WAIT does not lose the WAIT's end.
#[test]
fn an_interrupt_at_the_last_moment_comes_first() {
    let mut machine = Bare::running(&[vect(0, 20), ei(0), ei(255), wait(POS, 1), sap(1)]);
    machine.memory[20] = reti().to_bytes();
    machine.trace(3);
    machine.step();
    machine.now = 10;
    machine.vm.raise(0);
    assert_eq!(machine.trace(2), [20, 4]);
    assert!(machine.vm.has_error(ErrorFlag::Timeout));
}

/// 130: a WAIT is one instruction, however long it takes.
#[test]
fn a_wait_is_one_single_step() {
    let mut machine = Bare::running(&[wait(TICKS, 5), sap(1)]);
    machine.vm.single_step();
    for _ in 0..50 {
        assert_eq!(machine.tick(), Stepped::Waiting);
        assert_eq!((machine.vm.mode(), machine.vm.is_active()), (Mode::Step, true));
    }
    assert_eq!(machine.tick(), Stepped::Executed { address: 0 });
    assert_eq!((machine.vm.address(), machine.vm.is_active(), machine.log.len()), (1, false, 0));
    assert_eq!(machine.tick(), Stepped::Idle);
    machine.vm.single_step();
    assert_eq!(machine.tick(), Stepped::Executed { address: 1 });
}

/// What the firmware asks in order to know whether anything can happen before a deadline.
#[test]
fn a_waiting_program_says_so() {
    let mut machine = Bare::running(&[wait(TICKS, 5), wait(POS, 0)]);
    assert_eq!(machine.vm.waits(), None);
    machine.step();
    assert_eq!(machine.vm.waits(), Some((None, Some(50))));
    machine.vm.stop();
    assert_eq!(machine.vm.waits(), None);
    machine.vm.resume();
    machine.now = 50;
    machine.step();
    assert_eq!(machine.vm.waits(), Some((Some(tmcl_vm::WaitEvent::PositionReached), None)));
}
