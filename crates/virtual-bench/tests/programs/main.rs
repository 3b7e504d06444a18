//! TMCL programs in a TMCM-1311 on its own.

#[path = "../common/mod.rs"]
mod common;

mod interrupts;
mod io;
mod memory;
mod protection;
mod refusals;
mod reproducible;
mod stops;
mod timers;
mod waits;
