//! coolStep: less current under light load, more when the load comes (TMCM-1311 §7, decisions 5.6).

use crate::common::{Module, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

/// The coil amplitude at AP 6 = 255: 3 A RMS.
const FULL_MA: f64 = 4242.6;

/// Full steps, and with them stallGuard2 readings, a second at 3 turns/s.
const READINGS_PER_S: f64 = 600.0;

/// A module with AP 6 = 255 and coolStep above one turn a second: SEMIN 6 raises the current below a reading of 192,
/// SEMAX 2 lowers it from 288 on.
fn cool(settings: &[(Ap, i32)]) -> Module {
    let mut module = Module::new();
    let common = [
        (Ap::MaxVelocity, 20 * TURN),
        (Ap::MaxAcceleration, 10 * TURN),
        (Ap::MaxCurrent, 255),
        (Ap::CoolstepHysteresisStart, 6),
        (Ap::CoolstepHysteresis, 2),
        (Ap::CoolstepUpStep, 3),
        (Ap::CoolstepDownStep, 1),
        (Ap::CoolstepThresholdVelocity, TURN),
    ];
    for &(parameter, value) in common.iter().chain(settings) {
        module.sap(parameter, value);
    }
    module.run_ms(200);
    module
}

/// [`cool`], for a while at `turns_per_s`.
fn cool_turning(turns_per_s: f64, settings: &[(Ap, i32)]) -> Module {
    let mut module = cool(settings);
    module.ok(Command::RotateRight, 0, 0, (turns_per_s * f64::from(TURN)) as i32);
    module.run_ms(2000);
    module
}

/// The mean amplitude of the coil currents over 200 ms.
fn mean_current_ma(module: &mut Module) -> f64 {
    let sum_ma: f64 = (0..4000)
        .map(|_| {
            module.run_ticks(1);
            let physical = module.physical();
            physical.coil_a_a.hypot(physical.coil_b_a) * 1000.0
        })
        .sum();
    sum_ma / 4000.0
}

/// Full steps that the rotor is behind.
fn behind(module: &mut Module) -> f64 {
    (f64::from(module.gap(Ap::ActualPosition)) / f64::from(TURN) - module.turns()) * 200.0
}

/// At rest in the rotating field it is less than a full step behind.
fn is_in_step(module: &mut Module) -> bool {
    behind(module).abs() < 1.0
}

#[track_caller]
fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual / expected - 1.0).abs() < tolerance, "{actual} instead of {expected}");
}

#[test]
fn under_light_load_the_current_falls_to_a_half_or_a_quarter() {
    let mut without = cool_turning(3.0, &[(Ap::CoolstepHysteresisStart, 0)]);
    let full_ma = mean_current_ma(&mut without);
    assert_near(full_ma, FULL_MA, 0.01);
    for (quarter_minimum, scale, part) in [(0, 15, 0.5), (1, 7, 0.25)] {
        let mut module = cool_turning(3.0, &[(Ap::CoolstepMinCurrent, quarter_minimum)]);
        assert_eq!(module.gap(Ap::CoolstepActualCurrent), scale);
        assert_near(mean_current_ma(&mut module) / full_ma, part, 0.01);
        assert!(is_in_step(&mut module));
    }
}

#[test]
fn a_load_step_brings_the_current_back_without_losing_a_step() {
    let mut module = cool_turning(3.0, &[]);
    let light_ma = mean_current_ma(&mut module);
    module.set("load.torque_nm", -0.4);
    let (mut highest, mut farthest) = (0, 0.0_f64);
    for _ in 0..1000 {
        module.run_ms(1);
        highest = highest.max(module.gap(Ap::CoolstepActualCurrent));
        farthest = farthest.max(behind(&mut module));
    }
    assert!(farthest < 2.0 && is_in_step(&mut module), "two full steps behind it would fall out: {farthest}");
    assert_eq!(highest, 31, "all there is while the rotor swings");
    let loaded_ma = mean_current_ma(&mut module);
    assert!(loaded_ma > 1.4 * light_ma, "{loaded_ma} mA under load after {light_ma} mA");
    let reading = module.gap(Ap::LoadValue);
    assert!((192..=300).contains(&reading), "it holds the reading in its band: {reading}");

    module.set("load.torque_nm", 0.0);
    module.run_ms(1000);
    assert_near(mean_current_ma(&mut module), light_ma, 0.01);
    assert!(is_in_step(&mut module));
}

