//! A virtual module as the target of a session.

use std::convert::Infallible;

use virtual_bench::config::{BenchConfig, Power, Setting};
use virtual_bench::{Bench, ModuleId, ModuleKind, PortId, TICK_NS};

use crate::play::Target;
use crate::session::Act;

/// A module on a bench of its own.
pub struct VirtualTarget {
    bench: Bench,
}

const MODULE: ModuleId = ModuleId(0);

impl VirtualTarget {
    /// A new module of this kind, as it stands on the default bench.
    #[must_use]
    pub fn new(kind: ModuleKind) -> Self {
        Self { bench: Bench::new(&BenchConfig::default_for(kind)) }
    }

    fn collect(&mut self, left: &mut Vec<(u64, u8, Vec<u8>)>) {
        let tick = self.tick();
        for (number, port) in (0..).zip(PortId::ALL) {
            let mut bytes = Vec::new();
            self.bench.transmit(MODULE, port, &mut bytes);
            if !bytes.is_empty() {
                left.push((tick, number, bytes));
            }
        }
    }

    fn has_output(bench: &Bench) -> bool {
        PortId::ALL.into_iter().any(|port| bench.has_output(MODULE, port))
    }
}

impl Target for VirtualTarget {
    type Error = Infallible;

    fn tick(&self) -> u64 {
        self.bench.time_ns() / TICK_NS
    }

    fn run_to(&mut self, tick: u64, left: &mut Vec<(u64, u8, Vec<u8>)>) -> Result<(), Infallible> {
        while self.tick() < tick {
            self.bench.advance_observed(tick * TICK_NS, &mut |bench| !Self::has_output(bench));
            self.collect(left);
        }
        Ok(())
    }

    fn act(&mut self, act: &Act, left: &mut Vec<(u64, u8, Vec<u8>)>) -> Result<(), Infallible> {
        match act {
            Act::Arrive(number, bytes) => {
                if let Some(port) = PortId::ALL.get(usize::from(*number)) {
                    let out = self.bench.exchange(MODULE, *port, bytes);
                    if !out.is_empty() {
                        left.push((self.tick(), *number, out));
                    }
                    self.collect(left);
                }
            }
            Act::PowerCycle => self.bench.apply(MODULE, Setting::Power(Power::Cycle)),
            Act::Load(torque_nm) => self.bench.apply(MODULE, Setting::LoadTorqueNm(*torque_nm)),
            Act::Input(number, high) => {
                self.bench.apply(MODULE, Setting::Input { number: *number, high: *high });
            }
            Act::Leave(..) | Act::End => {}
        }
        Ok(())
    }
}
