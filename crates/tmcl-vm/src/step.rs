//! One instruction.

use tmcl_tables::{Command, Status};
use tmcl_wire::Request;

use crate::flags::ErrorFlag;
use crate::halt::Halt;
use crate::interrupts::{ALL, Context};
use crate::machine::Machine;
use crate::vm::{Mode, Vm};
use crate::wait::{Wait, WaitEvent};

/// What a step came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stepped {
    /// No program is active.
    Idle,
    /// A WAIT goes on.
    Waiting,
    /// The instruction at this address was executed.
    Executed {
        /// Where it stands.
        address: u16,
    },
    /// The instruction at this address failed and was skipped.
    Refused {
        /// Where it stands.
        address: u16,
        /// Why.
        status: Status,
    },
    /// The [`Halt`] wants to look before the instruction at this address, which was not executed. A WAIT may have ended just
    /// before it, or an interrupt routine begun with it.
    Halted {
        /// Where it stands.
        address: u16,
    },
}

/// Where the program goes on after an instruction.
enum Flow {
    Next,
    Jump(u16),
    /// The instruction is not over.
    Hold,
    Stop,
}

type Executed = Result<Flow, Status>;

/// Executes one instruction of the machine's program, if it is active: begins an interrupt routine that is due, goes on
/// waiting, or executes the instruction at the program counter.
///
/// An instruction that the module refuses is skipped (decision). Bounded work.
pub fn step<M: Machine>(machine: &mut M, halt: &mut impl Halt<M>) -> Stepped {
    if !machine.vm().is_active() {
        return Stepped::Idle;
    }
    let now = machine.now();
    begin_interrupt(machine.vm_mut(), now);
    if let Some(wait) = machine.vm().wait {
        let Some(over) = end_wait(machine, wait, now) else { return Stepped::Waiting };
        // A WAIT is a step of its own; otherwise what follows it is executed the instant it ends.
        if !machine.vm().is_active() {
            return over;
        }
    }
    let address = machine.vm().address;
    let Some(instruction) = machine.fetch(address) else {
        machine.vm_mut().stop();
        return Stepped::Idle;
    };
    if halt.before(machine, address) {
        return Stepped::Halted { address };
    }
    let executed = execute(machine, &Request::from_bytes(instruction), now);
    finish(machine.vm_mut(), address, &executed)
}

#[inline]
fn begin_interrupt(vm: &mut Vm, now: u64) {
    if let Some(vector) = vm.interrupts.take_due() {
        let wait = vm.wait.take().map(|wait| wait.map_deadline(|deadline| deadline.saturating_sub(now)));
        vm.interrupts.context = Some(Context { address: vm.address, registers: vm.registers, wait });
        vm.address = vector;
    }
}

/// Ends a WAIT whose time has come; None while it goes on.
fn end_wait<M: Machine>(machine: &mut M, wait: Wait, now: u64) -> Option<Stepped> {
    let happened = wait.event.is_some_and(|event| machine.has_happened(event));
    let expired = wait.deadline.is_some_and(|deadline| now >= deadline);
    if !happened && !expired {
        return None;
    }
    let vm = machine.vm_mut();
    if !happened && wait.event.is_some() {
        vm.set_error(ErrorFlag::Timeout);
    }
    vm.wait = None;
    Some(finish(vm, vm.address, &Ok(Flow::Next)))
}

#[inline]
fn finish(vm: &mut Vm, address: u16, executed: &Executed) -> Stepped {
    match executed {
        Ok(Flow::Jump(target)) => vm.address = *target,
        Ok(Flow::Hold) => return Stepped::Waiting,
        Ok(Flow::Stop) => vm.stop(),
        Ok(Flow::Next) | Err(_) => vm.address = address.saturating_add(1),
    }
    if vm.mode == Mode::Step {
        vm.steps = false;
    }
    match executed {
        Err(status) => Stepped::Refused { address, status: *status },
        Ok(_) => Stepped::Executed { address },
    }
}

/// Flow control and registers are the interpreter's; all the rest is the module's.
fn execute<M: Machine>(machine: &mut M, request: &Request, now: u64) -> Executed {
    let &Request { command, kind, motor, value } = request;
    let known = Command::try_from(command).ok().filter(|_| machine.has_command(command));
    // The module knows why it refuses what no program on it may hold.
    let Some(known) = known else { return machine.execute(request).map(|_| Flow::Next) };
    let vm = machine.vm_mut();
    match known {
        Command::Calculate => done(vm.registers.calculate(kind, value)),
        Command::CalculateX => done(vm.registers.calculate_x(kind)),
        Command::Compare => {
            vm.registers.compare(value);
            Ok(Flow::Next)
        }
        Command::Jump => jump(machine, value),
        Command::JumpConditional => match condition(vm, kind) {
            None => Err(Status::WrongType),
            Some(false) => Ok(Flow::Next),
            Some(true) => jump(machine, value),
        },
        Command::CallSubroutine => call(machine, value),
        // Ignored when the stack is empty (TMCM-1311 §5.7.21).
        Command::ReturnFromSubroutine => Ok(vm.stack.pop().map_or(Flow::Next, Flow::Jump)),
        Command::Stop => Ok(Flow::Stop),
        Command::Wait => wait(machine, kind, motor, value, now),
        Command::ClearErrorFlags => clear_error_flags(vm, kind),
        Command::SetInterruptVector => set_vector(machine, kind, value),
        Command::EnableInterrupt => enable(machine, kind, true),
        Command::DisableInterrupt => enable(machine, kind, false),
        Command::ReturnFromInterrupt => Ok(return_from_interrupt(vm, now)),
        _ => {
            let answer = machine.execute(request)?;
            if reads(known, kind, motor) {
                machine.vm_mut().registers.load(answer);
            }
            Ok(Flow::Next)
        }
    }
}

