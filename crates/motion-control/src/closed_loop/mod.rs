//! Closed-loop operation of a stepper with an encoder (TMCM-1311 §8), in pieces that know nothing of each other.
//!
//! - [`tachometer`]: the speed an encoder's counter shows.
//!
//! Each is plain data that is ticked once in a control period.

pub mod tachometer;
