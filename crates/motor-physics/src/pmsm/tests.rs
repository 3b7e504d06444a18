extern crate std;

use core::f64::consts::{FRAC_PI_2, FRAC_PI_3};
use std::vec;

use super::frame::dot;
use super::*;
use crate::energy::joules;
use crate::hall::HallSensors;
use crate::mechanics::HardStops;
use crate::presets;

const DT_S: f64 = 50e-6;
const BUS_V: f64 = 24.0;

fn preset() -> PmsmParameters {
    presets::pmsm("QBL4208-61-04-013").expect("a preset")
}

fn motor(parameters: PmsmParameters, friction_nm: f64, viscous_nm_s_per_rad: f64) -> Pmsm {
    let inertia_kgm2 = parameters.rotor_inertia_kgm2;
    Pmsm::new(parameters, Mechanics { inertia_kgm2, friction_nm, viscous_nm_s_per_rad, hard_stops: None })
}

/// One whose d and q axes differ, as those of the presets do not.
fn salient() -> PmsmParameters {
    PmsmParameters { d_inductance_h: 0.4e-3, q_inductance_h: 0.9e-3, ..preset() }
}

/// A voltage vector that stands at (d, q) in the middle of the step.
fn commutated(motor: &Pmsm, voltage_dq_v: [f64; 2]) -> Bridge {
    let ahead_rad = 0.5 * motor.parameters.pole_pairs * motor.velocity_rad_s * DT_S;
    Bridge::Driven {
        voltage_alpha_beta_v: Direction::of(motor.angle.electrical_rad() + ahead_rad).to_stator(voltage_dq_v),
    }
}

fn run(motor: &mut Pmsm, seconds: f64, load_nm: f64, bridge: impl Fn(&Pmsm) -> Bridge) {
    for _ in 0..libm::round(seconds / DT_S) as usize {
        motor.advance(bridge(motor), load_nm, DT_S);
    }
}

const FLOATING: Bridge = Bridge::Floating { bus_voltage_v: BUS_V };

#[test]
fn current_rises_with_l_over_r() {
    let mut motor = motor(preset(), 0.0, 0.0);
    let time_constant_s = motor.parameters.d_inductance_h / motor.parameters.resistance_ohm;
    assert!((time_constant_s - 0.0012 / 0.72).abs() < 1e-12, "as between two terminals");
    // Along the magnets: no torque, so nothing moves.
    for step in 1..=100 {
        motor.advance(Bridge::Driven { voltage_alpha_beta_v: [1.8, 0.0] }, 0.0, DT_S);
        let expected_a = 5.0 * (1.0 - libm::exp(-f64::from(step) * DT_S / time_constant_s));
        let [u, v, w] = motor.phase_currents_a();
        assert!((u - expected_a).abs() < 1e-6, "{u} A, not {expected_a}");
        assert!((v + 0.5 * u).abs() < 1e-9 && (w + 0.5 * u).abs() < 1e-9);
    }
    assert_eq!(motor.turns(), 0.0);
}

/// Between two terminals 24 V meet Kt · ω at the no-load speed: 667 rad/s, 6366 rpm.
#[test]
fn the_no_load_speed_follows_from_the_datasheet() {
    for (name, parameters) in presets::PMSMS {
        let mut motor = motor(*parameters, 0.0, 0.0);
        let amplitude_v = parameters.rated_voltage_v / libm::sqrt(3.0);
        run(&mut motor, 2.0, 0.0, |motor| commutated(motor, [0.0, amplitude_v]));
        let expected_rad_s = 24.0 / 0.036;
        assert!(
            (motor.velocity_rad_s / expected_rad_s - 1.0).abs() < 0.01,
            "{name}: {}",
            motor.velocity_rad_s
        );
        assert!(motor.current_q_a.abs() < 0.05, "{name}: {} A", motor.current_q_a);
    }
}

