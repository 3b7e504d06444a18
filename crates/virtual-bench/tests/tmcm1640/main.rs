//! The TMCM-1640, for brushless motors.

#[path = "../common/mod.rs"]
mod common;

mod commutation;
mod feed_forward;
mod hardware;
mod parameters;
mod position;
mod program;
mod protection;
mod switches;
mod torque;
mod tuning;
mod velocity;
