//! A machine that is little more than memory, and the instructions to fill it with.
#![allow(dead_code, reason = "every test crate uses another part of it")]

use tmcl_tables::{Command, Status};
use tmcl_vm::{Halt, Machine, NeverHalt, Stepped, Vm, WaitEvent, step};
use tmcl_wire::Request;

/// Types of JC.
pub(crate) const ZE: u8 = 0;
pub(crate) const NZ: u8 = 1;
pub(crate) const EQ: u8 = 2;
pub(crate) const GT: u8 = 4;
pub(crate) const GE: u8 = 5;
pub(crate) const LT: u8 = 6;
pub(crate) const ETO: u8 = 8;

/// Types of CALC.
pub(crate) const ADD: u8 = 0;
pub(crate) const LOAD: u8 = 9;

/// Types of WAIT.
pub(crate) const TICKS: u8 = 0;
pub(crate) const POS: u8 = 1;

/// A command that no module has.
pub(crate) const UNKNOWN: u8 = 200;

/// A machine whose tick of WAIT is ten units of its time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bare {
    pub(crate) vm: Vm,
    pub(crate) memory: Vec<[u8; 7]>,
    pub(crate) now: u64,
    /// Whether what WAIT waits for, types 1 to 4, is the case.
    pub(crate) happened: [bool; 4],
    /// What was handed on to the module.
    pub(crate) log: Vec<Request>,
}

impl Machine for Bare {
    const WAIT_TICK: u64 = 10;

    fn vm(&self) -> &Vm {
        &self.vm
    }

    fn vm_mut(&mut self) -> &mut Vm {
        &mut self.vm
    }

    fn now(&self) -> u64 {
        self.now
    }

    fn fetch(&self, address: u16) -> Option<[u8; 7]> {
        self.memory.get(usize::from(address)).copied()
    }

    fn has_command(&self, number: u8) -> bool {
        Command::ALL.iter().any(|command| command.number() == number && number < 128)
    }

    fn has_interrupt(&self, number: u8) -> bool {
        matches!(number, 0..=3 | 15 | 21 | 27 | 28 | 39..=46)
    }

    fn has_motor(&self, motor: u8) -> bool {
        motor == 0
    }

    fn has_happened(&self, event: WaitEvent) -> bool {
        self.happened[match event {
            WaitEvent::PositionReached => 0,
            WaitEvent::ReferenceSwitch => 1,
            WaitEvent::LimitSwitch => 2,
            WaitEvent::ReferenceSearch => 3,
        }]
    }

    /// Answers with the value; a motor other than 0 is refused, and so is what a program cannot hold.
    fn execute(&mut self, request: &Request) -> Result<i32, Status> {
        match request.command {
            number if !self.has_command(number) && number >= 140 && number != 255 => {
                Err(Status::InvalidCommand)
            }
            number if !self.has_command(number) => Err(Status::NotAvailable),
            _ if request.motor == 7 => Err(Status::InvalidValue),
            _ => {
                self.log.push(*request);
                Ok(request.value)
            }
        }
    }
}

impl Bare {
    /// Runs a program from address 0; the memory behind it, 64 instructions in all, is STOP.
    pub(crate) fn running(program: &[Request]) -> Self {
        let mut memory = vec![stop().to_bytes(); 64];
        for (slot, instruction) in memory.iter_mut().zip(program) {
            *slot = instruction.to_bytes();
        }
        let mut vm = Vm::default();
        vm.run_from(0);
        Self { vm, memory, now: 0, happened: [false; 4], log: Vec::new() }
    }

    pub(crate) fn step(&mut self) -> Stepped {
        step(self, &mut NeverHalt)
    }

    pub(crate) fn step_unless(&mut self, halt: &mut impl Halt<Self>) -> Stepped {
        step(self, halt)
    }

    /// A step, and then a unit of time.
    pub(crate) fn tick(&mut self) -> Stepped {
        let stepped = self.step();
        self.now += 1;
        stepped
    }

    /// The addresses of the next `n` instructions; each step must execute one.
    #[track_caller]
    pub(crate) fn trace(&mut self, n: usize) -> Vec<u16> {
        let steps = (0..n).map(|_| match self.step() {
            Stepped::Executed { address } => address,
            other => panic!("{other:?} at {}", self.vm.address()),
        });
        steps.collect()
    }

    /// Ticks until the program has left `address`, at most 100 000.
    #[track_caller]
    pub(crate) fn ticks_at(&mut self, address: u16) -> u64 {
        assert_eq!(self.vm.address(), address);
        (0..100_000)
            .find(|_| {
                let here = self.vm.address() == address;
                if here {
                    self.tick();
                }
                !here
            })
            .expect("it stays there")
    }

    pub(crate) fn a(&self) -> i32 {
        self.vm.registers.accumulator
    }
}

pub(crate) fn op(command: Command, kind: u8, value: i32) -> Request {
    Request::new(command, kind, 0, value)
}

pub(crate) fn calc(operation: u8, value: i32) -> Request {
    op(Command::Calculate, operation, value)
}

pub(crate) fn load(value: i32) -> Request {
    calc(LOAD, value)
}

pub(crate) fn calcx(operation: u8) -> Request {
    op(Command::CalculateX, operation, 0)
}

pub(crate) fn comp(value: i32) -> Request {
    op(Command::Compare, 0, value)
}

pub(crate) fn jc(condition: u8, address: i32) -> Request {
    op(Command::JumpConditional, condition, address)
}

pub(crate) fn ja(address: i32) -> Request {
    op(Command::Jump, 0, address)
}

pub(crate) fn csub(address: i32) -> Request {
    op(Command::CallSubroutine, 0, address)
}

pub(crate) fn rsub() -> Request {
    op(Command::ReturnFromSubroutine, 0, 0)
}

pub(crate) fn wait(kind: u8, ticks: i32) -> Request {
    op(Command::Wait, kind, ticks)
}

pub(crate) fn stop() -> Request {
    op(Command::Stop, 0, 0)
}

pub(crate) fn cle(kind: u8) -> Request {
    op(Command::ClearErrorFlags, kind, 0)
}

pub(crate) fn vect(interrupt: u8, address: i32) -> Request {
    op(Command::SetInterruptVector, interrupt, address)
}

pub(crate) fn ei(interrupt: u8) -> Request {
    op(Command::EnableInterrupt, interrupt, 0)
}

pub(crate) fn di(interrupt: u8) -> Request {
    op(Command::DisableInterrupt, interrupt, 0)
}

pub(crate) fn reti() -> Request {
    op(Command::ReturnFromInterrupt, 0, 0)
}

/// Any instruction that the module answers with its value and that reads nothing.
pub(crate) fn sap(value: i32) -> Request {
    op(Command::SetAxisParameter, 4, value)
}

/// Reads its own value.
pub(crate) fn gap(value: i32) -> Request {
    op(Command::GetAxisParameter, 4, value)
}
