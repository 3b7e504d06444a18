//! Reported (AP 1), sensed (AP 209) and physical position: they agree in a normal move, and differ as they should when the
//! motor loses steps.

use std::f64::consts::TAU;

use crate::common::{Module, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

/// Coil amplitude at the default AP 6 = 128: CS = 16, so 17/32 of 3 A RMS.
const AMPLITUDE_A: f64 = 17.0 / 32.0 * 3.0 * std::f64::consts::SQRT_2;

/// The torque that this current holds in the default motor, which holds 1.01 Nm at 2.8 A RMS.
const PULL_OUT_NM: f64 = 1.01 / (2.8 * std::f64::consts::SQRT_2) * AMPLITUDE_A;

/// Friction of the default bench.
const FRICTION_NM: f64 = 0.01;
const VISCOUS_NM_S_PER_RAD: f64 = 4e-4;

const FULL_STEPS: f64 = 200.0;
const ENCODER_COUNTS: f64 = 40_000.0;

/// The load angle at which the default motor turns steadily against a torque, besides friction.
fn load_angle_deg(load_nm: f64, turns_per_s: f64) -> f64 {
    let torque_nm = load_nm + FRICTION_NM + VISCOUS_NM_S_PER_RAD * TAU * turns_per_s;
    (torque_nm / PULL_OUT_NM).asin().to_degrees()
}

fn reported_turns(module: &mut Module) -> f64 {
    f64::from(module.gap(Ap::ActualPosition)) / f64::from(TURN)
}

/// Full steps by which the rotor is behind what the module reports.
fn lost_full_steps(module: &mut Module) -> f64 {
    (reported_turns(module) - module.turns()) * FULL_STEPS
}

/// The encoder tells the truth: to two counts, and as it was a control period ago.
#[track_caller]
fn assert_sensed_is_physical(module: &mut Module) {
    let physical = module.turns() * ENCODER_COUNTS;
    let sensed = f64::from(module.gap(Ap::EncoderCounter));
    let since_sampled = module.physical().velocity_rpm.abs() / 60.0 * 50e-6 * ENCODER_COUNTS;
    assert!((sensed - physical).abs() < 2.0 + 1.5 * since_sampled, "sensed {sensed}, physical {physical}");
}

/// The rotor lost whole multiples of four full steps, so many of them, and stands within a tenth of a full step.
#[track_caller]
fn assert_lost_fours(module: &mut Module, fours: std::ops::RangeInclusive<i64>) {
    let lost = lost_full_steps(module);
    let found = (lost / 4.0).round();
    assert!((lost - 4.0 * found).abs() < 0.1, "lost {lost} full steps");
    assert!(fours.contains(&(found as i64)), "lost {lost} full steps, not {fours:?} times four");
    assert_sensed_is_physical(module);
}

/// A module on the default bench with this load, turning to the right at `turns_per_s`, the ramp being over for a second.
fn turning(load: &str, turns_per_s: f64) -> Module {
    let mut module = Module::on(&format!("[[module]]\nkind = \"tmcm-1311\"\n[module.load]\n{load}"));
    module.run_ms(200);
    module.sap(Ap::MaxVelocity, 20 * TURN);
    module.sap(Ap::MaxAcceleration, 10 * TURN);
    module.ok(Command::RotateRight, 0, 0, (turns_per_s * f64::from(TURN)) as i32);
    module.run_ms((turns_per_s * 100.0) as u64 + 1000);
    module
}

/// Stops the ramp and lets the rotor come to rest.
fn stop(module: &mut Module) {
    module.ok(Command::MotorStop, 0, 0, 0);
    module.run_ms(4000);
    assert_eq!(module.gap(Ap::ActualVelocity), 0);
}

#[test]
fn in_a_normal_move_all_three_agree_within_the_load_angle() {
    for (load_nm, turns_per_s) in [(0.0, 0.3), (0.0, 2.0), (0.0, 10.0), (0.2, 0.5), (0.2, 5.0), (0.2, 15.0)] {
        let mut module =
            Module::on(&format!("[[module]]\nkind = \"tmcm-1311\"\n[module.load]\ntorque_nm = -{load_nm}\n"));
        module.run_ms(300);
        module.sap(Ap::MaxVelocity, (turns_per_s * f64::from(TURN)) as i32);
        module.sap(Ap::MaxAcceleration, 10 * TURN);
        let target = TURN * (2 + (4.0 * turns_per_s) as i32);
        module.ok(Command::MoveToPosition, 0, 0, target);
        while module.gap(Ap::PositionReached) == 0 {
            module.run_ms(1);
            let behind_deg = (reported_turns(&mut module) - module.turns()) * 360.0;
            // 90° electrical, where the motor would stall, are one full step.
            assert!(behind_deg.abs() < 1.2, "{behind_deg}° behind at {turns_per_s} turns/s, {load_nm} Nm");
            assert_sensed_is_physical(&mut module);
        }
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualPosition), target);
        // At rest friction may hold it as far off as it can; the detent torque pulls towards the full step.
        let behind_deg = lost_full_steps(&mut module) * 90.0;
        let expected_deg = (load_nm / PULL_OUT_NM).asin().to_degrees();
        assert!((behind_deg - expected_deg).abs() < 6.0, "{behind_deg}° electrical, expected {expected_deg}");
    }
}

