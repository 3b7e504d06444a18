//! Closed-loop operation of a stepper with an encoder (TMCM-1311 §8), in pieces that know nothing of each other.
//!
//! - [`current_scale`]: how much of the current the position error calls for.
//! - [`tachometer`]: the speed an encoder's counter shows.
//! - [`torque_ramp`]: the current of torque mode on its way to its target.
//!
//! Each is plain data that is ticked once in a control period.

pub mod current_scale;
pub mod tachometer;
pub mod torque_ramp;
