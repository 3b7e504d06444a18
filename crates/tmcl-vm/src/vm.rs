//! The state of a program, and how a host starts and stops it.

use crate::flags::{ErrorFlag, ErrorFlags};
use crate::interrupts::Interrupts;
use crate::registers::Registers;
use crate::stack::Stack;
use crate::wait::{Wait, WaitEvent};

/// What global parameter 128 and command 135 tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// 0: stopped.
    #[default]
    Stop,
    /// 1: running.
    Run,
    /// 2: executed step by step.
    Step,
    /// 3: reset.
    Reset,
}

impl Mode {
    /// The number a host reads.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }
}

/// A program's state; as it is after power-on by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Vm {
    /// Accumulator, X register, last comparison.
    pub registers: Registers,
    pub(crate) mode: Mode,
    /// In step mode: whether an instruction is still to be executed.
    pub(crate) steps: bool,
    pub(crate) address: u16,
    pub(crate) errors: ErrorFlags,
    pub(crate) stack: Stack,
    pub(crate) interrupts: Interrupts,
    pub(crate) wait: Option<Wait>,
}

impl Vm {
    /// 129, type 1, and auto start: runs from an address. Calls, a WAIT and an interrupt routine that were under way are
    /// over, and all interrupts are disabled; A, X and the flags stay.
    pub fn run_from(&mut self, address: u16) {
        *self = Self {
            registers: self.registers,
            errors: self.errors,
            mode: Mode::Run,
            address,
            ..Self::default()
        };
    }

    /// 129, type 0: goes on from where it stands, with everything as it was.
    pub fn resume(&mut self) {
        self.mode = Mode::Run;
    }

    /// 128, and the instruction STOP.
    pub fn stop(&mut self) {
        self.mode = Mode::Stop;
    }

    /// 130: executes one instruction at the next [`crate::step()`]; a WAIT is one, however long it takes.
    pub fn single_step(&mut self) {
        self.mode = Mode::Step;
        self.steps = true;
    }

    /// 131: stops, and clears program counter, stack, A, X, flags and interrupts.
    pub fn reset(&mut self) {
        *self = Self { mode: Mode::Reset, ..Self::default() };
    }

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The address of the instruction that is executed, or will be next.
    #[must_use]
    pub fn address(&self) -> u16 {
        self.address
    }

    /// Where RSUB will go on, the innermost call last.
    #[must_use]
    pub fn calls(&self) -> &[u16] {
        self.stack.as_slice()
    }

    /// Whether an interrupt routine runs.
    #[must_use]
    pub fn is_in_interrupt(&self) -> bool {
        self.interrupts.context.is_some()
    }

    /// Whether [`crate::step()`] has something to do.
    #[must_use]
    #[inline]
    pub fn is_active(&self) -> bool {
        match self.mode {
            Mode::Run => true,
            Mode::Step => self.steps,
            Mode::Stop | Mode::Reset => false,
        }
    }

    /// What a WAIT waits for, and until when: None unless the program does nothing but wait.
    #[must_use]
    pub fn waits(&self) -> Option<(Option<WaitEvent>, Option<u64>)> {
        let wait = self.wait.filter(|_| self.is_active() && !self.interrupts.is_due())?;
        Some((wait.event, wait.deadline))
    }

    /// Sets an error flag, until CLE clears it.
    pub fn set_error(&mut self, flag: ErrorFlag) {
        self.errors.set(flag);
    }

    /// Whether an error flag is set.
    #[must_use]
    pub fn has_error(&self, flag: ErrorFlag) -> bool {
        self.errors.contains(flag)
    }

    /// The event of an interrupt happened; it is served when its turn comes, if it is enabled.
    pub fn raise(&mut self, interrupt: u8) {
        self.interrupts.raise(interrupt);
    }

    /// The interrupts whose events matter, a bit each: none while no program is active.
    #[must_use]
    pub fn enabled_interrupts(&self) -> u64 {
        if self.is_active() { self.interrupts.enabled() } else { 0 }
    }
}
