//! Which current flows when (TMCM-1311 §6, AP 6, 7, 179, 200, 204, 214): judged by the coils, to the control period.

use crate::common::{Module, TICKS_PER_MS, TURN};
use proptest::prelude::*;
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

/// The coil amplitude at AP 6 = 255: 3 A RMS.
const FULL_A: f64 = 3.0 * std::f64::consts::SQRT_2;

/// The amplitude that a setting of AP 6, 7 or 200 stands for (decisions 5.7).
fn amplitude_a(setting: i32) -> f64 {
    FULL_A * f64::from(setting / 8 + 1) / 32.0
}

fn measured_a(module: &Module) -> f64 {
    let physical = module.physical();
    physical.coil_a_a.hypot(physical.coil_b_a)
}

#[track_caller]
fn assert_flows(module: &Module, setting: i32) {
    let (measured, expected) = (measured_a(module), amplitude_a(setting));
    assert!((measured / expected - 1.0).abs() < 0.02, "{measured} A, not {expected} A");
}

fn module(settings: &[(Ap, i32)]) -> Module {
    let mut module = Module::new();
    let common = [(Ap::MaxVelocity, 2 * TURN), (Ap::MaxAcceleration, 10 * TURN), (Ap::MaxCurrent, 200)];
    for &(parameter, value) in common.iter().chain(settings) {
        module.sap(parameter, value);
    }
    module
}

/// Runs until the current scale that the chip reports is another one, and returns the ticks that took.
#[track_caller]
fn ticks_to_change(module: &mut Module) -> u64 {
    let before = module.read("coolstep_actual_current");
    for ticks in 1..2_000_000 {
        module.run_ticks(1);
        if module.read("coolstep_actual_current").to_bits() != before.to_bits() {
            return ticks;
        }
    }
    panic!("the current scale stays {before}");
}

#[test]
fn standby_current_flows_two_seconds_after_the_motor_stopped() {
    let mut module = module(&[]);
    module.ok(Command::MoveToPosition, 0, 0, TURN);
    module.arrive();
    module.run_ms(100);
    assert_flows(&module, 200);
    // The landing is behind it by 100 ms; the chip reports in the period after the one in which it is told.
    assert_eq!(ticks_to_change(&mut module), 1900 * TICKS_PER_MS + 2);
    module.run_ms(50);
    assert_flows(&module, 8);
    module.ok(Command::MoveToPosition, 0, 0, 0);
    module.run_ms(20);
    assert_flows(&module, 200);
}

#[test]
fn the_delay_counts_from_power_on_and_from_each_motion_command() {
    let mut module = module(&[(Ap::PowerDownDelay, 5), (Ap::StandbyCurrent, 40)]);
    module.run_ms(10);
    assert_eq!(ticks_to_change(&mut module), 40 * TICKS_PER_MS + 2);
    module.run_ms(50);
    assert_flows(&module, 40);
    // A move to where it stands.
    module.ok(Command::MoveToPosition, 0, 0, 0);
    assert_eq!(ticks_to_change(&mut module), 2, "at once");
    module.run_ms(10);
    assert_flows(&module, 200);
    assert_eq!(ticks_to_change(&mut module), 40 * TICKS_PER_MS);
    // A longer delay counts from the same standstill.
    module.sap(Ap::PowerDownDelay, 100);
    module.run_ms(10);
    assert_flows(&module, 200);
    module.run_ms(1000);
    assert_flows(&module, 40);
}

#[test]
fn boost_flows_while_the_velocity_changes_and_only_then() {
    for (boost, changing) in [(100, 100), (255, 255), (0, 200)] {
        let mut module = module(&[(Ap::BoostCurrent, boost)]);
        module.run_ms(100);
        assert_flows(&module, 200);
        module.ok(Command::MoveToPosition, 0, 0, 2 * TURN);
        module.run_ms(100);
        assert_flows(&module, changing);
        module.run_ms(200);
        assert_flows(&module, 200);
        module.ok(Command::MotorStop, 0, 0, 0);
        module.run_ms(100);
        assert_flows(&module, changing);
        module.run_ms(200);
        assert_flows(&module, 200);
    }
}

