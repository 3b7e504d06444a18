//! The TMC603: a pre-driver with the six MOSFETs of a three-phase bridge, its protection, and the NTC beside it.
//!
//! Whoever wires the chip hands it its [`Gates`] and its [`Pins`] every control period and gets what the bridge does to the
//! motor. It never learns where the rotor is: like the silicon it sees currents and voltages only.
//!
//! Averaged over a PWM period: dead times and switching losses are not here. What the chip guards against is on the first
//! page of its datasheet: overcurrent and shorts to ground, by the voltage across the transistors that are on, and too
//! little supply. That page gives 9 V to 50 V and up to 30 A; thresholds beyond that are marked "(chosen)".

mod chip;
mod ntc;
#[cfg(test)]
mod tests;

pub use chip::{Board, Gates, Phase, Pins, Tmc603};
pub use ntc::ntc_reading;