/// The same step at the current that coolStep had chosen, without coolStep: more than it can take.
#[test]
fn without_coolstep_the_same_step_stalls_at_the_low_current() {
    let mut module = cool_turning(3.0, &[(Ap::CoolstepHysteresisStart, 0), (Ap::MaxCurrent, 127)]);
    assert_eq!(module.gap(Ap::CoolstepActualCurrent), 15);
    module.set("load.torque_nm", -0.4);
    module.run_ms(1000);
    assert!(!is_in_step(&mut module));
}

#[test]
fn down_step_says_how_many_readings_lower_the_current() {
    for (down_step, readings) in [(0, 32.0), (1, 8.0), (2, 2.0), (3, 1.0)] {
        // At standstill and below AP 182 the current is full; from there on it falls.
        let mut module =
            cool(&[(Ap::CoolstepDownStep, down_step), (Ap::CoolstepThresholdVelocity, 4 * TURN)]);
        module.ok(Command::RotateRight, 0, 0, 3 * TURN);
        module.run_ms(2000);
        assert_eq!(module.gap(Ap::CoolstepActualCurrent), 31);
        module.sap(Ap::CoolstepThresholdVelocity, TURN);
        let mut ticks = 0;
        while module.gap(Ap::CoolstepActualCurrent) > 15 {
            module.run_ticks(1);
            ticks += 1;
        }
        let expected_s = 16.0 * readings / READINGS_PER_S;
        // The first reading may be due at any time.
        let taken_s = f64::from(ticks) * 50e-6;
        assert!(
            (taken_s - expected_s).abs() < 1.5 / READINGS_PER_S + 0.01 * expected_s,
            "{taken_s} s, not {expected_s}"
        );
    }
}

#[test]
fn up_step_says_how_fast_the_current_rises() {
    let mut taken = Vec::new();
    for up_step in 1..=3 {
        let mut module = cool_turning(3.0, &[(Ap::CoolstepUpStep, up_step)]);
        // A threshold that makes the motor look loaded: all readings are 0.
        module.sap(Ap::Stallguard2Threshold, -64);
        let mut ticks = 0;
        while module.gap(Ap::CoolstepActualCurrent) < 31 {
            module.run_ticks(1);
            ticks += 1;
        }
        taken.push(f64::from(ticks) * 50e-6 * READINGS_PER_S);
    }
    for (taken, expected) in taken.iter().zip([8.0, 4.0, 2.0]) {
        assert!((taken - expected).abs() < 1.1, "{taken} readings instead of {expected}");
    }
}

#[test]
fn below_its_velocity_there_is_no_coolstep() {
    for (turns_per_s, scale) in [(2.9, 31), (3.1, 15)] {
        let mut module = cool_turning(turns_per_s, &[(Ap::CoolstepThresholdVelocity, 3 * TURN)]);
        assert_eq!(module.gap(Ap::CoolstepActualCurrent), scale, "at {turns_per_s} turns/s");
        assert_near(mean_current_ma(&mut module), FULL_MA * f64::from(scale + 1) / 32.0, 0.01);
    }
    // On the way down the full current is back as soon as the velocity is reached.
    let mut module = cool_turning(3.0, &[]);
    assert_eq!(module.gap(Ap::CoolstepActualCurrent), 15);
    module.ok(Command::MotorStop, 0, 0, 0);
    while module.gap(Ap::ActualVelocity) > TURN {
        module.run_ticks(1);
    }
    module.run_ticks(1);
    assert_eq!(module.gap(Ap::CoolstepActualCurrent), 31);
}

#[test]
fn the_slow_run_current_flows_below_the_velocity_once_all_three_are_set() {
    let slow = (Ap::CoolstepSlowRunCurrent, 63); // CS 7
    for (also, scale) in [
        ((Ap::MaxCurrent, 255), 7),
        ((Ap::CoolstepHysteresisStart, 0), 31),
        ((Ap::CoolstepThresholdVelocity, 0), 15),
        ((Ap::CoolstepSlowRunCurrent, 0), 31),
    ] {
        let mut module = cool_turning(0.5, &[slow, (Ap::Stallguard2Threshold, 30), also]);
        module.run_ms(2000);
        assert_eq!(module.gap(Ap::CoolstepActualCurrent), scale, "with {also:?}");
        assert_near(mean_current_ma(&mut module), FULL_MA * f64::from(scale + 1) / 32.0, 0.01);
    }
}

#[test]
fn no_current_is_saved_with_semin_0() {
    let mut module = cool_turning(3.0, &[(Ap::CoolstepHysteresisStart, 0), (Ap::Stallguard2Threshold, 63)]);
    assert!(module.gap(Ap::LoadValue) > 900);
    assert_eq!(module.gap(Ap::CoolstepActualCurrent), 31);
}
