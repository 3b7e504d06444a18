//! Virtual TMCL modules on TCP ports, pseudo terminals and CAN, paced by the wall clock.
//!
//! A [`Server`] owns a bench. One thread paces it; each client has a thread that reads and one that writes what the module
//! says unasked. A command is answered by the thread that read it, at once: the bench sits behind a mutex that nobody holds
//! longer than a tenth of a millisecond.
//!
//! This crate must never know what a command means: bytes and frames go through.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "an edge: sockets, threads and the wall clock live here and in the command line only"
)]

mod can_bus;
mod connection;
mod pacer;
mod protocol;
#[cfg(unix)]
mod pty;
mod server;
mod shared;
#[cfg(unix)]
mod slcan;
pub mod state;
mod tcp;

pub use can_bus::CanError;
pub use pacer::Advance;
#[cfg(unix)]
pub use pty::{Pty, PtyError};
pub use server::{ListenError, Server, Settings};
pub use shared::Notice;
pub use state::State;
