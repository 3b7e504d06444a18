//! The host's side of TMCL: commands, parameters and programs of a module behind a [`Link`](tmcl_link::Link).
//!
//! - [`Client::request`] sends one command and finds its reply, through noise, lost bytes and replies to somebody else.
//! - The typed calls on [`Client`] read and write parameters and coordinates, move the motor, and switch ports.
//! - [`Client::download`] and its neighbours store, read back, run, step and watch stand-alone programs.
//!
//! What may be sent again when no reply came, and what must not, is in the tables: a lost reply to "move by 1000" does not
//! move twice.
//!
//! This crate must never know a clock, a socket or a file: time is a duration that the link lets pass.

mod answer;
mod client;
mod control;
mod coordinates;
mod describe;
mod download;
mod error;
#[cfg(test)]
mod fake;
mod finder;
mod io;
mod motion;
mod parameters;
mod repeat;
mod version;

pub use client::{Client, Settings};
pub use control::{ProgramMode, ProgramStatus};
pub use describe::Described;
pub use error::{ClientError, Heard};
pub use version::FirmwareVersion;

/// The motor byte: the modules that the tables know have one axis (TMCM-1311 §5.7.1).
const MOTOR: u8 = 0;
