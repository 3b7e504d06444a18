//! Fixed-point motion control, as it runs every 50 µs on a microcontroller without floating point.
//!
//! - [`closed_loop`]: the laws by which an encoder keeps a stepper in step.
//! - [`foc`]: field-oriented control of a brushless motor.
//! - [`homing`]: the reference search, a state machine over switches and positions.
//! - [`i2t`]: the thermal load of a winding, watched over a sliding window.
//! - [`ramp`]: the trapezoidal ramp generator of positioning and velocity mode.
//! - [`sine`]: the current vector that points a stepper's field somewhere.
//! - [`tachometer`]: how fast a counter counts.
//!
//! This crate must never know parameter numbers, TMCL, or floating point; and never physics: a sign error made on both
//! sides would cancel out. Nothing here allocates or panics; each call does a bounded amount of work.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::float_arithmetic)]

pub mod closed_loop;
mod division;
pub mod foc;
pub mod homing;
pub mod i2t;
pub mod ramp;
pub mod sine;
pub mod tachometer;

/// Control periods in a second: one every 50 µs.
pub const TICKS_PER_SECOND: i64 = 20_000;
