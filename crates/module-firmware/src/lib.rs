//! The firmware of TMCL modules, as it runs on a Cortex-M3 (`firmware/mps2-an385`, docs/porting.md).
//!
//! A module is a pure state machine, [`Firmware`]: bytes go in with [`Firmware::receive`] and come out with
//! [`Firmware::transmit`]; every 50 µs [`Firmware::tick`] takes what the sensors say and returns what the power stage
//! shall do, and lets a stand-alone program execute an instruction; [`Firmware::background`] does what takes long, one EEPROM
//! record at a time. What differs between modules is an [`Axis`]; there is one dispatcher for all of them, and one way in for
//! every request.
//!
//! This crate must never know of simulation, files or wall-clock time. It allocates nothing and never panics. All state
//! is plain `Clone` data: a snapshot is a clone.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod application;
mod ascii;
mod axis;
mod coordinates;
mod dispatch;
mod download;
mod envelope;
mod events;
mod firmware;
mod globals;
mod heartbeat;
mod jobs;
mod line;
mod machine;
mod port;
mod power_on;
mod program_memory;
mod ring;
mod service;
mod storage;
pub mod tmcm_1076;
pub mod tmcm_1311;
pub mod tmcm_1640;
mod values;

pub use application::{Halted, Refusal};
pub use axis::{Axis, Motion, Refused};
pub use events::Events;
pub use firmware::Firmware;
pub use line::Line;
pub use port::{PORTS, PortId};
pub use program_memory::{ERASED, Instruction, ProgramMemory, Programs};
pub use storage::{RecordKey, Storage, StorageError};
pub use tmcl_vm::{Breakpoints, Halt, Mode as ProgramMode, NeverHalt, Vm};

/// Control periods in a second: one every 50 µs.
pub const TICKS_PER_SECOND: u64 = 20_000;

/// Control periods in a millisecond.
pub const TICKS_PER_MS: u64 = TICKS_PER_SECOND / 1000;