/// Whether a command's answer goes to the accumulator (TMCM-1311 §5.5).
fn reads(command: Command, kind: u8, motor: u8) -> bool {
    match command {
        Command::GetAxisParameter | Command::GetGlobalParameter | Command::GetInput => true,
        // With motor 255 it copies from EEPROM to RAM.
        Command::GetCoordinate => motor != 255,
        // STATUS.
        Command::ReferenceSearch => kind == 2,
        _ => false,
    }
}

fn done(calculated: Option<()>) -> Executed {
    calculated.map(|()| Flow::Next).ok_or(Status::WrongType)
}

fn condition(vm: &Vm, kind: u8) -> Option<bool> {
    vm.registers.holds(kind).or_else(|| Some(vm.has_error(ErrorFlag::from_condition(kind)?)))
}

/// An address of the program memory.
fn target<M: Machine>(machine: &M, value: i32) -> Result<u16, Status> {
    let address = u16::try_from(value).map_err(|_| Status::InvalidValue)?;
    if machine.fetch(address).is_some() { Ok(address) } else { Err(Status::InvalidValue) }
}

fn jump<M: Machine>(machine: &M, value: i32) -> Executed {
    target(machine, value).map(Flow::Jump)
}

/// Ignored when the stack is full (TMCM-1311 §5.7.20).
fn call<M: Machine>(machine: &mut M, value: i32) -> Executed {
    let address = target(machine, value)?;
    let vm = machine.vm_mut();
    let back = vm.address.saturating_add(1);
    Ok(if vm.stack.push(back) { Flow::Jump(address) } else { Flow::Next })
}

fn wait<M: Machine>(machine: &mut M, kind: u8, motor: u8, value: i32, now: u64) -> Executed {
    let event = match kind {
        0 => None,
        1 => Some(WaitEvent::PositionReached),
        2 => Some(WaitEvent::ReferenceSwitch),
        3 => Some(WaitEvent::LimitSwitch),
        4 => Some(WaitEvent::ReferenceSearch),
        _ => return Err(Status::WrongType),
    };
    if event.is_some() && !machine.has_motor(motor) {
        return Err(Status::InvalidValue);
    }
    let ticks = match (event, value) {
        (None, -1) => machine.vm().registers.accumulator,
        _ => value,
    };
    // No or negative ticks: no time to wait, or no timeout.
    let ticks = u64::try_from(ticks).unwrap_or(0);
    let deadline =
        (event.is_none() || ticks > 0).then(|| now.saturating_add(ticks.saturating_mul(M::WAIT_TICK)));
    let wait = Wait { event, deadline };
    let over = event.map_or(ticks == 0, |event| machine.has_happened(event));
    if over {
        return Ok(Flow::Next);
    }
    machine.vm_mut().wait = Some(wait);
    Ok(Flow::Hold)
}

fn clear_error_flags(vm: &mut Vm, kind: u8) -> Executed {
    match kind {
        0 => vm.errors.clear_all(),
        _ => vm.errors.clear(ErrorFlag::from_cle(kind).ok_or(Status::WrongType)?),
    }
    Ok(Flow::Next)
}

fn set_vector<M: Machine>(machine: &mut M, number: u8, value: i32) -> Executed {
    if !machine.has_interrupt(number) {
        return Err(Status::WrongType);
    }
    let address = target(machine, value)?;
    machine.vm_mut().interrupts.set_vector(number, address);
    Ok(Flow::Next)
}

fn enable<M: Machine>(machine: &mut M, number: u8, on: bool) -> Executed {
    if number != ALL && !machine.has_interrupt(number) {
        return Err(Status::WrongType);
    }
    machine.vm_mut().interrupts.enable(number, on);
    Ok(Flow::Next)
}

/// Ignored outside an interrupt routine. The stack is not restored, nor are the error flags, which stay until CLE.
fn return_from_interrupt(vm: &mut Vm, now: u64) -> Flow {
    let Some(context) = vm.interrupts.context.take() else { return Flow::Next };
    vm.registers = context.registers;
    vm.wait = context.wait.map(|wait| wait.map_deadline(|left| now.saturating_add(left)));
    Flow::Jump(context.address)
}
