//! A TMCM-1311 in open loop: moves, currents, loads and faults, judged by the rotor and the coils.

#[path = "../common/mod.rs"]
mod common;

mod coolstep;
mod current;
mod current_accuracy;
mod encoder_null;
mod expect;
mod faults_and_sensors;
mod homing;
mod i2t;
mod in_flight;
mod moves;
mod positions;
mod power_and_heat;
mod reproducible;
mod stall;
mod stallguard;
mod step_dir;
mod stop_switches;
