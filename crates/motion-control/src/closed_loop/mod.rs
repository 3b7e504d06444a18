//! The closed loop of a stepper: where the rotor is, where the field shall stand, how large the current shall be (TMCM-1311 §8).
//!
//! All positions are in µsteps of 1/256 full step, and relative to the rotor: a lead is how far something is ahead of it.
//! So nothing overflows, however far the motor turns, and no coordinate of a user's matters here.
//!
//! - [`scale`]: encoder counts as µsteps, without drift.
//! - [`alignment`]: which count means which electrical angle.
//! - [`current_scale`]: as large a current as the position error needs.
//! - [`detection`]: how many counts the encoder has in a turn.
//! - [`leads`]: the torque block: how far ramp and field are ahead of the rotor.
//! - [`tachometer`]: how fast the rotor turns.
//! - [`torque_ramp`]: a current that rises and falls by a slope.
//! - [`weakening`]: how much further than 90° the field may be ahead at high speed.
//!
//! This module must never know parameter numbers, nor what the positions are called outside.

pub mod alignment;
pub mod current_scale;
pub mod detection;
pub mod leads;
pub mod scale;
pub mod tachometer;
pub mod torque_ramp;
pub mod weakening;
