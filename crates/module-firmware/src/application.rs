//! The stand-alone program: how a host starts and stops it (commands 128 to 135), and how it runs beside direct mode.

use tmcl_tables::{Command, Status};
use tmcl_vm::{Halt, NeverHalt, Stepped, Vm};
use tmcl_wire::Request;

use crate::axis::Axis;
use crate::dispatch::{Executed, Outcome};
use crate::firmware::Firmware;
use crate::jobs::Job;
use crate::port::PortId;
use crate::program_memory::ProgramMemory;

/// An instruction of the program that the module refused. It was skipped (decision).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Where it stands.
    pub address: u16,
    /// Why.
    pub status: Status,
}

/// The program is about to execute an instruction that a debugger wants to look at. It was not executed, and no time has
/// passed; but a WAIT may have ended just before it, or an interrupt routine begun with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halted {
    /// Where it stands.
    pub address: u16,
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
        let happened = event.is_some_and(|event| self.axis.has_happened(event));
        !happened && self.program_quiet_ticks() > 0 && !self.has_unnoticed_edge()
    }

    pub(crate) fn program_quiet_ticks(&self) -> u64 {
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
        let last = self.programs.length().saturating_sub(1);
        ProgramStatus {
            mode: self.vm.mode().number(),
            // A program that ran past the end stands at the last instruction for those who ask.
            address: self.vm.address().min(last),
            downloading: self.download.is_some(),
        }
    }

    /// Commands 128 to 135, which only a host sends; none where it is another.
    pub(crate) fn control_application(
        &mut self,
        command: Command,
        request: &Request,
        port: PortId,
    ) -> Option<Executed> {
        let &Request { kind, value, .. } = request;
        let done = match command {
            Command::ApplicationStop => {
                self.vm.stop();
                Ok(())
            }
            Command::ApplicationRun => self.run_application(kind, value),
            Command::ApplicationStep => {
                self.step_application();
                Ok(())
            }
            Command::ApplicationReset => {
                self.vm.reset();
                Ok(())
            }
            Command::DownloadStart => self.start_download(port, value),
            Command::DownloadEnd => {
                self.end_download(port);
                Ok(())
            }
            Command::ReadProgramMemory => return Some(self.read_program(value)),
            Command::ApplicationStatus => return Some(Ok(self.application_status())),
            _ => return None,
        };
        Some(done.map(|()| Outcome::Done(value)))
    }

    /// 129: type 0 goes on, type 1 starts at an address.
    fn run_application(&mut self, kind: u8, value: i32) -> Result<(), Status> {
        match kind {
            0 => self.vm.resume(),
            _ => {
                let address = self.program_address(value)?;
                self.vm.run_from(address);
            }
        }
        Ok(())
    }

    /// 130: the instruction is executed before the reply.
    fn step_application(&mut self) {
        self.vm.single_step();
        // Nothing halts here.
        let _ = self.run_program(&mut NeverHalt);
    }

    /// 135.
    fn application_status(&self) -> Outcome {
        let ProgramStatus { mode, address, .. } = self.program_status();
        let [high, low] = address.to_be_bytes();
        Outcome::Done(i32::from_be_bytes([mode, 0, high, low]))
    }

    /// An address in the program memory.
    pub(crate) fn program_address(&self, value: i32) -> Result<u16, Status> {
        let address = u16::try_from(value).map_err(|_| Status::InvalidValue)?;
        self.programs.get(address).map(|_| address).ok_or(Status::InvalidValue)
    }
}
