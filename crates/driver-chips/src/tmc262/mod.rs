//! The TMC262: two bridges with current regulation, a microstep sequencer, stallGuard2, coolStep and diagnostics.
//!
//! Whoever wires the chip hands it its [`Registers`] and its [`Pins`] every control period and gets what its bridges do to
//! the windings. It never learns where the rotor is: like the silicon it sees currents and back-EMF only.

mod chip;
mod registers;
mod sequencer;
#[cfg(test)]
mod tests;

pub use crate::stepper::{CoilFault, CoolStep, Pins};
pub use chip::{Board, Status, Tmc262};
pub use registers::{Coils, Registers};
