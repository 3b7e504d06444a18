//! Position maintenance at standstill: AP 136 to 138, bit 12 of AP 18 (TMCM-1311 §8.5; decisions 5.13, 5.14), judged by the
//! shaft that is pushed.

use std::f64::consts::TAU;

use crate::common::TURN;
use crate::common::closed_loop::{Axis, MOTOR, bench, bit, full_torque_nm, rms_a};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

/// A sudden push at the default AP 120 may run away (decision 5.14).
const PROMPT: (Ap, i32) = (Ap::CurrentScaleIncrementDelay, 0);

const WINDOW: f64 = 50.0;

/// Reached, held: bits 0 and 12, and AP 8.
#[track_caller]
fn assert_holds(axis: &mut Axis, what: &str) {
    let figures = axis.figures();
    assert_eq!(axis.gap(Ap::PositionReached), 1, "{what}: AP 8; {figures}");
    assert!(axis.status_bit(bit::REACHED), "{what}: bit 0 of AP 18; {figures}");
    assert!(axis.status_bit(bit::HOLD), "{what}: bit 12 of AP 18; {figures}");
}

fn resting(load: &str, settings: &[(Ap, i32)]) -> Axis {
    let mut axis = Axis::on(&bench(MOTOR, 40_000, load), 40_000, &[PROMPT]);
    axis.set_all(settings);
    axis.land(10_000);
    assert_holds(&mut axis, "landed");
    axis
}

#[test]
fn bit_12_is_set_at_rest_only() {
    let mut axis = resting("", &[]);
    axis.go(30_000);
    assert!(!axis.status_bit(bit::HOLD), "after a motion command");
    axis.run_ms(300);
    assert!(!axis.status_bit(bit::HOLD), "while it moves");
    axis.reach();
    assert_holds(&mut axis, "landed again");
    axis.rotate(TURN);
    assert!(!axis.status_bit(bit::HOLD), "in velocity mode");
    axis.run_ms(500);
    assert!(!axis.status_bit(bit::HOLD), "turning");
}

#[test]
fn a_push_inside_the_limit_returns_without_a_ramp() {
    for gain in [10, 20] {
        for load_nm in [0.05, 0.12, -0.12] {
            let mut axis = resting("", &[(Ap::StandstillGain, gain)]);
            let what = format!("AP 136 = {gain}, {load_nm} Nm");
            let virtual_position = axis.gap(Ap::VirtualPosition);
            for phase_nm in [load_nm, 0.0] {
                axis.set("load.torque_nm", phase_nm);
                for _ in 0..50 {
                    axis.run_ms(10);
                    assert_holds(&mut axis, &what);
                    let off = axis.shaft() - 10_000.0;
                    assert!(off.abs() < 199.0, "{what}: {off} encoder steps are beyond AP 138");
                    axis.assert_agrees();
                    assert_eq!(axis.gap(Ap::ActualVelocity), 0, "{what}: the ramp generator rests");
                    let moved = axis.gap(Ap::VirtualPosition) - virtual_position;
                    assert!(moved.abs() <= 1, "{what}: AP 233 moved by {moved}");
                }
            }
            axis.assert_at(10_000);
        }
    }
}

/// A slip of a full step (256 µsteps) inside a limit that is wider: the torque brings it back at once, not the ramp, which
/// is set to take many seconds for it.
#[test]
fn a_slip_inside_the_limit_returns_at_once() {
    let mut axis =
        resting("viscous_nm_s_per_rad = 0.01", &[(Ap::StandstillErrorLimit, 1000), (Ap::StandstillGain, 10)]);
    axis.sap(Ap::MaxVelocity, 100);
    for slip in [1, -1] {
        axis.set("fault.dropped_steps", slip);
        for _ in 0..200 {
            axis.run_ms(1);
            assert!(axis.status_bit(bit::HOLD), "slip of {slip}: bit 12 stays; {}", axis.figures());
            assert_eq!(axis.gap(Ap::PositionReached), 1, "slip of {slip}: AP 8 stays");
        }
        let off = axis.shaft() - 10_000.0;
        assert!(
            off.abs() <= WINDOW + 2.0,
            "200 ms after a slip of {slip} full steps: {off} encoder steps off"
        );
    }
}