/// Held, 24 V drive 24 V / R through two phases, and Kt times that is the torque.
#[test]
fn the_stall_torque_follows_from_the_datasheet() {
    for (name, resistance_ohm) in [("QBL4208-61-04-013", 0.72), ("QBL4208-100-04-025", 0.28)] {
        let parameters = presets::pmsm(name).expect("a preset");
        let mut motor = motor(parameters, 1000.0, 0.0);
        run(&mut motor, 0.05, 0.0, |motor| commutated(motor, [0.0, 24.0 / libm::sqrt(3.0)]));
        let expected_nm = 24.0 / resistance_ohm * 0.036;
        assert!((motor.torque_nm / expected_nm - 1.0).abs() < 0.01, "{name}: {} Nm", motor.torque_nm);
        assert_eq!(motor.velocity_rad_s, 0.0);
    }
}

#[test]
fn at_rated_speed_it_holds_the_rated_torque_within_the_rated_voltage() {
    for (name, parameters) in presets::PMSMS {
        let mut motor = motor(*parameters, 0.0, 0.0);
        motor.velocity_rad_s = parameters.rated_velocity_rad_s;
        let q_a = parameters.rated_torque_nm / (1.5 * parameters.pole_pairs * parameters.flux_linkage_wb);
        let electrical_rad_s = parameters.pole_pairs * motor.velocity_rad_s;
        let voltage = [
            -electrical_rad_s * parameters.q_inductance_h * q_a,
            parameters.resistance_ohm * q_a + electrical_rad_s * parameters.flux_linkage_wb,
        ];
        run(&mut motor, 1.0, -parameters.rated_torque_nm, |motor| commutated(motor, voltage));
        assert!((motor.velocity_rad_s / parameters.rated_velocity_rad_s - 1.0).abs() < 0.01, "{name}");
        assert!((motor.current_q_a / q_a - 1.0).abs() < 0.01 && motor.current_d_a.abs() < 0.1, "{name}");
        assert!(libm::sqrt(3.0 * dot(voltage, voltage)) < parameters.rated_voltage_v, "{name}");
    }
}

#[test]
fn the_rotor_turns_to_where_the_stators_field_points() {
    for degrees in [30.0, 150.0, -100.0] {
        let mut motor = motor(preset(), 1e-4, 1e-4);
        let angle_rad = f64::to_radians(degrees);
        let bridge =
            Bridge::Driven { voltage_alpha_beta_v: [1.5 * libm::cos(angle_rad), 1.5 * libm::sin(angle_rad)] };
        run(&mut motor, 1.0, 0.0, |_| bridge);
        assert!((motor.angle.electrical_rad() - angle_rad).abs() < 0.01, "{degrees}: {:?}", motor.angle);
    }
}

#[test]
fn turning_right_shows_the_hall_sectors_in_order() {
    let mut motor = motor(preset(), 0.0, 1e-4);
    let halls = HallSensors::default();
    let mut seen = vec![halls.bits(motor.angle.electrical_rad())];
    while motor.turns() < 0.26 {
        motor.advance(commutated(&motor, [0.0, 1.0]), 0.0, DT_S);
        let bits = halls.bits(motor.angle.electrical_rad());
        if seen.last() != Some(&bits) {
            seen.push(bits);
        }
    }
    assert_eq!(seen, [0b001, 0b011, 0b010, 0b110, 0b100, 0b101, 0b001]);
}

/// Up to speed, under load, braked, let go: what went in came out, was lost, or is stored.
#[test]
fn energy_is_conserved() {
    for parameters in [preset(), salient()] {
        let mut motor = motor(parameters, 5e-3, 2e-5);
        run(&mut motor, 0.3, 0.0, |motor| commutated(motor, [0.0, 10.0]));
        run(&mut motor, 0.5, -0.1, |motor| commutated(motor, [-2.0, 10.0]));
        run(&mut motor, 0.05, 0.02, |motor| commutated(motor, [0.0, 2.0]));
        run(&mut motor, 0.01, -0.05, |_| FLOATING);
        let Energy { electrical_pj, copper_pj, friction_pj, load_pj } = motor.energy;
        let used_j = joules(copper_pj + friction_pj + load_pj) + motor.stored_j();
        // Most went into copper here; held against the least of the parts, none of them can be wrong unseen.
        let balance = (used_j - joules(electrical_pj)) / joules(friction_pj);
        assert!(balance.abs() < 1e-4, "off by {balance:e} of the friction");
        assert!(joules(load_pj) > 3.0 && joules(friction_pj) > 0.3, "{:?}", motor.energy);
    }
}

