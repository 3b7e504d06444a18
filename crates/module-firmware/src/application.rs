//! The stand-alone program: how a host loads, starts and stops it (commands 128 to 135), and how it runs beside direct mode.

use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_vm::{Halt, Machine, NeverHalt, Stepped, Vm, WaitEvent};
use tmcl_wire::Request;

use crate::TICKS_PER_MS;
use crate::axis::Axis;
use crate::dispatch::{Origin, Outcome};
use crate::firmware::Firmware;
use crate::jobs::Job;
use crate::port::PortId;
use crate::program_memory::{Instruction, ProgramMemory};

/// An instruction of the program that the module refused. It was skipped (decision).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Where it stands.
    pub address: u16,
    /// Why.
    pub status: Status,
}

/// The program is about to execute an instruction that a debugger wants to look at; nothing has happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halted {
    /// Where it stands.
    pub address: u16,
}

/// A download under way. It belongs to the port it was begun at; others go on talking to the module as ever.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Download {
    pub(crate) port: PortId,
    next: u16,
}

/// A storage job of the program, which goes on once it is done.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProgramJob {
    pub(crate) address: u16,
    pub(crate) job: Job,
}

/// What a host reads about the program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProgramStatus {
    pub(crate) mode: u8,
    pub(crate) address: u16,
    pub(crate) downloading: bool,
}

impl<A: Axis> Firmware<A> {
    /// Lets the program execute what is its share of a control period, or what a halt left of it.
    pub(crate) fn run_program(&mut self, halt: &mut impl Halt<Self>) -> Result<(), Halted> {
        if self.vm.is_active() {
            self.notice_timers();
            self.notice_edges();
            self.run_share(halt)?;
        }
        self.executed = 0;
        Ok(())
    }

    /// A storage job ends the share, and so does a refusal: there is room for one until somebody takes it.
    fn run_share(&mut self, halt: &mut impl Halt<Self>) -> Result<(), Halted> {
        while self.executed < self.instructions_per_tick && self.program_job.is_none() {
            match tmcl_vm::step(self, halt) {
                Stepped::Executed { .. } => self.executed += 1,
                Stepped::Refused { address, status } => {
                    self.executed = self.instructions_per_tick;
                    self.refusal = Some(Refusal { address, status });
                }
                Stepped::Halted { address } => return Err(Halted { address }),
                Stepped::Idle | Stepped::Waiting => break,
            }
            // A command may change a level, which the axis may change back before the next control period.
            self.notice_edges();
        }
        Ok(())
    }

    /// Whether another control period would change nothing about the program, unless its surroundings change.
    pub(crate) fn program_rests(&self) -> bool {
        if self.program_job.is_some() {
            return false;
        }
        if !self.vm.is_active() {
            return true;
        }
        let Some((event, _)) = self.vm.waits() else { return false };
        let happened = event.is_some_and(|event| self.has_happened(event));
        !happened && self.quiet_ticks() > 0 && !self.has_unnoticed_edge()
    }

    /// Control periods until the program goes on by itself, while [`Firmware::is_idle`].
    #[must_use]
    pub fn quiet_ticks(&self) -> u64 {
        if !self.vm.is_active() {
            return u64::MAX;
        }
        let Some((_, deadline)) = self.vm.waits() else { return 0 };
        let deadline = deadline.unwrap_or(u64::MAX);
        let timer = self.sources.next_timer_tick(self.vm.enabled_interrupts());
        deadline.min(timer).saturating_sub(self.ticks)
    }

    /// The program's registers, flags and stack, for those who look on.
    #[must_use]
    pub fn program(&self) -> &Vm {
        &self.vm
    }

    /// The last instruction that was refused since the last call, if one was.
    pub fn take_refusal(&mut self) -> Option<Refusal> {
        self.refusal.take()
    }

    pub(crate) fn program_status(&self) -> ProgramStatus {
        let last = self.programs.instructions().len().saturating_sub(1);
        ProgramStatus {
            mode: self.vm.mode().number(),
            // A program that ran past the end stands at the last instruction for those who ask.
            address: self.vm.address().min(u16::try_from(last).unwrap_or(u16::MAX)),
            downloading: self.download.is_some(),
        }
    }

    /// 129: type 0 goes on, type 1 starts at an address.
    pub(crate) fn run_application(&mut self, kind: u8, value: i32) -> Result<Outcome, Status> {
        match kind {
            0 => self.vm.resume(),
            _ => {
                let address = self.program_address(value)?;
                self.vm.run_from(address);
            }
        }
        Ok(Outcome::Done(value))
    }