/// Beyond AP 138 the flags clear, and the shaft returns at the ramp's speed.
#[test]
fn beyond_the_limit_it_returns_by_the_ramp() {
    for (steps, velocity) in [(80, TURN / 2), (-80, TURN / 2), (40, TURN / 8)] {
        let mut axis = resting("", &[(Ap::MaxVelocity, velocity), (Ap::MaxAcceleration, 4 * TURN)]);
        axis.run_ms(200);
        let what = format!("slip of {steps} full steps, AP 4 = {velocity}");
        axis.set("fault.dropped_steps", steps);
        axis.run_ticks(3);
        let figures = axis.figures();
        assert_eq!(axis.gap(Ap::PositionReached), 0, "{what}: AP 8 clears; {figures}");
        assert!(
            !axis.status_bit(bit::REACHED) && !axis.status_bit(bit::HOLD),
            "{what}: bits clear; {figures}"
        );
        let turns = f64::from(steps) / 200.0;
        // Half-way by the ramp, its ends apart.
        let travel_ms = turns.abs() * f64::from(TURN) / f64::from(velocity) * 1000.0;
        axis.run_ms((travel_ms * 0.3) as u64);
        let rpm = axis.mean((travel_ms * 0.3 * 20.0) as u64, |axis| axis.physical().velocity_rpm);
        let expected = -turns.signum() * f64::from(velocity) / f64::from(TURN) * 60.0;
        assert!(
            (rpm / expected - 1.0).abs() < 0.05,
            "{what}: it returns at {rpm:.2} rpm, AP 4 is {expected:.2}"
        );
        let ms = axis.reach() as f64 / 20.0 + 0.6 * travel_ms;
        assert!(
            (0.8 * travel_ms..travel_ms * 1.3 + 300.0).contains(&ms),
            "{what}: {ms} ms, the ramp has {travel_ms}"
        );
        assert_holds(&mut axis, &what);
        axis.assert_at(10_000);
    }
}

/// A real push, stronger than the motor.
#[test]
fn pushed_away_by_force_it_comes_back() {
    for load_nm in [1.0, -1.0_f64] {
        for settings in [&[][..], &[(Ap::CurrentScaleEnable, 0)]] {
            let mut axis = resting("inertia_kgm2 = 1e-4", settings);
            axis.set("load.torque_nm", load_nm);
            axis.run_ms(25);
            let pushed = axis.shaft() - 10_000.0;
            assert!(pushed * load_nm > 0.0 && pushed.abs() > 250.0, "pushed by {pushed} encoder steps only");
            assert_eq!(axis.gap(Ap::PositionReached), 0, "beyond AP 138: AP 8 clears");
            axis.set("load.torque_nm", 0);
            axis.reach();
            axis.assert_at(10_000);
            axis.run_ms(500);
            assert_holds(&mut axis, "back again");
            axis.assert_at(10_000);
        }
    }
}

/// AP 138 decides, in µsteps.
#[test]
fn the_limit_is_in_microsteps() {
    // 4 full steps are 1024 µsteps and 800 encoder steps.
    for (limit, held) in [(1100, true), (950, false), (100, false)] {
        let mut axis = resting("viscous_nm_s_per_rad = 0.01", &[(Ap::StandstillErrorLimit, limit)]);
        axis.set("fault.dropped_steps", 4);
        axis.run_ticks(3);
        let figures = axis.figures();
        assert_eq!(axis.status_bit(bit::HOLD), held, "1024 µsteps off, AP 138 = {limit}: bit 12; {figures}");
        axis.run_ms(2000);
        axis.assert_at(10_000);
        assert_holds(&mut axis, "back again");
    }
}

/// How far a slowly growing torque pushes the shaft, in µsteps, and how much it swings then, in encoder steps.
fn yield_to(load_nm: f64, settings: &[(Ap, i32)]) -> (f64, f64) {
    let mut axis = resting("", &[(Ap::MaxCurrent, 231)]);
    axis.set_all(settings);
    for percent in 1..=100 {
        axis.set("load.torque_nm", load_nm * f64::from(percent) / 100.0);
        axis.run_ms(5);
    }
    axis.run_ms(500);
    let mean = axis.mean(8000, |axis| (axis.shaft() - 10_000.0) * 1.28);
    let (low, high) = axis.range(4000, |axis| axis.shaft());
    assert_holds(&mut axis, &format!("{load_nm} Nm, {settings:?}"));
    (mean, high - low)
}

/// δ = gain · e / 20 (decision 5.13) at full current, helped by the detent torque, and give or take friction.
fn expected_yield(load_nm: f64, gain: f64) -> f64 {
    let full_nm = full_torque_nm(MOTOR, rms_a(231));
    let torque = |off: f64| {
        let electrical = TAU * off / 1024.0;
        full_nm * (gain / 20.0 * electrical).sin() + 0.035 * (4.0 * electrical).sin()
    };
    let mut off = 0.0;
    while torque(off) < load_nm {
        off += 0.1;
    }
    off
}

