//! A link to a module on a bench in this process. Waiting for an answer lets virtual time pass.

use std::borrow::BorrowMut;
use std::collections::VecDeque;
use std::time::Duration;

use tmcl_link::{Link, LinkError};
use tmcl_tables::GlobalParameter;
use virtual_bench::{Bench, ModuleId, PortId, Probe, Quantity, TICK_NS};

/// An address of a module, which its EEPROM may hold. A module without the parameter has the factory's for good.
pub(crate) fn address(bench: &Bench, module: ModuleId, parameter: GlobalParameter) -> u8 {
    let (bank, number) = parameter.address();
    let is_there = bench.spec(module).is_some_and(|spec| spec.global_parameter(bank, number).is_some());
    match parameter {
        _ if is_there => bench.read(Probe { module, quantity: Quantity::Global(bank, number) }) as u8,
        GlobalParameter::HostAddress => 2,
        _ => 1,
    }
}

/// The first port of a module on a bench that is owned or borrowed.
pub(crate) struct VirtualLink<B> {
    bench: B,
    module: ModuleId,
    arrived: VecDeque<u8>,
}

impl<B: BorrowMut<Bench>> VirtualLink<B> {
    pub(crate) fn new(bench: B, module: ModuleId) -> Self {
        Self { bench, module, arrived: VecDeque::new() }
    }

    fn port() -> PortId {
        let [port, ..] = PortId::ALL;
        port
    }

    /// Takes what the module has to say by now.
    fn collect(&mut self) {
        let mut bytes = Vec::new();
        self.bench.borrow_mut().transmit(self.module, Self::port(), &mut bytes);
        self.arrived.extend(bytes);
    }
}

impl<B: BorrowMut<Bench> + Send> Link for VirtualLink<B> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let answer = self.bench.borrow_mut().exchange(self.module, Self::port(), bytes);
        self.arrived.extend(answer);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        let timeout_ns = u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX);
        let until_ns = self.bench.borrow().time_ns().saturating_add(timeout_ns);
        self.collect();
        while self.arrived.is_empty() && self.bench.borrow().time_ns().saturating_add(TICK_NS) <= until_ns {
            self.bench.borrow_mut().advance_by(TICK_NS);
            self.collect();
        }
        let length = buffer.len().min(self.arrived.len());
        for (slot, byte) in buffer.iter_mut().zip(self.arrived.drain(..length)) {
            *slot = byte;
        }
        Ok(length)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.collect();
        self.arrived.clear();
        Ok(())
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        let duration_ns = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
        self.bench.borrow_mut().advance_by(duration_ns);
        self.collect();
        Ok(())
    }

    fn has_own_time(&self) -> bool {
        true
    }
}
