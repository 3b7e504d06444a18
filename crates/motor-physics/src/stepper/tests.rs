use core::f64::consts::{FRAC_PI_2, SQRT_2, TAU};

use super::*;
use crate::energy::joules;
use crate::presets;

const DT_S: f64 = 50e-6;

/// A bare rotor: no load, no friction.
fn bare(name: &str) -> Stepper {
    let parameters = presets::stepper(name).expect("a preset");
    with_friction(parameters, 0.0, 0.0)
}

fn with_friction(parameters: StepperParameters, friction_nm: f64, viscous_nm_s_per_rad: f64) -> Stepper {
    let inertia_kgm2 = parameters.rotor_inertia_kgm2;
    Stepper::new(parameters, Mechanics { inertia_kgm2, friction_nm, viscous_nm_s_per_rad, hard_stops: None })
}

/// Ideal current regulation: what it takes to reach `wanted` by the end of the step.
fn regulated(motor: &Stepper, wanted: [f64; 2], dt_s: f64) -> [Terminal; 2] {
    let emf = motor.back_emf_v();
    [0, 1].map(|coil| {
        let (now, wanted) = (motor.currents_a[coil], wanted[coil]);
        let StepperParameters { resistance_ohm, inductance_h, .. } = motor.parameters;
        let voltage_v =
            resistance_ohm * 0.5 * (now + wanted) + emf[coil] + inductance_h * (wanted - now) / dt_s;
        Terminal::Driven { voltage_v }
    })
}

/// The current vector of `amplitude_a` whose field stands at `angle_rad`.
fn vector(amplitude_a: f64, angle_rad: f64) -> [f64; 2] {
    [amplitude_a * libm::cos(angle_rad), amplitude_a * libm::sin(angle_rad)]
}

fn rated_peak_a(motor: &Stepper) -> f64 {
    SQRT_2 * motor.parameters.rated_current_rms_a
}

#[test]
fn current_rises_with_l_over_r() {
    let mut motor = bare("QSH5718-51-28-101");
    // Coil A with the rotor at 0: no torque, so nothing moves.
    let time_constant_s = motor.parameters.inductance_h / motor.parameters.resistance_ohm;
    let steps = libm::round(time_constant_s / DT_S) as usize;
    let terminals = [Terminal::Driven { voltage_v: 2.0 }, Terminal::Driven { voltage_v: 0.0 }];
    for _ in 0..steps {
        motor.advance(terminals, 0.0, DT_S);
    }
    let elapsed_s = steps as f64 * DT_S;
    let expected_a = 2.0 / motor.parameters.resistance_ohm * (1.0 - libm::exp(-elapsed_s / time_constant_s));
    assert!((motor.currents_a[0] - expected_a).abs() < 1e-6, "{} A, not {expected_a}", motor.currents_a[0]);
    assert!((expected_a * motor.parameters.resistance_ohm / 2.0 - 0.632).abs() < 0.01);
}

#[test]
fn the_holding_torque_is_the_datasheets_and_breaks_at_90_degrees() {
    for (name, parameters) in presets::STEPPERS {
        let mut motor = with_friction(StepperParameters { detent_torque_nm: 0.0, ..*parameters }, 0.0, 0.0);
        motor.currents_a = vector(rated_peak_a(&motor), 0.0);
        let torque_at = |degrees: f64| {
            let mut pushed = motor.clone();
            pushed.place(RotorAngle::default().advanced_to(degrees.to_radians()));
            -pushed.torque()
        };
        assert!((torque_at(90.0) / parameters.holding_torque_nm - 1.0).abs() < 1e-9, "{name}");
        assert!(torque_at(80.0) < torque_at(90.0) && torque_at(100.0) < torque_at(90.0), "{name}");
    }
}

/// Pulled with slightly less than the holding torque the rotor holds below 90°; slightly more tears it away.
#[test]
fn a_load_beyond_the_holding_torque_pulls_the_rotor_out() {
    for (share, holds) in [(0.97, true), (1.03, false)] {
        let parameters = presets::stepper("QSH5718-51-28-101").expect("a preset");
        let mut motor = with_friction(StepperParameters { detent_torque_nm: 0.0, ..parameters }, 0.0, 0.02);
        let wanted = vector(rated_peak_a(&motor), 0.0);
        motor.currents_a = wanted;
        for step in 0..40_000 {
            let load_nm = -share * parameters.holding_torque_nm * (f64::from(step) / 30_000.0).min(1.0);
            let terminals = regulated(&motor, wanted, DT_S);
            motor.advance(terminals, load_nm, DT_S);
        }
        let electrical_rad = motor.turns() * 50.0 * TAU;
        assert_eq!(electrical_rad.abs() < FRAC_PI_2, holds, "{share}: {electrical_rad} rad");
        if !holds {
            assert!(motor.turns() < -0.1, "it runs away: {}", motor.turns());
        }
    }
}

/// Zero crossings of a small oscillation around rest give the natural frequency √(Nr·Th/J)/2π.
fn ringing_hz(parameters: StepperParameters) -> f64 {
    let mut motor = with_friction(parameters, 0.0, 0.0);
    let wanted = vector(rated_peak_a(&motor), 0.0);
    motor.currents_a = wanted;
    motor.place(RotorAngle::default().advanced_to(0.05));
    let (dt_s, mut crossings, mut before) = (5e-6, [0.0; 2], 0.05);
    let mut found: i32 = 0;
    for step in 1..200_000 {
        let terminals = regulated(&motor, wanted, dt_s);
        motor.advance(terminals, 0.0, dt_s);
        let now = motor.angle.electrical_rad();
        if before < 0.0 && now >= 0.0 {
            crossings[usize::from(found > 0)] = (f64::from(step) - now / (now - before)) * dt_s;
            found += 1;
        }
        before = now;
    }
    f64::from(found - 1) / (crossings[1] - crossings[0])
}

