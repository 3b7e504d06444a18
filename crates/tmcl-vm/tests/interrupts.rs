//! Interrupts (TMCM-1311 §5.6, §5.7.32 to §5.7.35; decisions 3.8, 2a.17).

mod common;

use common::*;
use tmcl_tables::{Command, Status};
use tmcl_vm::{ErrorFlag, Stepped};
use tmcl_wire::Request;

/// A loop at address 10, after `setup`, and routines at 20, 30, 40 that note their address and return.
fn machine(setup: &[Request]) -> Bare {
    let mut machine = Bare::running(setup);
    machine.memory[setup.len()] = ja(10).to_bytes();
    machine.memory[10] = ja(10).to_bytes();
    for address in [20, 30, 40] {
        machine.memory[address] = sap(address as i32).to_bytes();
        machine.memory[address + 1] = reti().to_bytes();
    }
    machine.trace(setup.len() + 1);
    machine
}

/// Interrupts 0, 3 and 46, whose routines are at 20, 30 and 40.
fn three() -> Bare {
    machine(&[vect(0, 20), vect(3, 30), vect(46, 40), ei(0), ei(3), ei(46), ei(255)])
}

fn served(machine: &Bare) -> Vec<i32> {
    machine.log.iter().map(|request| request.value).collect()
}

#[test]
fn a_routine_is_called_and_returns() {
    let mut machine = three();
    machine.vm.raise(3);
    assert_eq!(machine.trace(4), [30, 31, 10, 10]);
    assert!(!machine.vm.is_in_interrupt());
}

#[test]
fn the_lower_the_number_the_sooner() {
    let mut machine = three();
    for interrupt in [46, 3, 0] {
        machine.vm.raise(interrupt);
    }
    assert_eq!(machine.trace(7), [20, 21, 30, 31, 40, 41, 10]);
}

/// No nesting: what happens in a routine, be it more urgent or the same, waits for its end, and is remembered once.
#[test]
fn there_is_no_nesting() {
    let mut machine = three();
    machine.vm.raise(3);
    assert_eq!(machine.trace(1), [30]);
    for interrupt in [46, 0, 0, 3, 3, 3] {
        machine.vm.raise(interrupt);
    }
    assert!(machine.vm.is_in_interrupt());
    assert_eq!(machine.trace(8), [31, 20, 21, 30, 31, 40, 41, 10]);
    assert_eq!(served(&machine), [30, 20, 30, 40]);
}

/// EI 255 within a routine does not open it to others.
#[test]
fn enabling_in_a_routine_does_not_nest_either() {
    let mut machine = three();
    machine.memory[30] = ei(255).to_bytes();
    machine.vm.raise(3);
    machine.trace(1);
    machine.vm.raise(0);
    assert_eq!(machine.trace(2), [31, 20]);
}

/// A, X and the comparison are restored; error flags, variables and the stack are not (decisions 3.8, 2a.17).
#[test]
fn the_context_is_saved_and_restored() {
    let mut machine = three();
    let routine = [load(-9), calcx(9), load(1), comp(5), csub(40), reti()];
    for (address, instruction) in (30..).zip(routine) {
        machine.memory[address] = instruction.to_bytes();
    }
    machine.memory[40] = reti().to_bytes();
    machine.vm.registers.accumulator = 11;
    machine.vm.registers.x = 22;
    machine.vm.registers.compare(11);
    let before = machine.vm.registers;
    machine.vm.raise(3);
    machine.trace(4);
    assert_ne!(machine.vm.registers, before);
    machine.vm.set_error(ErrorFlag::Deviation);
    assert_eq!(machine.trace(3), [34, 40, 10]);
    assert_eq!(machine.vm.registers, before);
    assert!(machine.vm.has_error(ErrorFlag::Deviation));
    assert_eq!(machine.vm.calls(), [35], "the stack is shared");
}

/// An interrupt between COMP and JC does not change which way JC goes.
#[test]
fn an_interrupt_between_comp_and_jc_does_not_matter() {
    let mut machine = three();
    machine.memory[10] = comp(0).to_bytes();
    machine.memory[11] = jc(EQ, 13).to_bytes();
    machine.memory[30] = load(99).to_bytes();
    machine.trace(1);
    machine.vm.raise(3);
    assert_eq!(machine.trace(3), [30, 31, 11]);
    assert_eq!(machine.vm.address(), 13);
}

#[test]
fn reti_outside_a_routine_is_ignored() {
    let mut machine = Bare::running(&[load(5), reti(), sap(1)]);
    assert_eq!(machine.trace(3), [0, 1, 2]);
    assert_eq!(machine.a(), 5);
}

