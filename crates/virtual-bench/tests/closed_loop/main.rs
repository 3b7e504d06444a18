//! A TMCM-1311 in closed loop.

#[path = "../common/mod.rs"]
mod common;

mod current;
mod detection;
mod encoder;
mod endings;
mod homing;
mod init;
mod position;
mod standstill;
mod step_dir;
mod torque;
mod velocity;
