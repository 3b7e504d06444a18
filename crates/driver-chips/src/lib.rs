//! Motor driver chips as silicon: registers and pins in, voltages across the windings and status out.
//!
//! - [`stepper`]: what the stepper drivers share.
//! - [`tmc262`]: the two-phase stepper driver of the TMCM-1311.
//! - [`tmc5160`]: the two-phase stepper driver of the TMCM-1076, with its step and direction input.
//! - [`tmc603`]: the three-phase pre-driver of the TMCM-1640, with its bridge.
//!
//! A chip is averaged over a chopper period: what its regulator and its diagnostics do is here, the switching itself is not.
//! This crate must never know TMCL, firmware, parameter numbers, or control laws outside the silicon: a sign error made on
//! both sides would cancel out. What goes beyond a datasheet's text is marked "(decision)".
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub mod stepper;
pub mod tmc262;
pub mod tmc5160;
pub mod tmc603;
