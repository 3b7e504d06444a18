//! The TMC5160 as a step and direction driver: two bridges with current regulation (spreadCycle) or voltage PWM
//! (stealthChop), a microstep sequencer that interpolates, stallGuard2, coolStep and diagnostics.
//!
//! Whoever wires the chip hands it its [`Registers`], its [`Pins`] and the edges on its step input every control period and
//! gets what its bridges do to the windings. It never learns where the rotor is: like the silicon it sees currents and
//! back-EMF only. Its motion controller, its encoder input and dcStep are not modelled.

mod chip;
mod current;
mod registers;
mod sequencer;
mod status;
mod stealthchop;
#[cfg(test)]
mod tests;
mod velocity;

pub use crate::stepper::{CoilFault, CoolStep, Pins};
pub use chip::{Board, Inputs, Tmc5160};
pub use registers::{ChopConf, CoolConf, GConf, IHoldIRun, PwmConf, Registers};
pub use sequencer::{CLOCK_HZ, Edges, STANDSTILL_TSTEP};
pub use status::Status;
