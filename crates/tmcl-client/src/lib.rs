//! The host's side of TMCL: commands, parameters and programs of a module behind a [`Link`](tmcl_link::Link).
//!
//! - [`Client::request`] sends one command and finds its reply, through noise, lost bytes and replies to somebody else.
//!   [`Client::last_exchange`] shows what went over the line.
//! - [`open`] finds a way to a module by its address; over a CAN bus, [`CanStream`] carries what a client says in frames.
//! - [`Client::probe`] asks who is at an address of a bus.
//! - The typed calls on [`Client`] read and write parameters and coordinates, move the motor, and switch ports.
//! - [`Client::download`] and its neighbours store, read back, run, step and watch stand-alone programs.
//!
//! What may be sent again when no reply came, and what must not, is in the tables: a lost reply to "move by 1000" does not
//! move twice.
//!
//! This crate must never know a clock, a socket or a file: time is a duration that the link lets pass.

mod answer;
mod any_link;
mod can;
mod client;
mod control;
mod coordinates;
mod describe;
mod download;
mod error;
mod exchange;
#[cfg(test)]
mod fake;
mod finder;
mod io;
mod motion;
mod open;
mod parameters;
mod probe;
mod repeat;
mod version;

pub use any_link::{AnyLink, Parties};
pub use can::{CanIds, CanStream};
pub use client::{Client, Settings};
pub use control::{ProgramMode, ProgramStatus};
pub use describe::Described;
pub use error::{ClientError, Heard};
pub use exchange::Exchange;
pub use open::{OpenOptions, open, open_link};
pub use probe::Presence;
pub use version::FirmwareVersion;

/// The motor byte: the modules that the tables know have one axis (TMCM-1311 §5.7.1).
const MOTOR: u8 = 0;