/// The same voltages in steps of 50 µs and of 1 µs, and the greatest difference of a phase current.
fn difference_a(
    start: &Pmsm,
    seconds: f64,
    load: impl Fn(f64) -> f64,
    bridge: impl Fn(&Pmsm, f64) -> Bridge,
) -> f64 {
    let (mut motor, mut reference) = (start.clone(), start.clone());
    let mut greatest = 0.0_f64;
    for step in 0..libm::round(seconds / DT_S) as usize {
        let time_s = step as f64 * DT_S;
        let (held, load_nm) = (bridge(&motor, time_s), load(time_s));
        motor.advance(held, load_nm, DT_S);
        for _ in 0..50 {
            reference.advance(held, load_nm, 1e-6);
        }
        for (coarse, fine) in motor.phase_currents_a().into_iter().zip(reference.phase_currents_a()) {
            greatest = greatest.max((coarse - fine).abs());
        }
    }
    greatest
}

#[test]
fn phase_currents_are_within_5_ma_of_a_reference_at_1_us() {
    let full_v = 24.0 / libm::sqrt(3.0);
    for parameters in [preset(), salient()] {
        let at_rest = motor(parameters, 5e-3, 1e-5);
        let mut turning = at_rest.clone();
        run(&mut turning, 0.1, 0.0, |motor| commutated(motor, [0.0, 12.0]));
        let mut between_stops = at_rest.clone();
        between_stops.mechanics.hard_stops =
            Some(HardStops { low_turns: -0.1, high_turns: 0.1, restitution: 0.5 });
        let differences = [
            // full voltage from standstill, and reversed
            difference_a(&at_rest, 0.02, |_| 0.0, |motor, _| commutated(motor, [0.0, full_v])),
            difference_a(&turning, 0.02, |_| 0.0, |motor, _| commutated(motor, [0.0, -full_v])),
            // a load that comes and goes
            difference_a(
                &turning,
                0.04,
                |time_s| if time_s < 0.02 { -0.125 } else { 0.0 },
                |motor, _| commutated(motor, [0.0, 12.0]),
            ),
            // a field that jumps by 60°: the rotor swings, stops, and sticks
            difference_a(
                &at_rest,
                0.04,
                |_| 0.0,
                |_, time_s| {
                    let angle_rad = libm::floor(time_s / 0.01) * FRAC_PI_3;
                    Bridge::Driven {
                        voltage_alpha_beta_v: [3.0 * libm::cos(angle_rad), 3.0 * libm::sin(angle_rad)],
                    }
                },
            ),
            // against an end of travel and away from it
            difference_a(
                &between_stops,
                0.04,
                |_| 0.0,
                |motor, time_s| commutated(motor, [0.0, if time_s < 0.02 { 3.0 } else { -3.0 }]),
            ),
            // the stage goes off under current and at speed
            difference_a(
                &turning,
                0.02,
                |_| -0.05,
                |motor, time_s| {
                    if time_s < 0.01 { commutated(motor, [-3.0, 13.0]) } else { FLOATING }
                },
            ),
            // an outside torque drives the motor beyond the bus voltage
            difference_a(&turning, 0.02, |_| 0.3, |_, _| FLOATING),
        ];
        assert!(differences.iter().all(|difference| *difference < 5e-3), "{differences:?} A");
    }
}

#[test]
fn switched_off_the_currents_die_into_the_bus_and_the_shaft_coasts() {
    let mut motor = motor(preset(), 0.0, 0.0);
    motor.velocity_rad_s = 100.0;
    (motor.current_d_a, motor.current_q_a) = (-3.0, 5.0);
    let field_j = motor.stored_j() - motor.mechanics.kinetic_j(100.0);
    motor.advance(FLOATING, 0.0, DT_S);
    assert!(motor.phase_currents_a().into_iter().any(|current_a| current_a != 0.0), "they need time");
    let steps = (0..100).take_while(|_| {
        motor.advance(FLOATING, 0.0, DT_S);
        (motor.current_d_a, motor.current_q_a) != (0.0, 0.0)
    });
    let died_s = (steps.count() + 2) as f64 * DT_S;
    // The longest current falls against between half and two thirds of the bus.
    let parameters = &motor.parameters;
    let longest_s = libm::hypot(3.0, 5.0) * parameters.d_inductance_h
        / (0.5 * BUS_V - 4.0 * 100.0 * parameters.flux_linkage_wb);
    assert!(died_s < longest_s + DT_S, "{died_s} s, at most {longest_s}");
    let returned_j = -joules(motor.energy.electrical_pj);
    assert!(returned_j > 0.5 * field_j && returned_j < 1.5 * field_j, "{returned_j} of {field_j} J");
    let coasting = motor.velocity_rad_s;
    run(&mut motor, 0.1, 0.0, |_| FLOATING);
    assert_eq!(motor.velocity_rad_s, coasting);
}

