//! A module whose program is executed where it is stored, where the RAM has no room for a mirror of it.

use core::fmt::Debug;
use core::marker::PhantomData;

use module_firmware::{Axis, Events, Motion, ProgramMemory, Refused};
use tmcl_tables::{Interrupt, ModuleSpec};
use tmcl_vm::WaitEvent;

/// The axis `A` with `P` as the memory of its program, and else unchanged.
#[derive(Clone, Debug, Default)]
pub struct InPlace<A, P>(A, PhantomData<P>);

impl<A: Axis, P: ProgramMemory + Debug> Axis for InPlace<A, P> {
    const SPEC: &'static ModuleSpec = A::SPEC;
    type Parameter = A::Parameter;
    type Port = A::Port;
    type Sensed = A::Sensed;
    type Drive = A::Drive;
    type Programs = P;

    #[inline]
    fn tick(&mut self, sensed: &Self::Sensed, events: &mut Events) -> Self::Drive {
        self.0.tick(sensed, events)
    }

    fn is_idle(&self, sensed: &Self::Sensed) -> bool {
        self.0.is_idle(sensed)
    }

    fn quiet_ticks(&self) -> u64 {
        self.0.quiet_ticks()
    }

    fn skip(&mut self, ticks: u64) {
        self.0.skip(ticks);
    }

    fn get(&self, parameter: Self::Parameter) -> i32 {
        self.0.get(parameter)
    }

    fn set(&mut self, parameter: Self::Parameter, value: i32) -> Result<(), Refused> {
        self.0.set(parameter, value)
    }

    fn motion(&mut self, motion: Motion) -> Result<(), Refused> {
        self.0.motion(motion)
    }

    fn start_search(&mut self) -> Result<(), Refused> {
        self.0.start_search()
    }

    fn stop_search(&mut self) {
        self.0.stop_search();
    }

    fn search_state(&self) -> i32 {
        self.0.search_state()
    }

    fn actual_position(&self) -> i32 {
        self.0.actual_position()
    }

    fn is_position_reached(&self) -> bool {
        self.0.is_position_reached()
    }

    fn has_happened(&self, event: WaitEvent) -> bool {
        self.0.has_happened(event)
    }

    fn level(&self, interrupt: Interrupt) -> bool {
        self.0.level(interrupt)
    }

    fn set_end_switch_polarity(&mut self, reversed: bool) {
        self.0.set_end_switch_polarity(reversed);
    }

    fn port(bank: u8, number: u8) -> Option<Self::Port> {
        A::port(bank, number)
    }

    fn read_port(&self, port: Self::Port) -> i32 {
        self.0.read_port(port)
    }

    fn write_port(&mut self, port: Self::Port, high: bool) {
        self.0.write_port(port, high);
    }
}
