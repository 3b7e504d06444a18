//! The demonstration of a brushless motor: how well does the cascade hold the shaft where it shall be?

use std::time::Duration;

use serde::Serialize;
use tmcl_tables::tmcm_1640::AxisParameter;
use virtual_bench::config::ModuleConfig;
use virtual_bench::{BenchConfig, ModuleId};

use super::{Journey, MS, RAMP_S, Show, row, tell};
use crate::arguments::Demo;
use crate::exit::{Failure, Outcome};

/// The value of AP 159 that lets the encoder commutate.
const BY_ENCODER: f64 = 7.0;

/// Two thirds of what the default motor makes of its default current.
const LOAD_NM: f64 = -0.04;

/// Beyond the default of AP 244, while which the rotor is pulled to where the encoder's angle is known.
const INITIALIZATION_NS: u64 = 1100 * MS;

pub(super) fn run(config: &BenchConfig, module: &ModuleConfig, options: &Demo) -> Outcome {
    let journey = Journey {
        turns: options.turns.unwrap_or(10.0),
        rpm: options.rpm.unwrap_or(1000.0),
        load_nm: LOAD_NM,
    };
    let show = Show::new(config, options, journey)?;
    tell(module, options, show, |show| play(show, module, options), Summary::new, Summary::rows)
}

fn play(show: &mut Show, module: &ModuleConfig, options: &Demo) -> Result<[u64; 2], Failure> {
    let counts = f64::from(module.encoder.counts);
    if let Some(motor) = module.motor.brushless() {
        show.set(AxisParameter::MotorPoles.number(), motor.pole_pairs * 2.0)?;
    }
    show.set(AxisParameter::EncoderResolution.number(), counts)?;
    show.set(AxisParameter::MaxVelocity.number(), show.journey.rpm)?;
    show.set(AxisParameter::MaxAcceleration.number(), show.journey.rpm / RAMP_S)?;
    show.set(AxisParameter::CommutationMode.number(), BY_ENCODER)?;
    show.advance(INITIALIZATION_NS);
    show.go_and_return(counts, options)
}

/// What the run came to.
#[derive(Serialize)]
struct Summary {
    virtual_time_s: f64,
    times_real_time: f64,
    measured_turns: f64,
    physical_turns: f64,
    largest_velocity_rpm: f64,
    /// How far the load moved the shaft that was to stand still.
    largest_deflection_deg: f64,
    largest_motor_torque_nm: f64,
    largest_current_a: f64,
    highest_bus_voltage_v: f64,
    winding_temperature_c: f64,
}

impl Summary {
    fn new(show: &Show, held_ns: [u64; 2], elapsed: Duration) -> Self {
        let now = show.bench.physical(ModuleId(0));
        let measured = show.recorder.commanded_turns(&show.bench);
        Self {
            virtual_time_s: show.virtual_s(),
            times_real_time: show.times_real_time(elapsed),
            measured_turns: measured.last().copied().unwrap_or(0.0),
            physical_turns: now.rotor_turns,
            largest_velocity_rpm: show.largest("physical.velocity_rpm"),
            largest_deflection_deg: deflection_turns(show, held_ns) * 360.0,
            largest_motor_torque_nm: show.largest("physical.torque_nm"),
            largest_current_a: show.largest("physical.current_q_a"),
            highest_bus_voltage_v: show.largest("physical.bus_voltage_v"),
            winding_temperature_c: now.winding_temperature_c,
        }
    }

    fn rows(&self) -> Vec<[String; 3]> {
        vec![
            row("virtual time", self.virtual_time_s, 2, "s"),
            row("speed", self.times_real_time, 0, "× real time"),
            row("measured position at the end", self.measured_turns, 4, "turn"),
            row("physical position at the end", self.physical_turns, 4, "turn"),
            row("largest velocity", self.largest_velocity_rpm, 0, "rpm"),
            row("largest deflection between the moves", self.largest_deflection_deg, 1, "°"),
            row("largest motor torque", self.largest_motor_torque_nm, 3, "Nm"),
            row("largest current across the magnets", self.largest_current_a, 2, "A"),
            row("highest bus voltage", self.highest_bus_voltage_v, 1, "V"),
            row("winding temperature", self.winding_temperature_c, 1, "°C"),
        ]
    }
}

/// How far the shaft was from the target between the moves, at most.
fn deflection_turns(show: &Show, [from_ns, until_ns]: [u64; 2]) -> f64 {
    let physical = show.recorder.values("physical.rotor_turns");
    let sampled = show.recorder.times_ns().iter().zip(physical);
    let held = sampled.filter(|(time_ns, _)| (from_ns..until_ns).contains(time_ns));
    held.map(|(_, turns)| (turns - show.journey.turns).abs()).fold(0.0, f64::max)
}