#[test]
fn the_load_angle_is_that_of_the_torque() {
    for (load_nm, turns_per_s) in [(0.0, 2.0), (0.2, 0.5), (0.2, 2.0), (0.2, 5.0), (0.35, 5.0), (-0.2, 2.0)] {
        let mut module = turning(&format!("torque_nm = {}", -load_nm), turns_per_s);
        let mut sum_deg = 0.0;
        for _ in 0..20_000 {
            module.run_ticks(1);
            sum_deg += module.physical().load_angle_deg;
        }
        let (mean_deg, expected_deg) = (sum_deg / 20_000.0, load_angle_deg(load_nm, turns_per_s));
        assert!(
            (mean_deg - expected_deg).abs() < 0.5,
            "{mean_deg}° at {turns_per_s} turns/s against {load_nm} Nm, expected {expected_deg}°"
        );
    }
}

#[test]
fn a_slowly_growing_load_pulls_the_rotor_out_at_90_degrees() {
    for turns_per_s in [2.0, 5.0] {
        let load = "torque = { by = \"time\", points = [[2.0, 0.0], [8.0, -0.6]] }";
        let mut module = turning(load, turns_per_s);
        while lost_full_steps(&mut module) < 1.5 {
            module.run_ticks(1);
        }
        let friction_nm = FRICTION_NM + VISCOUS_NM_S_PER_RAD * TAU * turns_per_s;
        let pull_out_nm = -module.physical().load_nm + friction_nm;
        assert!((pull_out_nm / PULL_OUT_NM - 1.0).abs() < 0.03, "{pull_out_nm} Nm at {turns_per_s} turns/s");
    }
}

#[test]
fn a_jam_in_mid_move_costs_as_many_periods_as_the_field_turned() {
    let mut module = Module::on(include_str!("../../../../examples/benches/overload.toml"));
    module.ok(Command::MoveToPosition, 0, 0, 3 * TURN);
    module.run_ms(1490);
    assert!(lost_full_steps(&mut module).abs() < 0.5, "before the jam");
    module.run_ms(110);
    let stuck_turns = module.turns();
    module.run_ms(400);
    assert_eq!(module.turns(), stuck_turns, "stalled at 1.6 s and at 2 s");
    assert_eq!(module.gap(Ap::ActualVelocity), TURN, "but not by the module's account");
    module.arrive();
    module.run_ms(1000);
    assert_eq!(module.gap(Ap::ActualPosition), 3 * TURN, "reported: arrived");
    // Half a second at 50 electrical periods a turn and one turn a second.
    assert_lost_fours(&mut module, 24..=26);
}

/// The rotor swings beyond the new load angle; by the equal area criterion a step of 72 % of the pull-out torque is just
/// too much for it.
#[test]
fn a_load_step_must_stay_well_below_the_pull_out_torque() {
    for (step_nm, stalls) in [(0.3, false), (0.36, false), (0.48, true), (0.9, true)] {
        let mut module = turning("torque_nm = 0.0", 2.0);
        module.set("load.torque_nm", -step_nm);
        module.run_ms(300);
        module.set("load.torque_nm", 0.0);
        module.run_ms(1000);
        stop(&mut module);
        assert_lost_fours(&mut module, if stalls { 1..=i64::MAX } else { 0..=0 });
    }
}

#[test]
fn a_hard_stop_holds_the_rotor_and_the_way_back_starts_from_there() {
    let mut module =
        Module::on("[[module]]\nkind = \"tmcm-1311\"\n[module.load.hard_stops]\nhigh_turns = 0.507\n");
    module.ok(Command::MoveToPosition, 0, 0, TURN);
    while module.gap(Ap::PositionReached) == 0 {
        module.run_ms(1);
        assert!(module.turns() <= 0.507, "through the wall: {}", module.turns());
    }
    module.run_ms(500);
    // 1.0 − 25/50: the last rest position before the wall.
    assert_lost_fours(&mut module, 25..=25);
    module.ok(Command::MoveToPosition, 0, 0, 0);
    module.arrive();
    module.run_ms(500);
    assert_eq!(module.gap(Ap::ActualPosition), 0);
    assert!((module.turns() + 0.5).abs() < 0.001, "{} turns", module.turns());
}

