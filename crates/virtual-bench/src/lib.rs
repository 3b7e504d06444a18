//! Virtual modules: their firmware, unchanged, on modelled hardware, in virtual time.
//!
//! A [`Bench`] is a pure function of its inputs. Time is an integer argument; the same bytes at the same instants give the
//! same replies, bit for bit, on every machine. All state is plain `Clone` data: a snapshot is a clone.
//!
//! This crate must never know sockets, threads, files or wall-clock time.

mod bench;
mod eeprom;
mod field_follower;
mod hardware;
mod module;

pub use bench::{Bench, ModuleId, ModuleKind, ModuleSetup, UnknownModuleKind};
pub use eeprom::Eeprom;
pub use field_follower::FieldFollower;
pub use hardware::{Hardware, Physical};
pub use module_firmware::{PORTS, PortId};

/// A control period.
pub const TICK_NS: u64 = 50_000;