    /// 130: the instruction is executed before the reply.
    pub(crate) fn step_application(&mut self, value: i32) -> Outcome {
        self.vm.single_step();
        // Nothing halts here.
        let _ = self.run_program(&mut NeverHalt);
        Outcome::Done(value)
    }

    /// 132: what comes next over this port is stored from `value` on. A running program is stopped.
    pub(crate) fn start_download(&mut self, port: PortId, value: i32) -> Result<Outcome, Status> {
        if self.is_overwriting_protected() {
            return Err(Status::NotAvailable);
        }
        let next = self.program_address(value)?;
        self.vm.stop();
        self.download = Some(Download { port, next });
        Ok(Outcome::Done(value))
    }

    /// 134.
    pub(crate) fn read_program(&self, value: i32) -> Result<Outcome, Status> {
        if self.code_protection() & 1 != 0 {
            return Err(Status::NotAvailable);
        }
        let address = u16::try_from(value).ok();
        let instruction =
            address.and_then(|address| self.programs.get(address)).ok_or(Status::InvalidValue)?;
        Ok(Outcome::Instruction(instruction))
    }

    /// 135.
    pub(crate) fn application_status(&self) -> Outcome {
        let ProgramStatus { mode, address, .. } = self.program_status();
        let [high, low] = address.to_be_bytes();
        Outcome::Done(i32::from_be_bytes([mode, 0, high, low]))
    }

    /// While a port downloads, everything but commands 128 to 139 is stored instead of executed.
    pub(crate) fn store_instruction(
        &mut self,
        request: &Request,
        origin: Origin,
    ) -> Option<Result<Outcome, Status>> {
        let Origin::Host(port) = origin else { return None };
        let protected = self.is_overwriting_protected();
        let download = self.download.as_mut().filter(|download| download.port == port)?;
        if (Command::ApplicationStop.number()..=Command::EnterAsciiMode.number()).contains(&request.command) {
            return None;
        }
        // Another port may have set the protection since the download began.
        if protected {
            return Some(Err(Status::NotAvailable));
        }
        let (address, instruction) = (download.next, request.to_bytes());
        if self.programs.get(address).is_none() {
            return Some(Err(Status::InvalidValue));
        }
        download.next += 1;
        Some(Ok(Outcome::Loaded(Job::WriteInstruction(address, instruction), request.value)))
    }

    /// Global parameter 81: bit 0 protects against reading back, bit 1 against overwriting (TMCM-1311 §10.1).
    fn code_protection(&self) -> i32 {
        self.globals.setting(GlobalParameter::CodeProtection)
    }

    fn is_overwriting_protected(&self) -> bool {
        self.code_protection() & 2 != 0
    }

    fn program_address(&self, value: i32) -> Result<u16, Status> {
        let address = u16::try_from(value).map_err(|_| Status::InvalidValue)?;
        self.programs.get(address).map(|_| address).ok_or(Status::InvalidValue)
    }
}

impl<A: Axis> Machine for Firmware<A> {
    const WAIT_TICK: u64 = 10 * TICKS_PER_MS;

    #[inline]
    fn vm(&self) -> &Vm {
        &self.vm
    }

    #[inline]
    fn vm_mut(&mut self) -> &mut Vm {
        &mut self.vm
    }

    #[inline]
    fn now(&self) -> u64 {
        self.ticks
    }

    #[inline]
    fn fetch(&self, address: u16) -> Option<Instruction> {
        self.programs.get(address)
    }

    fn has_command(&self, number: u8) -> bool {
        A::SPEC.command(number).is_some_and(|command| command.modes.program)
    }

    fn has_interrupt(&self, number: u8) -> bool {
        A::SPEC.interrupt(number).is_some()
    }

    fn has_motor(&self, motor: u8) -> bool {
        motor == 0
    }

    fn has_happened(&self, event: WaitEvent) -> bool {
        self.axis.has_happened(event)
    }

    fn execute(&mut self, request: &Request) -> Result<i32, Status> {
        match Firmware::execute(self, request, Origin::Program)? {
            Outcome::Done(value) => Ok(value),
            Outcome::Job(job, value) => {
                self.program_job = Some(ProgramJob { address: self.vm.address(), job });
                Ok(value)
            }
            // Only a host gets these.
            Outcome::SilentJob(_)
            | Outcome::Loaded(..)
            | Outcome::Instruction(_)
            | Outcome::VersionString
            | Outcome::AwaitPosition
            | Outcome::Silence => Err(Status::NotAvailable),
        }
    }
}