/// Acceleration, travel, deceleration, rest: three changes and no flicker, when the velocity says so.
#[test]
fn a_move_changes_between_boost_and_run_three_times() {
    let mut module = module(&[(Ap::BoostCurrent, 255)]);
    module.run_ms(10);
    module.ok(Command::MoveToPosition, 0, 0, TURN);
    let mut scales = vec![25];
    for _ in 0..1500 * TICKS_PER_MS {
        module.run_ticks(1);
        let scale = module.gap(Ap::CoolstepActualCurrent);
        if scales.last() != Some(&scale) {
            scales.push(scale);
        }
    }
    assert_eq!(scales, [25, 31, 25, 31, 25]);
    assert_eq!(module.gap(Ap::PositionReached), 1);
}

#[test]
fn vsense_halves_every_current() {
    let mut module = module(&[(Ap::Vsense, 1), (Ap::BoostCurrent, 255), (Ap::PowerDownDelay, 10)]);
    module.run_ms(50);
    assert!((measured_a(&module) / amplitude_a(200) - 0.5).abs() < 0.01);
    module.run_ms(100);
    assert!((measured_a(&module) / amplitude_a(8) - 0.5).abs() < 0.01);
    module.ok(Command::RotateRight, 0, 0, TURN);
    module.run_ms(50);
    assert!((measured_a(&module) / amplitude_a(255) - 0.5).abs() < 0.01);
}

#[test]
fn freewheeling_cuts_the_current_until_the_next_motion_command() {
    let mut module = module(&[(Ap::FreewheelingDelay, 777), (Ap::PowerDownDelay, 5)]);
    module.ok(Command::MoveToPosition, 0, 0, TURN / 3);
    module.arrive();
    module.run_ms(777);
    assert_flows(&module, 8);
    let held = measured_a(&module);
    module.run_ticks(1);
    assert!(measured_a(&module) < held, "it falls in the first period after the delay");
    module.run_ms(20);
    assert!(measured_a(&module) == 0.0);
    // The shaft is free, and no parameter brings the current back.
    let before = module.turns();
    module.set("load.torque_nm", 0.1);
    module.run_ms(200);
    assert!(module.turns() > before + 0.1);
    module.set("load.torque_nm", 0.0);
    for (parameter, value) in [(Ap::FreewheelingDelay, 0), (Ap::MaxCurrent, 255), (Ap::ActualPosition, 0)] {
        module.sap(parameter, value);
        module.run_ms(20);
        assert!(measured_a(&module) == 0.0, "{parameter:?}");
    }
    module.ok(Command::MotorStop, 0, 0, 0);
    module.run_ms(20);
    assert_flows(&module, 255);
    module.run_ms(5000);
    assert_flows(&module, 8);
}

/// Not every motion begins with a command: where AP 4 was 0, a target may be waiting.
#[test]
fn a_motor_that_moves_has_its_current() {
    let mut module = module(&[(Ap::MaxVelocity, 0), (Ap::FreewheelingDelay, 10)]);
    module.ok(Command::MoveToPosition, 0, 0, TURN);
    module.run_ms(100);
    assert!(measured_a(&module) == 0.0);
    module.sap(Ap::MaxVelocity, TURN);
    module.run_ms(50);
    assert_flows(&module, 200);
}

#[test]
fn no_setting_but_boost_goes_beyond_the_maximum() {
    let mut module = module(&[(Ap::MaxCurrent, 64), (Ap::StandbyCurrent, 255), (Ap::PowerDownDelay, 10)]);
    module.run_ms(200);
    assert_flows(&module, 64);
}

#[test]
fn stored_settings_survive_a_power_cycle_and_the_delay_begins_anew() {
    let mut module =
        module(&[(Ap::StandbyCurrent, 100), (Ap::PowerDownDelay, 30), (Ap::FreewheelingDelay, 500)]);
    for parameter in [Ap::MaxCurrent, Ap::StandbyCurrent, Ap::PowerDownDelay, Ap::FreewheelingDelay] {
        module.ok(Command::StoreAxisParameter, parameter.number(), 0, 0);
    }
    module.run_ms(1000);
    assert!(measured_a(&module) == 0.0);
    module.power_cycle();
    module.run_ms(300);
    assert_flows(&module, 200);
    module.run_ms(190);
    assert_flows(&module, 100);
    module.run_ms(30);
    assert!(measured_a(&module) == 0.0);
}

