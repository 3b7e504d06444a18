//! The firmware as the machine that its stand-alone program runs on.

use tmcl_tables::Status;
use tmcl_vm::{Machine, Vm, WaitEvent};
use tmcl_wire::Request;

use crate::TICKS_PER_MS;
use crate::application::ProgramJob;
use crate::axis::Axis;
use crate::dispatch::Outcome;
use crate::firmware::Firmware;
use crate::program_memory::{Instruction, ProgramMemory};

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
        match self.execute_instruction(request)? {
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
            | Outcome::AsciiMode(_)
            | Outcome::Silence => Err(Status::NotAvailable),
        }
    }
}