/// Beyond Kt · ω = bus voltage the diodes rectify, and the motor brakes with what the bus takes.
#[test]
fn driven_beyond_its_voltage_it_feeds_the_bus() {
    for parameters in [preset(), salient()] {
        let mut motor = motor(parameters, 0.0, 0.0);
        motor.velocity_rad_s = 0.99 * BUS_V / 0.036;
        run(&mut motor, 0.02, 0.0, |_| FLOATING);
        assert_eq!(motor.energy, Energy::default(), "below it nothing flows");
        motor.velocity_rad_s = 1.3 * BUS_V / 0.036;
        let kinetic_j = motor.stored_j();
        run(&mut motor, 0.5, 0.0, |_| FLOATING);
        assert!(motor.velocity_rad_s < 1.01 * BUS_V / 0.036, "{} rad/s", motor.velocity_rad_s);
        assert!(motor.velocity_rad_s > 0.98 * BUS_V / 0.036, "{} rad/s", motor.velocity_rad_s);
        let lost_j = kinetic_j - motor.stored_j();
        let Energy { electrical_pj, copper_pj, .. } = motor.energy;
        assert!((joules(copper_pj - electrical_pj) / lost_j - 1.0).abs() < 1e-4, "{:?}", motor.energy);
        assert!(electrical_pj < 0 && -electrical_pj > copper_pj);
    }
}

#[test]
fn a_hard_stop_holds_and_its_energy_is_friction() {
    let mut motor = motor(preset(), 1e-3, 0.0);
    let stops = HardStops { low_turns: -1.0, high_turns: 1.0, restitution: 0.0 };
    motor.mechanics.hard_stops = Some(stops);
    run(&mut motor, 0.5, 0.0, |motor| commutated(motor, [0.0, 3.0]));
    assert!((motor.turns() - 1.0).abs() < 1e-9, "{}", motor.turns());
    let torque_nm = motor.parameters.torque_nm(0.0, 3.0 / motor.parameters.resistance_ohm);
    assert!((motor.torque_nm / torque_nm - 1.0).abs() < 0.01, "it pushes with {} Nm", motor.torque_nm);
    let Energy { electrical_pj, copper_pj, friction_pj, .. } = motor.energy;
    let used_j = joules(copper_pj + friction_pj) + motor.stored_j();
    assert!((used_j / joules(electrical_pj) - 1.0).abs() < 1e-3, "{:?}", motor.energy);
}

#[test]
fn at_rest_nothing_changes_and_rest_is_the_same_as_stepping() {
    let mut motor = motor(preset(), 5e-3, 1e-4);
    let bridge = Bridge::Driven { voltage_alpha_beta_v: [0.5, 0.9] };
    let restless = (0..200_000).take_while(|_| motor.advance(bridge, 0.01, DT_S)).count();
    assert!(restless < 100_000, "it comes to rest after {restless} steps");
    let mut rested = motor.clone();
    for _ in 0..1000 {
        assert!(!motor.advance(bridge, 0.01, DT_S));
    }
    rested.rest(1000);
    assert_eq!(rested, motor);
    assert!(motor.copper_power_w(DT_S) > 0.1 && motor.electrical_power_w(DT_S) > 0.1);
    for _ in 0..10_000 {
        motor.advance(FLOATING, 0.0, DT_S);
    }
    assert!(!motor.advance(FLOATING, 0.0, DT_S));
    assert_eq!((motor.velocity_rad_s, motor.phase_currents_a()), (0.0, [0.0; 3]));
}