/// The whole bench after a rest and after going through it period by period.
#[test]
fn resting_is_stepping_across_both_delays() {
    let mut resting =
        module(&[(Ap::PowerDownDelay, 37), (Ap::FreewheelingDelay, 1234), (Ap::BoostCurrent, 240)]);
    resting.ok(Command::MoveToPosition, 0, 0, TURN / 7);
    let mut stepping = resting.clone();
    for ms in [300, 371, 700, 1234, 2000, 4000] {
        resting.bench.advance_to(ms * 1_000_000);
        while stepping.bench.time_ns() < ms * 1_000_000 {
            // A command that changes nothing, or looks at nothing, does not keep the bench from being exact.
            stepping.run_ticks(1);
        }
        assert!(resting.state() == stepping.state(), "at {ms} ms");
    }
}

/// What a host may do to the current.
#[derive(Clone, Debug)]
enum Step {
    Write(Ap, i32),
    Rotate(i32),
    MoveBy(i32),
    Stop,
    Wait(u64),
}

fn step() -> impl Strategy<Value = Step> {
    let currents = [Ap::MaxCurrent, Ap::StandbyCurrent, Ap::BoostCurrent, Ap::CoolstepSlowRunCurrent];
    let small = [Ap::CoolstepHysteresisStart, Ap::CoolstepHysteresis, Ap::ChopperOffTime];
    prop_oneof![
        4 => (proptest::sample::select(currents.to_vec()), 0..=255).prop_map(|(p, v)| Step::Write(p, v)),
        2 => (proptest::sample::select(small.to_vec()), 2..=15).prop_map(|(p, v)| Step::Write(p, v)),
        1 => Just(Step::Write(Ap::ChopperOffTime, 0)),
        1 => (0..=3_i32).prop_map(|v| Step::Write(Ap::PowerDownDelay, v + 1)),
        1 => (0..=60_i32).prop_map(|v| Step::Write(Ap::FreewheelingDelay, v)),
        1 => (0..=2 * TURN).prop_map(|v| Step::Write(Ap::CoolstepThresholdVelocity, v)),
        1 => (0..=2 * TURN).prop_map(|v| Step::Write(Ap::MaxVelocity, v)),
        1 => (-500..=500_i32).prop_map(|v| Step::Write(Ap::MaxEncoderDeviation, v)),
        2 => (-2 * TURN..=2 * TURN).prop_map(Step::Rotate),
        2 => (-TURN..=TURN).prop_map(Step::MoveBy),
        1 => Just(Step::Stop),
        8 => (1..100_u64).prop_map(Step::Wait),
    ]
}

fn perform(module: &mut Module, step: &Step) {
    match *step {
        Step::Write(parameter, value) => module.sap(parameter, value),
        Step::Rotate(velocity) => _ = module.ok(Command::RotateRight, 0, 0, velocity),
        Step::MoveBy(offset) => _ = module.ok(Command::MoveToPosition, 1, 0, offset),
        Step::Stop => _ = module.ok(Command::MotorStop, 0, 0, 0),
        Step::Wait(_) => {}
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The current scale in use never exceeds that of AP 6, or of AP 200 where that is larger, and with the driver off or
    /// the motor freewheeling no coil's current grows.
    #[test]
    fn the_current_never_exceeds_the_maximum_nor_flows_with_the_driver_off(
        steps in proptest::collection::vec(step(), 1..40),
    ) {
        let mut module = module(&[]);
        for step in &steps {
            perform(&mut module, step);
            let limit = module.gap(Ap::MaxCurrent).max(module.gap(Ap::BoostCurrent)) / 8;
            let off = module.gap(Ap::ChopperOffTime) == 0;
            let Step::Wait(ms) = step else { continue };
            // What the chip was told before this step shows for two periods, and freewheeling coils take a while.
            module.run_ticks(2);
            for _ in 0..ms * TICKS_PER_MS {
                let before = measured_a(&module);
                module.run_ticks(1);
                prop_assert!(module.gap(Ap::CoolstepActualCurrent) <= limit);
                let bound = amplitude_a(limit * 8) * 1.02;
                prop_assert!(measured_a(&module) <= before.max(bound), "{} A", measured_a(&module));
                prop_assert!(!off || measured_a(&module) <= before);
            }
        }
    }
}
