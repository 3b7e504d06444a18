//! One step of integration in each control period of 50 µs is enough: over everything that can happen to a motor, the phase
//! currents stay within 5 mA of a reference that takes steps of 1 µs.
//!
//! Both runs have their own chip, which looks at its motor and decides every 50 µs, as the silicon's cycle by cycle
//! regulation averaged over the period does; they differ in nothing but the steps between.

use std::f64::consts::{PI, SQRT_2, TAU};

use driver_chips::tmc262::{Board, CoilFault, Coils, Pins, Registers, Tmc262};
use motor_physics::Terminal;
use motor_physics::mechanics::{HardStops, Mechanics};
use motor_physics::presets;
use motor_physics::stepper::{Stepper, StepperParameters};
use motor_physics::supply::{Supply, SupplyParameters};

const PERIOD_S: f64 = 50e-6;

/// The largest difference allowed.
const BOUND_A: f64 = 5e-3;

/// Chip, motor and supply, with so many steps in a control period.
struct Run {
    chip: Tmc262,
    motor: Stepper,
    supply: Supply,
    steps: u32,
}

/// What happens in a control period.
#[derive(Clone, Copy)]
struct Input {
    /// Where the commanded current vector points, electrically.
    field_rad: f64,
    /// CS.
    current_scale: u8,
    off_time: u8,
    load_nm: f64,
    friction_nm: f64,
    source_v: f64,
}

impl Input {
    const REST: Self =
        Self { field_rad: 0.0, current_scale: 16, off_time: 5, load_nm: 0.0, friction_nm: 0.01, source_v: 48.0 };
}

impl Run {
    fn new(parameters: StepperParameters, hard_stops: Option<HardStops>, steps: u32) -> Self {
        let inertia_kgm2 = parameters.rotor_inertia_kgm2;
        let mechanics = Mechanics { inertia_kgm2, friction_nm: 0.01, viscous_nm_s_per_rad: 4e-4, hard_stops };
        Self {
            chip: Tmc262::new(Board { full_scale_rms_a: parameters.rated_current_rms_a * 32.0 / 31.0 }),
            motor: Stepper::new(parameters, mechanics),
            supply: Supply::new(SupplyParameters::standard(48.0)),
            steps,
        }
    }

    fn period(&mut self, input: Input) {
        self.motor.mechanics.friction_nm = input.friction_nm;
        self.supply.parameters.voltage_v = input.source_v;
        let terminals: [Terminal; 2] = self.chip.advance(&registers(input), &self.pins(), PERIOD_S);
        let step_s = PERIOD_S / f64::from(self.steps);
        for _ in 0..self.steps {
            self.motor.advance(terminals, input.load_nm, step_s);
            self.supply.advance(self.motor.electrical_power_w(step_s), step_s);
        }
    }

    fn pins(&self) -> Pins {
        Pins {
            currents_a: self.motor.currents_a,
            back_emf_v: self.motor.back_emf_v(),
            rotor_velocity_rps: self.motor.velocity_rad_s / TAU,
            bus_voltage_v: self.supply.bus_voltage_v(),
            resistance_ohm: self.motor.parameters.resistance_ohm,
            inductance_h: self.motor.parameters.inductance_h,
            temperature_c: 25.0,
            coil_faults: [CoilFault::None; 2],
        }
    }
}

fn registers(input: Input) -> Registers {
    let vector = [input.field_rad.cos(), input.field_rad.sin()].map(|part| (248.0 * part).round() as i16);
    Registers {
        coils: Coils::Direct(vector),
        current_scale: input.current_scale,
        off_time: input.off_time,
        ..Registers::default()
    }
}

/// The largest difference of a phase current in a run of `duration_s` under `input`, a function of time.
fn worst_a(
    parameters: StepperParameters,
    hard_stops: Option<HardStops>,
    duration_s: f64,
    input: impl Fn(f64) -> Input,
) -> f64 {
    let [mut coarse, mut fine] = [1, 50].map(|steps| Run::new(parameters, hard_stops, steps));
    let mut worst_a = 0.0_f64;
    for period in 0..(duration_s / PERIOD_S) as u32 {
        let input = input(f64::from(period) * PERIOD_S);
        coarse.period(input);
        fine.period(input);
        for (coarse_a, fine_a) in coarse.motor.currents_a.iter().zip(fine.motor.currents_a) {
            worst_a = worst_a.max((coarse_a - fine_a).abs());
        }
    }
    println!("   {} V {} rad/s {:?} A", coarse.supply.bus_voltage_v(), coarse.motor.velocity_rad_s, coarse.motor.currents_a);
    worst_a
}

