//! Modules on an emulated chip, and sessions that are played against them and against virtual modules alike.
//!
//! A [`Session`] says which bytes arrive at which port at which tick, and which leave. [`play()`] gives its inputs to a
//! [`Target`] and returns the session as it went there: a [`VirtualTarget`] in this process, or an [`EmulatedChip`], which is
//! QEMU with an image of `firmware/mps2-an385`.
//!
//! A [`DeskModule`] is such a chip whose time is the clock's, and a [`Bridge`] brings its UART to TCP ports and pseudo
//! terminals; the program `emulated-module` is both.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "an edge: it runs QEMU and waits for it"
)]

mod bridge;
mod chip;
mod desk;
mod memory;
mod play;
mod session;
mod virtual_target;

pub use bridge::Bridge;
pub use chip::{Counting, EmulatedChip, EmulatorError, Measured, QEMU, Stack};
pub use desk::{DeskError, DeskModule};
pub use memory::MemoryError;
pub use play::{Target, play};
pub use session::{Act, Line, Session, SessionError};
pub use virtual_target::VirtualTarget;
