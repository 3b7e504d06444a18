//! Virtual modules: their firmware, unchanged, on modelled hardware, in virtual time.
//!
//! A [`Bench`] is a pure function of its inputs. Time is an integer argument; the same bytes at the same instants give the
//! same replies, bit for bit, on every machine. All state is plain `Clone` data: a snapshot is a clone.
//!
//! This crate must never know sockets, threads, files or wall-clock time.

mod bench;
mod bus;
pub mod config;
pub mod eeprom;
pub mod expect;
mod kind;
mod module;
mod parts;
mod presets;
mod probe;
mod refusals;
mod step_bench;
mod trace;

pub use bench::{Bench, ModuleId};
pub use bench_hardware::Physical;
pub use bus::Wiring;
pub use config::BenchConfig;
pub use eeprom::Eeprom;
pub use kind::{ModuleKind, UnknownModuleKind};
pub use module_firmware::{
    ERASED, Instruction, PORTS, PortId, ProgramMode, RecordKey, Storage, StorageError, Vm,
};
pub use probe::{Probe, ProbeError, Quantity};
pub use refusals::RefusedInstruction;
pub use tmcl_wire::can;
pub use trace::{Column, Trace};

/// A control period.
pub const TICK_NS: u64 = 50_000;
