//! Motors on shafts, with everything around them: loads, encoders, hall sensors, switches, supply, heat.
//!
//! - [`stepper`] and [`pmsm`]: the motors, as differential equations with their terminal voltages held over a step.
//! - [`mechanics`]: inertia, friction, hard stops; [`load`]: torque over position and time.
//! - [`encoder`], [`hall`], [`switch`]: what sensors make of the shaft.
//! - [`supply`], [`heat`]: the bus voltage and the temperatures.
//! - [`presets`]: motors by their maker's name.
//!
//! SI units throughout, in the names. This crate must never know registers, microsteps per second, parameters, or what
//! firmware exists; and never control: a sign error made on both sides would cancel out. Mathematics goes through `libm`,
//! so that a run is the same bit for bit on every machine.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub mod angle;
pub mod encoder;
pub mod energy;
pub mod hall;
pub mod heat;
pub mod load;
pub mod mechanics;
pub mod pmsm;
pub mod presets;
mod rk4;
pub mod stepper;
pub mod supply;
pub mod switch;
mod terminal;

pub use terminal::Terminal;
