//! One step of integration in each control period of 50 µs is enough: over everything that can happen to a motor, the phase
//! currents stay within 5 mA of a reference that takes steps of 1 µs.
//!
//! Both runs have their own chip, which looks at its motor and decides every 50 µs, as the silicon's cycle by cycle
//! regulation averaged over the period does; they differ in nothing but the steps between.

use std::f64::consts::{PI, TAU};

use driver_chips::tmc262::{Board, CoilFault, Coils, Pins, Registers, Tmc262};
use motor_physics::mechanics::{HardStops, Mechanics};
use motor_physics::presets;
use motor_physics::stepper::{Stepper, StepperParameters};
use motor_physics::supply::{Supply, SupplyParameters};

const PERIOD_S: f64 = 50e-6;

/// The largest difference allowed.
const BOUND_A: f64 = 5e-3;

/// Chip, motor and supply, with so many steps in a control period.
#[derive(Clone)]
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
    const REST: Self = Self {
        field_rad: 0.0,
        current_scale: 16,
        off_time: 5,
        load_nm: 0.0,
        friction_nm: 0.01,
        source_v: 48.0,
    };
}

impl Run {
    fn new(parameters: StepperParameters, steps: u32) -> Self {
        let inertia_kgm2 = parameters.rotor_inertia_kgm2;
        let mechanics =
            Mechanics { inertia_kgm2, friction_nm: 0.01, viscous_nm_s_per_rad: 4e-4, hard_stops: None };
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
        let terminals = self.chip.advance(&registers(input), &self.pins(), PERIOD_S);
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
            resistance_ohm: self.motor.parameters().resistance_ohm,
            inductance_h: self.motor.parameters().inductance_h,
            temperature_c: 25.0,
            coil_faults: [CoilFault::None; 2],
        }
    }
}

fn registers(input: Input) -> Registers {
    let vector =
        [libm::cos(input.field_rad), libm::sin(input.field_rad)].map(|part| libm::round(248.0 * part) as i16);
    Registers {
        coils: Coils::Direct(vector),
        current_scale: input.current_scale,
        off_time: input.off_time,
        ..Registers::default()
    }
}

/// Asserts that no phase current differs by more than [`BOUND_A`] in a run of `duration_s` under `input`, a function of
/// time.
#[track_caller]
fn assert_accurate(
    what: &str,
    parameters: &StepperParameters,
    duration_s: f64,
    input: impl Fn(f64) -> Input,
) {
    let runs = [1, 50].map(|steps| Run::new(*parameters, steps));
    assert_runs_agree(what, runs, duration_s, input);
}

#[track_caller]
fn assert_runs_agree(what: &str, runs: [Run; 2], duration_s: f64, input: impl Fn(f64) -> Input) {
    let [mut coarse, mut fine] = runs;
    let mut worst_a = 0.0_f64;
    for period in 0..(duration_s / PERIOD_S) as u32 {
        let input = input(f64::from(period) * PERIOD_S);
        coarse.period(input);
        fine.period(input);
        worst_a = worst_a.max(difference_a(&coarse, &fine));
    }
    assert!(worst_a < BOUND_A, "{what}: {:.3} mA", worst_a * 1e3);
}

/// The largest difference of a phase current.
fn difference_a(coarse: &Run, fine: &Run) -> f64 {
    let [a, b] = [0, 1].map(|coil| (coarse.motor.currents_a[coil] - fine.motor.currents_a[coil]).abs());
    a.max(b)
}

/// The electrical angle of a field that speeds up to `turns_per_s` within `ramp_s` and goes on.
fn ramp_rad(time_s: f64, turns_per_s: f64, ramp_s: f64) -> f64 {
    let turns = if time_s < ramp_s {
        turns_per_s * time_s * time_s / (2.0 * ramp_s)
    } else {
        turns_per_s * (time_s - ramp_s / 2.0)
    };
    50.0 * TAU * turns
}

/// A field turning at `turns_per_s` after 0.2 s.
fn turning(time_s: f64, turns_per_s: f64) -> Input {
    Input { field_rad: ramp_rad(time_s, turns_per_s, 0.2), ..Input::REST }
}

