//! An RS485 bus in this process, with the modules of a bench on it. Waiting lets virtual time pass.
#![allow(clippy::disallowed_types, reason = "a link and those who look on share the bench")]

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tmcl_link::{Link, LinkError};
use virtual_bench::config::Interface;
use virtual_bench::{Bench, BenchConfig, ModuleKind, PortId, Wiring};

/// A bench that a link and those who look on share.
#[derive(Clone, Debug)]
pub(crate) struct SharedBench(Arc<Mutex<Bench>>);

impl SharedBench {
    /// Modules of these kinds with the addresses 1, 2 …, as delivered.
    pub(crate) fn with(kinds: &[ModuleKind]) -> Self {
        let [first, ..] = kinds else { panic!("a bus needs a module") };
        let mut config = BenchConfig::default_for(*first);
        config.bus.interface = Some(Interface::Rs485);
        config.modules.clear();
        for (kind, address) in kinds.iter().zip(1..) {
            let mut modules = BenchConfig::default_for(*kind).modules;
            for module in &mut modules {
                module.name = format!("m{address}");
                module.address = Some(address);
            }
            config.modules.extend(modules);
        }
        let mut bench = Bench::new(&config);
        bench.wire(line(), Wiring::Rs485 { baud: None });
        Self(Arc::new(Mutex::new(bench)))
    }

    /// The bench, now.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Bench> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Virtual time since it was made.
    pub(crate) fn now(&self) -> Duration {
        Duration::from_nanos(self.lock().time_ns())
    }

    /// A link to the bus.
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

/// The port of every module that is on the bus.
fn line() -> PortId {
    let [port, ..] = PortId::ALL;
    port
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

impl BusLink {
    fn collect(&mut self) {
        let mut bytes = Vec::new();
        self.bench.lock().take(line(), &mut bytes);
        self.arrived.extend(bytes);
    }
}

impl Link for BusLink {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let mut heard = Vec::new();
        // Bytes take no time on a bus without a rate, which takes them all.
        self.bench.lock().converse(line(), bytes, &mut heard);
        self.arrived.extend(heard);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        self.collect();
        if self.arrived.is_empty() {
            let mut bench = self.bench.lock();
            let until_ns = bench.time_ns().saturating_add(nanoseconds(timeout));
            bench.advance_observed(until_ns, &mut |bench| !bench.has_answer(line()));
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

    fn has_own_time(&self) -> bool {
        true
    }
}