#[test]
fn without_a_vector_nothing_happens() {
    let mut machine = machine(&[ei(3), ei(255)]);
    machine.vm.raise(3);
    assert_eq!(machine.trace(2), [10, 10]);
}

/// A vector outside the memory is refused, and the one before stays.
#[test]
fn a_vector_outside_memory_is_refused() {
    for target in [64, -1, 65_536 + 20] {
        let mut machine = machine(&[vect(3, 30), ei(3), ei(255)]);
        machine.memory[10] = vect(3, target).to_bytes();
        let refused = Stepped::Refused { address: 10, status: Status::InvalidValue };
        assert_eq!(machine.step(), refused, "VECT 3, {target}");
        machine.vm.raise(3);
        assert_eq!(machine.trace(1), [30]);
    }
}

#[test]
fn a_vector_may_change_any_time() {
    let mut machine = three();
    machine.memory[30] = vect(3, 40).to_bytes();
    machine.vm.raise(3);
    assert_eq!(machine.trace(2), [30, 31]);
    machine.vm.raise(3);
    assert_eq!(machine.trace(1), [40]);
}

#[test]
fn what_is_not_enabled_does_not_interrupt() {
    for setup in [
        &[vect(3, 30), ei(255)][..],
        &[vect(3, 30), ei(3)],
        &[vect(3, 30), ei(3), ei(255), di(3)],
        &[vect(3, 30), ei(3), ei(255), di(255)],
        &[vect(3, 30), vect(0, 20), ei(0), ei(255)],
    ] {
        let mut machine = machine(setup);
        machine.vm.raise(3);
        assert_eq!(machine.trace(3), [10, 10, 10], "{setup:?}");
    }
}

/// DI 255 switches all off as a whole: EI 255 brings back those that were enabled, and no others.
#[test]
fn di_255_keeps_who_is_enabled() {
    let mut machine = machine(&[vect(3, 30), vect(0, 20), ei(3), ei(255), di(255), ei(255)]);
    machine.vm.raise(0);
    assert_eq!(machine.trace(1), [10]);
    machine.vm.raise(3);
    assert_eq!(machine.trace(3), [30, 31, 10]);
}

#[test]
fn enabled_interrupts_are_told_while_a_program_is_active() {
    let mut machine = three();
    assert_eq!(machine.vm.enabled_interrupts(), 1 | 1 << 3 | 1 << 46);
    machine.vm.stop();
    assert_eq!(machine.vm.enabled_interrupts(), 0);
}

/// Reset and program start disable all (decisions 3.8).
#[test]
fn start_and_reset_disable_all() {
    for restart in [
        |vm: &mut tmcl_vm::Vm| vm.run_from(10),
        |vm: &mut tmcl_vm::Vm| {
            vm.reset();
            vm.resume();
        },
    ] {
        let mut machine = three();
        machine.vm.raise(3);
        machine.memory[0] = ja(10).to_bytes();
        restart(&mut machine.vm);
        machine.vm.raise(0);
        machine.trace(1);
        assert_eq!((machine.vm.enabled_interrupts(), machine.trace(2)), (0, vec![10, 10]));
    }
}

/// A program that is started anew in the middle of a routine is not in one any more.
#[test]
fn a_start_ends_the_routine() {
    let mut machine = three();
    machine.vm.raise(3);
    machine.trace(1);
    machine.vm.run_from(0);
    assert!(!machine.vm.is_in_interrupt());
    machine.trace(8);
    machine.vm.raise(0);
    assert_eq!(machine.trace(1), [20]);
}

/// Stopped in a routine and resumed, it goes on in it.
#[test]
fn stop_and_resume_in_a_routine() {
    let mut machine = three();
    machine.vm.raise(3);
    machine.trace(1);
    machine.vm.stop();
    assert_eq!(machine.step(), Stepped::Idle);
    machine.vm.resume();
    machine.vm.raise(0);
    assert_eq!(machine.trace(4), [31, 20, 21, 10]);
}

/// An instruction that is interrupted is executed once, whatever it is.
#[test]
fn nothing_is_executed_twice_or_not_at_all() {
    let mut machine = three();
    machine.memory[10] = sap(1).to_bytes();
    machine.memory[11] = op(Command::Calculate, ADD, 1).to_bytes();
    machine.memory[12] = ja(10).to_bytes();
    for round in 0..60 {
        if round % 7 == 0 {
            machine.vm.raise(46);
        }
        machine.trace(1);
    }
    let loops = machine.log.iter().filter(|request| request.value == 1).count();
    let notes = machine.log.iter().filter(|request| request.value == 40).count();
    assert_eq!(notes, 9);
    assert_eq!(usize::try_from(machine.a()).unwrap(), (60 - 2 * notes + 1) / 3);
    assert_eq!(loops, (60 - 2 * notes).div_ceil(3));
}
