//! What a program runs on.

use tmcl_tables::Status;
use tmcl_wire::Request;

use crate::vm::Vm;
use crate::wait::WaitEvent;

/// A module, as far as the interpreter is concerned.
pub trait Machine {
    /// How long a tick of WAIT is, in the units of [`Machine::now`] (10 ms, TMCM-1311 §5.7.22).
    const WAIT_TICK: u64;

    /// The program's state.
    fn vm(&self) -> &Vm;
    /// The program's state, to change it.
    fn vm_mut(&mut self) -> &mut Vm;
    /// The time.
    fn now(&self) -> u64;
    /// The instruction at an address; None beyond the program memory.
    fn fetch(&self, address: u16) -> Option<[u8; 7]>;
    /// Whether a program on this module may hold the command.
    fn has_command(&self, number: u8) -> bool;
    /// Whether the module has the interrupt.
    fn has_interrupt(&self, number: u8) -> bool;
    /// Whether the motor is one of the module's.
    fn has_motor(&self, motor: u8) -> bool;
    /// Whether what a WAIT waits for is the case.
    fn has_happened(&self, event: WaitEvent) -> bool;
    /// Executes a command that is not flow control, as if a host had sent it, and returns the value of the reply. What
    /// [`Machine::has_command`] denies comes here too, to be refused.
    ///
    /// # Errors
    /// The status that refuses it.
    fn execute(&mut self, request: &Request) -> Result<i32, Status>;
}
