//! The demonstration of a stepper: how far does the rotor follow the field?

use std::time::Duration;

use serde::Serialize;
use tmcl_tables::tmcm_1311::AxisParameter;
use virtual_bench::config::ModuleConfig;
use virtual_bench::{BenchConfig, ModuleId};

use super::{Journey, MS, RAMP_S, Show, row, tell};
use crate::arguments::Demo;
use crate::exit::{Failure, Outcome};

/// Microsteps in a full step after power-on.
const MICROSTEPS: f64 = 256.0;

/// Full steps in a turn of the usual stepper.
const USUAL_FULL_STEPS: f64 = 200.0;

pub(super) fn run(config: &BenchConfig, module: &ModuleConfig, options: &Demo) -> Outcome {
    // An electrical period is four full steps.
    let full_steps = module.motor.stepper().map_or(USUAL_FULL_STEPS, |motor| motor.pole_pairs * 4.0);
    let journey =
        Journey { turns: options.turns.unwrap_or(0.5), rpm: options.rpm.unwrap_or(60.0), load_nm: -0.3 };
    let show = Show::new(config, options, journey)?;
    tell(
        module,
        options,
        show,
        |show| play(show, full_steps, options),
        |show, _, elapsed| Summary::new(show, full_steps, elapsed),
        Summary::rows,
    )
}

fn play(show: &mut Show, full_steps: f64, options: &Demo) -> Result<[u64; 2], Failure> {
    let microsteps = full_steps * MICROSTEPS;
    let velocity_pps = show.journey.rpm / 60.0 * microsteps;
    show.set(AxisParameter::MotorFullSteps.number(), full_steps)?;
    show.set(AxisParameter::MaxVelocity.number(), velocity_pps)?;
    show.set(AxisParameter::MaxAcceleration.number(), velocity_pps / RAMP_S)?;
    show.advance(100 * MS);
    show.go_and_return(microsteps, options)
}

/// What the run came to.
#[derive(Serialize)]
struct Summary {
    virtual_time_s: f64,
    times_real_time: f64,
    commanded_turns: f64,
    physical_turns: f64,
    lost_full_steps: f64,
    largest_deviation_full_steps: f64,
    largest_load_angle_deg: f64,
    largest_motor_torque_nm: f64,
    largest_coil_current_a: f64,
    winding_temperature_c: f64,
}

impl Summary {
    fn new(show: &Show, full_steps: f64, elapsed: Duration) -> Self {
        let now = show.bench.physical(ModuleId(0));
        let commanded = show.recorder.commanded_turns(&show.bench);
        let physical = show.recorder.values("physical.rotor_turns");
        let apart = commanded.iter().zip(&physical).map(|(commanded, physical)| (commanded - physical).abs());
        let commanded_turns = commanded.last().copied().unwrap_or(0.0);
        Self {
            virtual_time_s: show.virtual_s(),
            times_real_time: show.times_real_time(elapsed),
            commanded_turns,
            physical_turns: now.rotor_turns,
            // Adding zero makes a plain one of a negative one.
            lost_full_steps: ((commanded_turns - now.rotor_turns) * full_steps).round() + 0.0,
            largest_deviation_full_steps: apart.fold(0.0, f64::max) * full_steps,
            largest_load_angle_deg: show.largest("physical.load_angle_deg"),
            largest_motor_torque_nm: show.largest("physical.torque_nm"),
            largest_coil_current_a: show.largest("physical.coil_a_a").max(show.largest("physical.coil_b_a")),
            winding_temperature_c: now.winding_temperature_c,
        }
    }

    fn rows(&self) -> Vec<[String; 3]> {
        vec![
            row("virtual time", self.virtual_time_s, 2, "s"),
            row("speed", self.times_real_time, 0, "× real time"),
            row("commanded position at the end", self.commanded_turns, 4, "turn"),
            row("physical position at the end", self.physical_turns, 4, "turn"),
            row("full steps lost", self.lost_full_steps, 0, ""),
            row("largest deviation", self.largest_deviation_full_steps, 2, "full steps"),
            row("largest load angle", self.largest_load_angle_deg, 1, "°"),
            row("largest motor torque", self.largest_motor_torque_nm, 3, "Nm"),
            row("largest coil current", self.largest_coil_current_a, 2, "A"),
            row("winding temperature", self.winding_temperature_c, 1, "°C"),
        ]
    }
}
