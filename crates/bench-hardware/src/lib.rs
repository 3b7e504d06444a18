//! What is around a module's firmware on the bench: driver chip, motor, load, encoder, hall sensors, switches, supply, heat.
//!
//! One kind of [`Hardware`] per module, built of [`parts`] and changed by [`Setting`]s while it runs. It takes what the
//! firmware commands and gives what the sensors say, a control period at a time, and knows the truth ([`Physical`]).
//!
//! The same hardware is on the bench of a virtual module and around an emulated chip; so it allocates nothing, never panics,
//! and must never know bench files, bytes, or where it runs.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bench_parts;
mod bldc_bench;
mod hardware;
pub mod parts;
mod pulse_source;
mod setting;
mod stepper_bench;
mod stepper_stage;

pub use bench_parts::{PERIOD_S, with_level};
pub use bldc_bench::BldcBench;
pub use hardware::{Hardware, MotorFamily, Physical, PulseLevels, Surroundings};
pub use pulse_source::PulseSource;
pub use setting::{Coil, Contact, EncoderLine, HallSensor, Phase, Power, Setting, SwitchName};
pub use stepper_bench::StepperBench;
pub use stepper_stage::StepperStage;

/// A control period.
pub const TICK_NS: u64 = 50_000;