#[test]
fn it_turns_the_same_way_from_everywhere() {
    for periods in [0.0, 0.37, -0.81, 1e6 + 0.5] {
        let mut motor = motor(preset(), 0.0, 1e-5);
        motor.place(RotorAngle::from_turns(periods / 4.0, 4.0));
        run(&mut motor, 0.2, 0.0, |motor| commutated(motor, [0.0, 5.0]));
        let turned = motor.turns() - periods / 4.0;
        assert!((3.0..30.0).contains(&turned), "{turned} turns from {periods}");
        let back_emf_v =
            motor.parameters.pole_pairs * motor.parameters.flux_linkage_wb * motor.velocity_rad_s;
        assert!((back_emf_v / 5.0 - 1.0).abs() < 0.1, "{back_emf_v} V");
        assert!((Direction::of(FRAC_PI_2).to_stator([0.0, 1.0])[0] + 1.0).abs() < 1e-12);
    }
}

/// With the wire to a phase off, two phases carry one current: V / (2 R) of what stands between them, and none the third.
#[test]
fn with_a_phase_open_the_other_two_carry_one_current() {
    for open_phase in 0..3 {
        let mut motor = motor(preset(), 1000.0, 0.0);
        run(&mut motor, 0.01, 0.0, |_| Bridge::Driven { voltage_alpha_beta_v: [1.0, 0.5] });
        assert!(motor.phase_currents_a().into_iter().all(|current_a| current_a.abs() > 0.1));
        let terminals_v = [3.0, 1.0, -2.0];
        let voltage_alpha_beta_v = frame::vector_of(terminals_v);
        run(&mut motor, 0.05, 0.0, |_| Bridge::DrivenOpen { open_phase, voltage_alpha_beta_v });
        let [first, second] = [(open_phase + 1) % 3, (open_phase + 2) % 3];
        let expected_a = (terminals_v[first] - terminals_v[second]) / (2.0 * motor.parameters.resistance_ohm);
        let currents_a = motor.phase_currents_a();
        assert!(currents_a[open_phase].abs() < 1e-9, "{currents_a:?}");
        assert!((currents_a[first] - expected_a).abs() < 1e-6, "{currents_a:?}, not {expected_a}");
        assert!((currents_a[second] + expected_a).abs() < 1e-6, "{currents_a:?}");
        let copper_w = 2.0 * motor.parameters.resistance_ohm * expected_a * expected_a;
        assert!((motor.copper_power_w(DT_S) / copper_w - 1.0).abs() < 1e-6);
        assert!((motor.electrical_power_w(DT_S) / copper_w - 1.0).abs() < 1e-6, "at rest all of it is heat");
    }
}

#[test]
fn an_open_phase_keeps_its_current_at_zero_while_the_motor_turns() {
    let mut motor = motor(preset(), 1e-3, 1e-5);
    motor.velocity_rad_s = 200.0;
    for step in 0..2000 {
        let angle_rad = f64::from(step) * 0.01;
        let voltage_alpha_beta_v = [3.0 * libm::cos(angle_rad), 3.0 * libm::sin(angle_rad)];
        motor.advance(Bridge::DrivenOpen { open_phase: 1, voltage_alpha_beta_v }, 0.0, DT_S);
        assert!(motor.phase_currents_a()[1].abs() < 1e-3, "{:?}", motor.phase_currents_a());
    }
}

/// However fast a load drags it, the equations stay bounded.
#[test]
fn a_rotor_that_a_load_drags_along_does_not_run_away_numerically() {
    let mut motor = motor(preset(), 1e-3, 1e-3);
    run(&mut motor, 0.5, 5.0, |_| Bridge::Driven { voltage_alpha_beta_v: [0.0; 2] });
    let limit_rad_s = 5.0 / 1e-3;
    assert!((0.9 * limit_rad_s..limit_rad_s).contains(&motor.velocity_rad_s), "{}", motor.velocity_rad_s);
    let short_circuit_a = motor.parameters.flux_linkage_wb / motor.parameters.d_inductance_h;
    assert!((libm::hypot(motor.current_d_a, motor.current_q_a) / short_circuit_a - 1.0).abs() < 0.02);
}
