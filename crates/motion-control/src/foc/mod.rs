//! Field-oriented control of a brushless motor, in parts (TMCM-1640 §7).
//!
//! Electrical angles are `u16`, 65 536 to a turn, counted from phase U's axis, rising with rotation to the right. Vectors are
//! amplitude-invariant: their length is the peak of the phase quantity. Voltages are in 1/32 767 of the largest phase
//! voltage that sinusoidal drive has, 1/√3 of the supply.
//!
//! - [`angle`]: sine and cosine.
//! - [`hall`]: the rotor's angle and position from three hall sensors.
//! - [`pi`]: the regulator of currents and velocity.
//! - [`positioning`]: how fast to go for a distance.
//! - [`speed`]: how fast the shaft turns, in rpm.
//! - [`svpwm`]: the duty cycles that make a voltage.
//! - [`transform`]: currents and voltages as the stator and as the rotor sees them.
//! - [`velocity_ramp`]: a velocity that rises and falls by an acceleration.
//!
//! This module must never know parameter numbers, nor when its parts are called.

pub mod angle;
pub mod hall;
pub mod pi;
pub mod positioning;
pub mod speed;
pub mod svpwm;
pub mod transform;
pub mod velocity_ramp;
