//! What clients and other modules see of a TMCM-1311: its parameters, settings, statuses and memory, and modules on a bus.

#[path = "../common/mod.rs"]
mod common;

mod accumulator_and_ports;
mod bus_addresses;
mod bus_can;
mod bus_rest;
mod bus_timing;
mod coordinates;
mod datagrams;
mod eeprom_cuts;
mod eeprom_survives;
mod events_and_wires;
mod manual_examples;
mod parameters;
mod settings;
mod statuses;
