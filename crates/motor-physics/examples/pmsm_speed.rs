//! Virtual seconds per wall second of the bare brushless motor, for `benches/compare/compare.py`.
//!
//! Prints one line: virtual seconds per wall second, velocity (rad/s) and q current (A) after 5 ms, and both at the end.
#![allow(clippy::disallowed_methods, reason = "it measures itself: the clock never reaches the motor")]

use std::hint::black_box;
use std::time::Instant;

use motor_physics::mechanics::Mechanics;
use motor_physics::pmsm::{Bridge, Pmsm};
use motor_physics::presets;

const DT_S: f64 = 50e-6;
const STEPS: usize = 10_000;
const RUNS: usize = 400;
const VOLTAGE_Q_V: f64 = 8.0;

fn at_rest() -> Pmsm {
    let parameters = presets::pmsm("QBL4208-61-04-013").expect("a preset");
    let inertia_kgm2 = parameters.rotor_inertia_kgm2 + 1e-5;
    Pmsm::new(
        parameters,
        Mechanics { inertia_kgm2, friction_nm: 0.0, viscous_nm_s_per_rad: 2e-5, hard_stops: None },
    )
}

/// A step in which the voltage stands across the magnets on average.
fn advance(motor: &mut Pmsm) {
    let ahead_rad = 0.5 * motor.parameters.pole_pairs * motor.velocity_rad_s * DT_S;
    let (sine, cosine) = libm::sincos(motor.angle().electrical_rad() + ahead_rad);
    let voltage_alpha_beta_v = [-VOLTAGE_Q_V * sine, VOLTAGE_Q_V * cosine];
    motor.advance(Bridge::Driven { voltage_alpha_beta_v }, 0.0, DT_S);
}

fn main() {
    let mut motor = at_rest();
    (0..100).for_each(|_| advance(&mut motor));
    let early = (motor.velocity_rad_s, motor.current_q_a);
    (100..STEPS).for_each(|_| advance(&mut motor));
    let last = (motor.velocity_rad_s, motor.current_q_a);

    let begin = Instant::now();
    for _ in 0..RUNS {
        let mut motor = black_box(at_rest());
        (0..STEPS).for_each(|_| advance(&mut motor));
        black_box(motor);
    }
    let virtual_s = (RUNS * STEPS) as f64 * DT_S;
    let speed = virtual_s / begin.elapsed().as_secs_f64();
    println!("{speed} {} {} {} {}", early.0, early.1, last.0, last.1);
}