#[test]
fn a_higher_gain_is_stiffer() {
    for load_nm in [0.2, -0.2_f64] {
        let yields: Vec<f64> = [(10, 0), (20, 0), (30, 20)]
            .into_iter()
            .map(|(gain, damping)| {
                let (off, swing) =
                    yield_to(load_nm, &[(Ap::StandstillGain, gain), (Ap::StandstillDamping, damping)]);
                let expected = load_nm.signum() * expected_yield(load_nm.abs(), f64::from(gain));
                let what = format!("AP 136 = {gain}, AP 137 = {damping}, {load_nm} Nm");
                assert!(
                    (off - expected).abs() < 4.0 + 0.1 * expected.abs(),
                    "{what}: pushed by {off:.1} µsteps, expected {expected:.1}"
                );
                assert!(swing < 15.0, "{what}: it swings by {swing:.1} encoder steps");
                off.abs()
            })
            .collect();
        assert!(
            yields[0] > 1.3 * yields[1] && yields[1] > 1.2 * yields[2],
            "{load_nm} Nm: µsteps {yields:?}"
        );
    }
}

/// The torque that holds is that of the target position, whichever way the shaft is pushed, and where it was pushed before.
#[test]
fn it_comes_back_to_the_target_and_not_to_where_it_was() {
    let mut axis = resting("friction_nm = 0.02", &[(Ap::StandstillGain, 20)]);
    for load_nm in [0.1, -0.1, 0.15, 0.0, -0.05, 0.0] {
        axis.set("load.torque_nm", load_nm);
        axis.run_ms(400);
    }
    axis.assert_at(10_000);
    let figures = axis.figures();
    assert_eq!(axis.gap(Ap::TargetPosition), 10_000, "{figures}");
    assert_holds(&mut axis, "after many pushes");
}

/// With few counts in a turn the error that the ramp leaves is few counts as well: it has to bring the whole current
/// nevertheless, or a weight that the motor could hold falls for ever.
#[test]
fn a_weight_within_its_strength_is_caught_with_a_coarse_encoder_too() {
    for counts in [1000, 4000] {
        let mut axis = Axis::on(&bench(MOTOR, counts, ""), counts, &[]);
        axis.land(counts / 4);
        // A third of what it can pull at AP 6.
        axis.set("load.torque_nm", -0.2);
        axis.run_ms(4000);
        let off = axis.turns() - axis.zero_turns - 0.25;
        assert!(off.abs() < 0.05, "{counts} counts: {off} turns off");
    }
}

/// Pushed out of standstill, the ramp gives way; what AP 212 says holds all the same.
#[test]
fn an_overload_at_standstill_is_a_deviation() {
    for (limit, flag) in [(5000, 1), (-5000, 1), (0, 0)] {
        let mut axis = resting("", &[(Ap::MaxEncoderDeviation, limit)]);
        axis.set("load.torque_nm", -0.9);
        axis.run_ms(100);
        assert!(axis.shaft() < 0.0, "pushed a quarter of a turn at least");
        assert_eq!(axis.gap(Ap::EncoderDeviationFlag), flag, "AP 212 = {limit}");
    }
}

/// Back on the target, nothing is left of the overload: neither the current nor a deviation.
#[test]
fn an_overload_that_is_over_is_forgotten() {
    let mut axis = resting("inertia_kgm2 = 1e-4", &[]);
    axis.set("load.torque_nm", 1.0);
    axis.run_ms(25);
    axis.set("load.torque_nm", 0);
    axis.reach();
    axis.run_ms(500);
    assert_holds(&mut axis, "back again");
    let scale = axis.gap(Ap::ActualCurrentScale);
    assert!(scale < 150, "AP 123 is {scale} at rest");
    axis.sap(Ap::MaxEncoderDeviation, 300);
    axis.run_ms(100);
    assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0, "AP 207 at rest");
}

/// Standstill takes a load over from the move before it, although AP 136 = 10 makes half the torque of the same error.
#[test]
fn a_lifted_weight_stays_up() {
    for (counts, load_nm) in [(4000, 0.1), (4000, 0.15), (4000, 0.2), (40_000, 0.2)] {
        let mut axis = Axis::on(&bench(MOTOR, counts, ""), counts, &[]);
        axis.land(counts / 10);
        axis.run_ms(300);
        axis.set("load.torque_nm", -load_nm);
        axis.run_ms(3000);
        for _ in 0..300 {
            axis.run_ms(1);
            assert_holds(&mut axis, &format!("{load_nm} Nm, {counts} counts"));
        }
    }
}
