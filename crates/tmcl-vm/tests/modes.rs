//! Start, stop, single step, reset (decisions 1.6, 1.8, 2a.19), and looking on without changing anything.

mod common;

use common::*;
use tmcl_vm::{Breakpoints, ErrorFlag, Mode, Stepped, Vm};

#[test]
fn after_power_on_nothing_runs() {
    let mut machine = Bare::running(&[sap(1)]);
    machine.vm = Vm::default();
    assert_eq!((machine.vm.mode(), machine.vm.address(), machine.a()), (Mode::Stop, 0, 0));
    assert_eq!(machine.step(), Stepped::Idle);
    assert_eq!(machine.log, []);
}

#[test]
fn modes_have_the_numbers_that_hosts_read() {
    let numbers = [Mode::Stop, Mode::Run, Mode::Step, Mode::Reset].map(Mode::number);
    assert_eq!(numbers, [0, 1, 2, 3]);
}

#[test]
fn stop_holds_and_resume_goes_on() {
    let mut machine = Bare::running(&[sap(0), sap(1), sap(2)]);
    machine.trace(1);
    machine.vm.stop();
    assert_eq!((machine.step(), machine.vm.mode(), machine.vm.address()), (Stepped::Idle, Mode::Stop, 1));
    machine.vm.resume();
    assert_eq!(machine.vm.mode(), Mode::Run);
    assert_eq!(machine.trace(2), [1, 2]);
}

/// RUN keeps A, X and flags (decisions 2a.19); calls and waits are over.
#[test]
fn run_from_starts_anew_but_keeps_the_registers() {
    let mut machine = Bare::running(&[load(5), calcx(LOAD), load(-3), comp(9), csub(5)]);
    machine.memory[5] = wait(TICKS, 100).to_bytes();
    machine.memory[40] = sap(1).to_bytes();
    machine.trace(5);
    machine.step();
    machine.vm.set_error(ErrorFlag::Timeout);
    let registers = machine.vm.registers;
    machine.vm.run_from(40);
    assert_eq!((machine.vm.registers, machine.vm.calls()), (registers, &[][..]));
    assert!(machine.vm.has_error(ErrorFlag::Timeout));
    assert_eq!(machine.trace(1), [40]);
}

#[test]
fn reset_clears_all() {
    let mut machine = Bare::running(&[load(5), calcx(LOAD), comp(9), vect(0, 7), ei(0), ei(255), csub(10)]);
    machine.memory[10] = wait(TICKS, 100).to_bytes();
    machine.trace(7);
    machine.step();
    machine.vm.set_error(ErrorFlag::Shutdown);
    machine.vm.raise(0);
    machine.vm.reset();
    assert_eq!((machine.vm.mode(), machine.vm.is_active()), (Mode::Reset, false));
    let mut as_new = Vm::default();
    as_new.reset();
    assert_eq!(machine.vm, as_new);
    assert_eq!(machine.step(), Stepped::Idle);
    machine.vm.resume();
    assert_eq!(machine.trace(1), [0]);
}

#[test]
fn a_single_step_executes_one_instruction() {
    let mut machine = Bare::running(&[sap(0), ja(5)]);
    machine.memory[5] = ja(100).to_bytes();
    for (address, next) in [(0, 1), (1, 5)] {
        machine.vm.single_step();
        assert_eq!((machine.vm.mode(), machine.vm.is_active()), (Mode::Step, true));
        assert_eq!(machine.step(), Stepped::Executed { address });
        assert_eq!(
            (machine.vm.mode(), machine.vm.is_active(), machine.vm.address()),
            (Mode::Step, false, next)
        );
        assert_eq!(machine.step(), Stepped::Idle);
    }
    machine.vm.single_step();
    assert!(matches!(machine.step(), Stepped::Refused { address: 5, .. }), "what is refused was a step too");
    assert_eq!(machine.step(), Stepped::Idle);
    machine.vm.single_step();
    assert_eq!(machine.step(), Stepped::Executed { address: 6 });
    assert_eq!(machine.vm.mode(), Mode::Stop, "it was STOP");
    assert_eq!(machine.log, [sap(0)]);
}

#[test]
fn steps_and_runs_alternate() {
    let mut machine = Bare::running(&[sap(0), sap(1), sap(2), sap(3)]);
    machine.trace(1);
    machine.vm.single_step();
    assert_eq!(machine.trace(1), [1]);
    machine.vm.resume();
    assert_eq!(machine.trace(2), [2, 3]);
}

#[test]
fn a_step_may_lead_into_an_interrupt_routine() {
    let mut machine = Bare::running(&[vect(0, 20), ei(0), ei(255), sap(1)]);
    machine.memory[20] = reti().to_bytes();
    machine.trace(3);
    machine.vm.stop();
    machine.vm.raise(0);
    for (address, next) in [(20, 3), (3, 4)] {
        machine.vm.single_step();
        assert_eq!(machine.step(), Stepped::Executed { address });
        assert_eq!(machine.vm.address(), next);
    }
}

#[test]
fn a_halt_executes_nothing_and_going_on_executes_it() {
    let mut breakpoints = Breakpoints::new();
    assert!(breakpoints.set(1, true));
    let mut machine = Bare::running(&[sap(0), sap(1), sap(2)]);
    assert_eq!(machine.step_unless(&mut breakpoints), Stepped::Executed { address: 0 });
    let before = machine.clone();
    for _ in 0..3 {
        assert_eq!(machine.step_unless(&mut breakpoints), Stepped::Halted { address: 1 });
        assert_eq!(machine, before);
    }
    assert_eq!(machine.trace(2), [1, 2]);
}

#[test]
fn breakpoints_are_set_and_removed_one_by_one() {
    let mut breakpoints = Breakpoints::new();
    for address in [0, 63, 64, 2047] {
        assert!(!breakpoints.contains(address));
        assert!(breakpoints.set(address, true));
        assert!(breakpoints.contains(address));
    }
    assert!(breakpoints.set(63, false));
    let left: Vec<u16> = (0..2048).filter(|address| breakpoints.contains(*address)).collect();
    assert_eq!(left, [0, 64, 2047]);
    assert!(!breakpoints.set(2048, true) && !breakpoints.contains(2048));
}

/// A watch condition sees the machine and the address.
#[test]
fn any_condition_can_halt() {
    let mut machine = Bare::running(&[load(0), calc(ADD, 1), ja(1)]);
    let mut watch = |machine: &Bare, _: u16| machine.a() == 5;
    let mut steps = 0;
    let halted = loop {
        match machine.step_unless(&mut watch) {
            Stepped::Halted { address } => break address,
            _ => steps += 1,
        }
    };
    assert_eq!((halted, machine.a(), steps), (2, 5, 10));
}
