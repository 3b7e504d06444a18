//! The interpreter of stand-alone TMCL programs (TMCM-1311 §4.3, §5.3 to §5.7, §11; TMCM-1640 §4).
//!
//! - [`Vm`] is all state a program has besides its memory: registers, flags, stack, interrupts, what it waits for. It is
//!   plain `Clone` data.
//! - [`Machine`] is what a program runs on: it fetches instructions and executes every command that is not the
//!   interpreter's own business.
//! - [`step()`] executes one instruction. Its work is bounded, whatever the program holds.
//! - [`Halt`] is where a debugger comes in, as an argument: looking at a program never changes what it does.
//!
//! This crate must never know which module it runs in, nor what time a tick takes: it speaks to a [`Machine`]. It allocates
//! nothing and never panics, whatever the program memory holds.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod flags;
mod halt;
mod interrupts;
mod machine;
mod registers;
mod stack;
mod step;
mod vm;
mod wait;

pub use flags::ErrorFlag;
pub use halt::{Breakpoints, Halt, NeverHalt};
pub use machine::Machine;
pub use registers::Registers;
pub use stack::DEPTH;
pub use step::{Stepped, step};
pub use vm::{Mode, Vm};
pub use wait::WaitEvent;
