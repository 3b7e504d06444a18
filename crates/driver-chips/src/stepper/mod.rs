//! What the drivers of two-phase steppers have in common: the microstep table, current regulation, stallGuard2, coolStep,
//! what they watch on the coils, and what they see of their surroundings.
//!
//! Sections and flags are those of the datasheets of the TMC262 and the TMC5160, which name them alike.

pub(crate) mod chopper;
pub(crate) mod coil;
pub(crate) mod coolstep;
mod pins;
pub(crate) mod stallguard;
pub(crate) mod standstill;
pub(crate) mod table;
pub(crate) mod temperature;

pub use coolstep::CoolStep;
pub use pins::{CoilFault, Pins};