#[test]
fn a_free_rotor_rings_at_its_natural_frequency() {
    for (name, expected_hz) in
        [("QSH4218-51-10-049", 302.0), ("QSH5718-51-28-101", 216.0), ("QSH5718-76-28-189", 223.0)]
    {
        let parameters = presets::stepper(name).expect("a preset");
        let without_detent = ringing_hz(StepperParameters { detent_torque_nm: 0.0, ..parameters });
        assert!((without_detent / expected_hz - 1.0).abs() < 0.03, "{name}: {without_detent} Hz");
        // The detent torque stiffens the rest position: √(Nr·(Th + 4·Td)/J)/2π.
        let stiffness =
            parameters.pole_pairs * (parameters.holding_torque_nm + 4.0 * parameters.detent_torque_nm);
        let expected_hz = libm::sqrt(stiffness / parameters.rotor_inertia_kgm2) / TAU;
        let with_detent = ringing_hz(parameters);
        assert!(
            (with_detent / expected_hz - 1.0).abs() < 0.03,
            "{name}: {with_detent} Hz, not {expected_hz}"
        );
    }
}

/// Turns the field for a while and compares what went in with what came out, was lost, and is stored.
#[test]
fn energy_is_conserved() {
    let parameters = presets::stepper("QSH5718-51-28-101").expect("a preset");
    let mut motor = with_friction(parameters, 0.02, 1e-3);
    let stored_before_j = motor.stored_j();
    let mut phase = 0.0_f64;
    for step in 0..40_000 {
        let turning = (f64::from(step) / 10_000.0).min(1.0);
        phase += turning * 50.0 * TAU * 5.0 * DT_S;
        let terminals = regulated(&motor, vector(3.0, phase), DT_S);
        motor.advance(terminals, -0.2, DT_S);
    }
    assert!(motor.turns() > 5.0, "it turned {} times", motor.turns());
    let Energy { electrical_pj, copper_pj, friction_pj, load_pj } = motor.energy;
    let used_j = joules(copper_pj + friction_pj + load_pj) + motor.stored_j() - stored_before_j;
    let balance = used_j / joules(electrical_pj) - 1.0;
    assert!(balance.abs() < 0.005, "off by {:.4} %", 100.0 * balance);
    assert!(joules(load_pj) > 5.0, "the load took {} J", joules(load_pj));
}

/// A field that turns too fast for the load leaves the rotor behind, and it falls back by whole electrical periods: four
/// full steps each (decision: open loop).
#[test]
fn a_stall_loses_four_full_steps_at_a_time() {
    let parameters = presets::stepper("QSH5718-51-28-101").expect("a preset");
    let mut motor = with_friction(parameters, 0.02, 5e-3);
    let (mut phase, mut settle) = (0.0_f64, 0);
    while settle < 20_000 {
        let moving = phase < 50.0 * TAU;
        if moving {
            phase += 50.0 * TAU * 2.0 * DT_S;
        } else {
            settle += 1;
        }
        let overloaded = (20.0 * TAU..24.0 * TAU).contains(&phase);
        let terminals = regulated(&motor, vector(rated_peak_a(&motor), phase), DT_S);
        motor.advance(terminals, if overloaded { -1.3 } else { 0.0 }, DT_S);
    }
    let lost_periods = phase / TAU - motor.turns() * 50.0;
    assert!(lost_periods > 0.9, "it lost {lost_periods} periods");
    assert!((lost_periods - libm::round(lost_periods)).abs() < 0.02, "it lost {lost_periods} periods");
}

#[test]
fn a_released_motor_coasts_and_its_currents_die() {
    let mut motor = bare("QSH4218-35-10-027");
    motor.velocity_rad_s = 20.0;
    motor.currents_a = [0.5, -0.5];
    for _ in 0..200 {
        motor.advance([Terminal::Floating { bus_voltage_v: 48.0 }; 2], 0.0, DT_S);
    }
    assert_eq!(motor.currents_a, [0.0, 0.0]);
    assert!(motor.velocity_rad_s > 15.0);
    assert!(joules(motor.energy.electrical_pj) < 0.0, "the field's energy went back to the bus");
}

#[test]
fn at_rest_nothing_changes_and_rest_is_the_same_as_stepping() {
    let parameters = presets::stepper("QSH5718-51-28-101").expect("a preset");
    let mut motor = with_friction(parameters, 0.01, 1e-3);
    let wanted = vector(2.0, 0.3);
    let advance = |motor: &mut Stepper| {
        let terminals = regulated(motor, wanted, DT_S);
        motor.advance(terminals, 0.0, DT_S)
    };
    let restless = (0..200_000).take_while(|_| advance(&mut motor)).count();
    assert!(restless < 100_000, "it comes to rest after {restless} steps");
    let mut rested = motor.clone();
    for _ in 0..1000 {
        assert!(!advance(&mut motor));
    }
    rested.rest(1000);
    assert_eq!(rested, motor);
}