/// Electrical angle of a field that speeds up to `turns_per_s` within `ramp_s` and goes on.
fn ramp_rad(time_s: f64, turns_per_s: f64, ramp_s: f64) -> f64 {
    let turns =
        if time_s < ramp_s { turns_per_s * time_s * time_s / (2.0 * ramp_s) } else { turns_per_s * (time_s - ramp_s / 2.0) };
    50.0 * TAU * turns
}

#[test]
fn figures() {
    for (name, parameters) in &presets::STEPPERS[2..3] {
        let pull_out_nm = parameters.holding_torque_nm * 17.0 / 31.0;
        println!("{name} (at CS 16 holds {pull_out_nm} Nm, {} A peak)", parameters.rated_current_rms_a * SQRT_2);
        let p = |what: &str, x: f64| println!("  {what}: {:.3} mA", x * 1e3);
        p("rest", worst_a(*parameters, None, 0.2, |_| Input::REST));
        for v in [1.0, 2.0, 5.0, 10.0, 20.0] {
            p(&format!("move {v}"), worst_a(*parameters, None, 1.5, |t| Input { field_rad: ramp_rad(t, v, 0.5), ..Input::REST }));
        }
        p("loaded", worst_a(*parameters, None, 1.0, |t| Input { field_rad: ramp_rad(t, 5.0, 0.5), load_nm: if t > 0.7 { -0.4 * pull_out_nm } else {0.0}, ..Input::REST }));
        p("vector jump", worst_a(*parameters, None, 0.5, |t| Input { field_rad: PI / 4.0 * (t * 20.0).floor(), ..Input::REST }));
        p("scale jump", worst_a(*parameters, None, 0.5, |t| Input { current_scale: if (t * 20.0) as u32 % 2 == 0 { 31 } else { 5 }, field_rad: ramp_rad(t, 3.0, 0.2), ..Input::REST }));
        p("released", worst_a(*parameters, None, 0.5, |t| Input { off_time: if t > 0.3 { 0 } else { 5 }, field_rad: ramp_rad(t, 5.0, 0.2), ..Input::REST }));
        p("dip", worst_a(*parameters, None, 1.0, |t| Input { source_v: if (0.4..0.6).contains(&t) { 12.0 } else { 48.0 }, field_rad: ramp_rad(t, 5.0, 0.2), ..Input::REST }));
        p("jam", worst_a(*parameters, None, 1.0, |t| Input { friction_nm: if t > 0.5 { 3.0 } else {0.01}, field_rad: ramp_rad(t, 2.0, 0.2), ..Input::REST }));
        p("pulled out", worst_a(*parameters, None, 1.0, |t| Input { load_nm: if t > 0.5 { -2.0 * pull_out_nm } else {0.0}, field_rad: ramp_rad(t, 2.0, 0.2), ..Input::REST }));
        for share in [0.05, 0.1, 0.2, 0.5, 1.0, 1.2, 1.5] { for drop in [0.05, 0.3] {
        p(&format!("dragged {share} for {drop}"), worst_a(*parameters, None, 1.0, |t| Input { load_nm: if t > 0.5 && t < 0.5 + drop { -share * pull_out_nm } else {0.0}, off_time: if t > 0.5 && t < 0.5+drop {0} else {5}, field_rad: ramp_rad(t, 2.0, 0.2), ..Input::REST }));
        p(&format!("overloaded {share} for {drop}"), worst_a(*parameters, None, 1.0, |t| Input { load_nm: if t > 0.5 && t < 0.5 + drop { -share * pull_out_nm } else {0.0}, field_rad: ramp_rad(t, 2.0, 0.2), ..Input::REST }));
        }}
        p("too fast a start", worst_a(*parameters, None, 1.0, |t| Input { field_rad: ramp_rad(t, 8.0, 0.001), ..Input::REST }));
        p("wall", worst_a(*parameters, Some(HardStops { low_turns: -1.0, high_turns: 0.2, restitution: 0.3 }), 1.0, |t| Input { field_rad: ramp_rad(t, 1.0, 0.2), ..Input::REST }));
    }
}
