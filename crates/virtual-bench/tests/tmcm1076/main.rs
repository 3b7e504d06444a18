//! The TMCM-1076, a driver that follows pulses.

#[path = "../common/mod.rs"]
mod common;

mod choppers;
mod examples;
mod parameters;
mod pulses;