#[test]
fn with_a_coil_open_a_motor_does_not_start() {
    let mut module = Module::new();
    // Between the coils, so that the loss of one pulls the rotor aside.
    module.ok(Command::MoveToPosition, 0, 0, TURN / 400);
    module.run_ms(300);
    module.set("fault.coil_open", "b");
    module.ok(Command::MoveToPosition, 0, 0, 2 * TURN);
    while module.gap(Ap::PositionReached) == 0 {
        module.run_ms(1);
        assert_eq!(module.physical().coil_b_a, 0.0);
        assert!(module.turns().abs() < 0.1, "one coil makes no direction: {}", module.turns());
    }
    assert!(lost_full_steps(&mut module) > 380.0);
    assert_sensed_is_physical(&mut module);
}

#[test]
fn with_a_coil_open_a_slow_motor_falls_out_and_a_fast_one_is_carried_by_its_inertia() {
    for (turns_per_s, falls_out) in [(0.5, true), (5.0, false)] {
        let mut module = turning("torque_nm = 0.0", turns_per_s);
        module.set("fault.coil_open", "b");
        module.run_ms(1000);
        assert_eq!(module.physical().coil_b_a, 0.0);
        module.set("fault.coil_open", "none");
        module.run_ms(1000);
        stop(&mut module);
        assert_lost_fours(&mut module, if falls_out { 1..=i64::MAX } else { 0..=0 });
    }
}

#[test]
fn a_slipped_rotor_is_caught_by_the_nearest_rest_position() {
    for (slipped, settles) in [(-8, -8), (-4, -4), (-3, -4), (-1, 0), (1, 0), (3, 4), (4, 4), (21, 20)] {
        let mut module = Module::new();
        module.run_ms(100);
        module.set("fault.dropped_steps", slipped);
        assert!((module.turns() * FULL_STEPS - f64::from(slipped)).abs() < 1e-6, "at once");
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualPosition), 0, "nobody told the module");
        let fours = i64::from(-settles / 4);
        assert_lost_fours(&mut module, fours..=fours);
    }
}

/// A motor under current needs voltage as it turns faster: the back-EMF at 15 turns/s is 24 V.
#[test]
fn a_dip_of_the_supply_stalls_a_fast_motor_only() {
    for (turns_per_s, dip_v, stalls) in [(15.0, 14.0, false), (15.0, 5.0, true), (0.5, 5.0, false)] {
        let mut module = turning("friction_nm = 0.1", turns_per_s);
        module.set("supply.voltage_v", dip_v);
        module.run_ms(300);
        module.set("supply.voltage_v", 48);
        module.run_ms(500);
        stop(&mut module);
        assert_lost_fours(&mut module, if stalls { 1..=i64::MAX } else { 0..=0 });
    }
}

#[test]
fn without_the_chopper_an_outside_torque_turns_the_shaft() {
    let mut module = Module::new();
    module.run_ms(100);
    module.set("load.torque_nm", 0.05);
    module.run_ms(100);
    assert!(module.turns().abs() < 0.001, "held: {}", module.turns());
    module.sap(Ap::ChopperOffTime, 0);
    module.run_ms(200);
    let physical = module.physical();
    assert_eq!((physical.coil_a_a, physical.coil_b_a), (0.0, 0.0));
    // 0.04 Nm beyond friction on 275 g·cm², against viscous friction: nearly ½·α·t².
    let (rate_per_s, final_rad_s) = (VISCOUS_NM_S_PER_RAD / 275e-7, 0.04 / VISCOUS_NM_S_PER_RAD);
    let expected_rad = final_rad_s * (0.2 - (1.0 - (-0.2 * rate_per_s).exp()) / rate_per_s);
    assert!((physical.rotor_turns * TAU / expected_rad - 1.0).abs() < 0.1, "{} turns", physical.rotor_turns);
    assert_eq!(module.gap(Ap::ActualPosition), 0);
    assert_sensed_is_physical(&mut module);

    module.set("load.torque_nm", 0.0);
    module.run_ms(2000);
    assert_eq!(module.physical().velocity_rpm, 0.0, "friction stops it");
    module.sap(Ap::ChopperOffTime, 5);
    module.run_ms(1000);
    assert_lost_fours(&mut module, i64::MIN..=-100);
}