/// What CS 16 holds.
fn pull_out_nm(parameters: &StepperParameters) -> f64 {
    parameters.holding_torque_nm * 17.0 / 31.0
}

#[test]
fn at_rest_and_at_any_speed() {
    for (name, parameters) in presets::STEPPERS {
        assert_accurate(&format!("{name} at rest"), parameters, 0.2, |_| Input::REST);
        for turns_per_s in [1.0, 5.0, 20.0] {
            let what = format!("{name} at {turns_per_s} turns/s");
            assert_accurate(&what, parameters, 0.6, |time_s| turning(time_s, turns_per_s));
        }
        // More than it can follow from a standing start.
        assert_accurate(&format!("{name} started too fast"), parameters, 0.3, |time_s| Input {
            field_rad: ramp_rad(time_s, 8.0, 0.001),
            ..Input::REST
        });
    }
}

#[test]
fn when_the_load_changes() {
    for (name, parameters) in presets::STEPPERS {
        assert_accurate(&format!("{name} under a load step"), parameters, 0.6, |time_s| Input {
            load_nm: if time_s > 0.4 { -0.4 * pull_out_nm(parameters) } else { 0.0 },
            ..turning(time_s, 5.0)
        });
        assert_accurate(&format!("{name} jammed"), parameters, 0.8, |time_s| Input {
            friction_nm: if (0.4..0.6).contains(&time_s) { 3.0 } else { 0.01 },
            ..turning(time_s, 2.0)
        });
    }
}

#[test]
fn when_the_current_changes() {
    for (name, parameters) in presets::STEPPERS {
        assert_accurate(&format!("{name} with its field jumping by half steps"), parameters, 0.5, |time_s| {
            Input { field_rad: PI / 4.0 * (time_s * 20.0).floor(), ..Input::REST }
        });
        assert_accurate(&format!("{name} with its current jumping"), parameters, 0.5, |time_s| Input {
            current_scale: if ((time_s * 20.0) as u32).is_multiple_of(2) { 31 } else { 5 },
            ..turning(time_s, 3.0)
        });
        assert_accurate(&format!("{name} released"), parameters, 0.5, |time_s| Input {
            off_time: if time_s > 0.3 { 0 } else { 5 },
            ..turning(time_s, 5.0)
        });
    }
}

#[test]
fn when_the_supply_dips() {
    for (name, parameters) in presets::STEPPERS {
        assert_accurate(&format!("{name} on a dip"), parameters, 0.8, |time_s| Input {
            source_v: if (0.3..0.45).contains(&time_s) { 14.0 } else { 48.0 },
            ..turning(time_s, 10.0)
        });
    }
}

#[test]
fn at_a_wall() {
    for (name, parameters) in presets::STEPPERS {
        let mut runs = [1, 50].map(|steps| Run::new(*parameters, steps));
        for run in &mut runs {
            let stops = HardStops { low_turns: -1.0, high_turns: 0.2, restitution: 0.3 };
            run.motor.mechanics.hard_stops = Some(stops);
        }
        assert_runs_agree(&format!("{name} at a wall"), runs, 0.6, |time_s| turning(time_s, 1.0));
    }
}

/// A load that has torn the rotor away drags it along, faster than any field turns. Where it is caught again is a matter of
/// chance, so each control period is compared by itself.
#[test]
fn dragged_along_by_the_load() {
    for (name, parameters) in presets::STEPPERS {
        let mut coarse = Run::new(*parameters, 1);
        let (mut worst_a, mut fastest_rad_s) = (0.0_f64, 0.0_f64);
        for period in 0..12_000 {
            let load_nm = if (6_000..9_000).contains(&period) { -1.5 * pull_out_nm(parameters) } else { 0.0 };
            let input = Input { load_nm, ..turning(f64::from(period) * PERIOD_S, 2.0) };
            let mut fine = Run { steps: 50, ..coarse.clone() };
            coarse.period(input);
            fine.period(input);
            worst_a = worst_a.max(difference_a(&coarse, &fine));
            fastest_rad_s = fastest_rad_s.max(coarse.motor.velocity_rad_s.abs());
        }
        assert!(worst_a < BOUND_A && fastest_rad_s > 300.0, "{name}: {worst_a} A at {fastest_rad_s} rad/s");
    }
}
