//! A bus in this process: what is written goes to every module of a bench, and what they say comes back. Waiting lets
//! virtual time pass.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tmcl_link::{Link, LinkError};
use virtual_bench::{Bench, BenchConfig, ModuleKind, PortId};

/// A bench that a link and those who look on share.
#[derive(Clone, Debug)]
pub(crate) struct SharedBench(Arc<Mutex<Bench>>);

impl SharedBench {
    /// Modules of these kinds with the addresses 1, 2 …, as delivered.
    pub(crate) fn with(kinds: &[ModuleKind]) -> Self {
        let mut config = BenchConfig { modules: Vec::new(), wires: Vec::new(), events: Vec::new() };
        for (kind, address) in kinds.iter().zip(1..) {
            let mut modules = BenchConfig::default_for(*kind).modules;
            for module in &mut modules {
                module.name = format!("m{address}");
                module.address = Some(address);
            }
            config.modules.extend(modules);
        }
        Self(Arc::new(Mutex::new(Bench::new(&config))))
    }

    /// The bench, now.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Bench> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Virtual time since it was made.
    pub(crate) fn now(&self) -> Duration {
        Duration::from_nanos(self.lock().time_ns())
    }

    /// A link to the first port of all modules.
    pub(crate) fn link(&self) -> BusLink {
        BusLink { bench: self.clone(), arrived: VecDeque::new() }
    }
}

/// One end of the bus.
#[derive(Debug)]
pub(crate) struct BusLink {
    bench: SharedBench,
    arrived: VecDeque<u8>,
}

fn port() -> PortId {
    let [port, ..] = PortId::ALL;
    port
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

impl BusLink {
    fn collect(&mut self) {
        let mut bytes = Vec::new();
        let mut bench = self.bench.lock();
        for module in bench.modules() {
            bench.transmit(module, port(), &mut bytes);
        }
        drop(bench);
        self.arrived.extend(bytes);
    }
}

impl Link for BusLink {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let mut bench = self.bench.lock();
        for module in bench.modules() {
            self.arrived.extend(bench.exchange(module, port(), bytes));
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        self.collect();
        if self.arrived.is_empty() {
            let mut bench = self.bench.lock();
            let until_ns = bench.time_ns().saturating_add(nanoseconds(timeout));
            let is_silent = |bench: &Bench| !bench.modules().any(|module| bench.has_output(module, port()));
            bench.advance_observed(until_ns, &mut |bench| is_silent(bench));
            drop(bench);
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
        self.bench.lock().advance_by(nanoseconds(duration));
        self.collect();
        Ok(())
    }
}
