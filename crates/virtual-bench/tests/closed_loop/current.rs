//! Current regulation in closed loop: AP 113 to 123 and 236 (TMCM-1311 §8.8; decisions 2a.6, 2a.7, 5.14), judged by the coils;
//! and that no sequence of commands makes more flow than is allowed.

use std::f64::consts::SQRT_2;

use crate::common::closed_loop::{Axis, MOTOR, amplitude_a, bench, full_torque_nm, rms_a, try_initialize};
use crate::common::{Module, TICKS_PER_MS, TURN};
use proptest::prelude::*;
use tmcl_tables::tmcm_1311::{AxisParameter as Ap, SPEC};
use tmcl_tables::{Command, Status};

/// The factor follows its target at once.
const PROMPT: [(Ap, i32); 2] = [(Ap::CurrentScaleIncrementDelay, 0), (Ap::CurrentScaleDecrementDelay, 0)];

/// The amplitude that AP 6 and AP 123 stand for.
fn commanded_a(max_current: i32, scale: i32) -> f64 {
    SQRT_2 * rms_a(max_current) * f64::from(scale + 1) / 256.0
}

#[track_caller]
fn assert_flows(axis: &mut Axis, max_current: i32, what: &str) {
    let scale = axis.gap(Ap::ActualCurrentScale);
    let (flows, commanded) = (amplitude_a(axis), commanded_a(max_current, scale));
    // The chip's current vector has 248 steps.
    let tolerance = 0.02 * commanded + SQRT_2 * rms_a(max_current) / 248.0;
    assert!(
        (flows - commanded).abs() < tolerance,
        "{what}: {flows:.4} A flow, AP 123 = {scale} means {commanded:.4}"
    );
}

/// The target factor for an error, as a straight line between the limits.
fn line(error: f64, [min, max, lower, upper]: [i32; 4]) -> f64 {
    let [min, max, lower, upper] = [min, max, lower, upper.max(lower + 1)].map(f64::from);
    min + (max - min) * ((error - lower) / (upper - lower)).clamp(0.0, 1.0)
}

/// Held against several torques at rest, the error makes the factor, and the factor the current.
#[test]
fn the_current_follows_the_position_error() {
    for (input, curve) in [
        (0, [31, 223, 10, 110]),
        (0, [15, 255, 0, 255]),
        (1, [15, 255, 0, 255]),
        (1, [63, 200, 100, 2000]),
        (0, [40, 240, 60, 20]),
    ] {
        let file = bench(MOTOR, 40_000, "viscous_nm_s_per_rad = 0.02");
        let mut axis = Axis::on(&file, 40_000, &PROMPT);
        axis.land(8000);
        let [min, max, lower, upper] = curve;
        axis.set_all(&[
            (Ap::CurrentScaleInput, input),
            (Ap::CurrentScaleMin, min),
            (Ap::CurrentScaleMax, max),
            (Ap::CurrentScaleLowerErrorLimit, lower),
            (Ap::CurrentScaleUpperErrorLimit, upper),
            (Ap::StandstillErrorLimit, 100_000),
        ]);
        let gain = if input == 1 { 10.0 } else { 1.0 };
        let slope = gain * f64::from(max - min) / f64::from((upper - lower).max(1));
        let mut scales = Vec::new();
        for load_nm in [0.0, 0.05, 0.1, 0.2, 0.3, -0.15] {
            axis.set("load.torque_nm", load_nm);
            axis.run_ms(600);
            let what = format!("AP 115 = {input}, AP 113, 114, 116, 117 = {curve:?}, {load_nm} Nm");
            let error = (8000.0 - axis.shaft()).abs();
            let reading = axis.gap(Ap::PositionError).abs();
            assert!(
                (f64::from(reading) - error).abs() <= 2.5,
                "{what}: AP 237 = {reading}, the shaft is {error:.1} off"
            );
            let target = axis.gap(Ap::TargetCurrentScale);
            let expected = line(gain * f64::from(reading), curve);
            // An encoder step either way, which the reading rounds.
            assert!(
                (f64::from(target) - expected).abs() <= 1.0 + slope,
                "{what}: AP 236 = {target}; at an error of {reading} it should be {expected:.1}"
            );
            assert_eq!(axis.gap(Ap::ActualCurrentScale), target, "{what}: AP 123 follows at once");
            assert_flows(&mut axis, 128, &what);
            scales.push(target);
        }
        assert!(scales[4] > scales[0], "{curve:?}: more load, more current: {scales:?}");
    }
}

/// While it moves, too: AP 236 fits AP 237 at every instant, and the current AP 123.
#[test]
fn the_current_follows_the_position_error_in_motion() {
    let mut axis = Axis::new(&PROMPT);
    axis.set_all(&[(Ap::CurrentScaleInput, 0), (Ap::CurrentScaleUpperErrorLimit, 150)]);
    axis.go(80_000);
    axis.run_ms(300);
    for _ in 0..500 {
        axis.run_ticks(7);
        let error = f64::from(axis.gap(Ap::PositionError).abs());
        let target = f64::from(axis.gap(Ap::TargetCurrentScale));
        let expected = line(error, [15, 255, 0, 150]);
        assert!(
            (target - expected).abs() <= 1.0 + 2.0 * 1.6,
            "error {error}: AP 236 = {target}, not {expected:.1}"
        );
    }
    axis.reach();
    axis.assert_at(80_000);
}

/// The changes of AP 123 in so many ms: when, in control periods from now, and to what.
fn changes(axis: &mut Axis, ms: u64) -> Vec<(u64, i32)> {
    let mut scale = axis.gap(Ap::ActualCurrentScale);
    let mut changes = Vec::new();
    for tick in 1..=ms * TICKS_PER_MS {
        axis.run_ticks(1);
        let now = axis.gap(Ap::ActualCurrentScale);
        if now != scale {
            scale = now;
            changes.push((tick, now));
        }
    }
    changes
}

/// At rest on the target the error is 0 and AP 113 the target factor: it can be set.
fn at_rest() -> Axis {
    let mut axis = Axis::new(&PROMPT);
    axis.land(8000);
    axis.set_all(&[(Ap::CurrentScaleLowerErrorLimit, 1000), (Ap::CurrentScaleUpperErrorLimit, 2000)]);
    axis.run_ms(50);
    assert_eq!(axis.gap(Ap::ActualCurrentScale), 15, "AP 113 at rest");
    axis
}

#[test]
fn steps_and_delays_are_exact() {
    for (step, delay_ms, target) in [(10, 5, 215), (1, 1, 40), (100, 30, 255), (7, 2, 16 + 70)] {
        let mut axis = at_rest();
        let what = format!("steps of {step} every {delay_ms} ms");
        axis.set_all(&[
            (Ap::CurrentScaleIncrement, step),
            (Ap::CurrentScaleIncrementDelay, delay_ms),
            (Ap::CurrentScaleDecrement, step),
            (Ap::CurrentScaleDecrementDelay, 2 * delay_ms),
        ]);
        axis.run_ms(100);
        for (from, to, delay_ms) in [(15, target, delay_ms), (target, 15, 2 * delay_ms)] {
            axis.sap(Ap::CurrentScaleMin, to);
            let steps = ((to - from).abs() + step - 1) / step;
            let changes = changes(&mut axis, (delay_ms * (steps + 2) + 20) as u64);
            assert_eq!(axis.gap(Ap::TargetCurrentScale), to, "{what}: AP 236");
            let expected: Vec<i32> =
                (1..=steps)
                    .map(|count| {
                        if to > from { (from + count * step).min(to) } else { (from - count * step).max(to) }
                    })
                    .collect();
            let scales: Vec<i32> = changes.iter().map(|(_, scale)| *scale).collect();
            assert_eq!(scales, expected, "{what}, from {from} to {to}");
            let delay = delay_ms as u64 * TICKS_PER_MS;
            for pair in changes.windows(2) {
                assert_eq!(
                    pair[1].0 - pair[0].0,
                    delay,
                    "{what}, from {from} to {to}: ticks between {pair:?}"
                );
            }
            let first = changes[0].0;
            assert!(first <= delay + 2, "{what}, from {from} to {to}: the first step after {first} ticks");
            axis.run_ms(30);
            assert_flows(&mut axis, 128, &what);
        }
    }
}

/// 0 = at once, whatever the step; up and down each have their own.
#[test]
fn a_delay_of_zero_is_none() {
    let mut axis = at_rest();
    axis.sap(Ap::CurrentScaleDecrementDelay, 3);
    axis.sap(Ap::CurrentScaleDecrement, 20);
    axis.sap(Ap::CurrentScaleMin, 215);
    axis.run_ticks(2);
    assert_eq!(axis.gap(Ap::ActualCurrentScale), 215, "up at once");
    axis.sap(Ap::CurrentScaleMin, 15);
    let down = changes(&mut axis, 50);
    assert_eq!(down.len(), 10, "down by 20 every 3 ms: {down:?}");
    axis.sap(Ap::CurrentScaleDecrementDelay, 0);
    axis.sap(Ap::CurrentScaleIncrementDelay, 3);
    axis.sap(Ap::CurrentScaleIncrement, 50);
    axis.sap(Ap::CurrentScaleMin, 215);
    let up = changes(&mut axis, 50);
    assert_eq!(up.len(), 4, "up by 50 every 3 ms: {up:?}");
    axis.sap(Ap::CurrentScaleMin, 15);
    axis.run_ticks(2);
    assert_eq!(axis.gap(Ap::ActualCurrentScale), 15, "down at once");
}

#[test]
fn without_regulation_the_full_current_flows() {
    for max_current in [60, 128, 231] {
        let mut axis = Axis::new(&[(Ap::CurrentScaleEnable, 0), (Ap::MaxCurrent, max_current)]);
        let what = format!("AP 122 = 0, AP 6 = {max_current}");
        axis.land(8000);
        assert_eq!(axis.gap(Ap::ActualCurrentScale), 255, "{what}: AP 123");
        assert_flows(&mut axis, max_current, &what);
        axis.go(60_000);
        axis.run_ms(400);
        assert_eq!(axis.gap(Ap::ActualCurrentScale), 255, "{what}: AP 123 in motion");
        assert_flows(&mut axis, max_current, &what);
        axis.reach();
        axis.sap(Ap::CurrentScaleEnable, 1);
        axis.run_ms(1000);
        let scale = axis.gap(Ap::ActualCurrentScale);
        assert!(scale < 255, "AP 122 = 1 again: AP 123 = {scale} at rest");
        assert_flows(&mut axis, max_current, "AP 122 = 1 again");
    }
}

/// AP 7, 200, 204, 214: none of them acts in closed loop.
#[test]
fn standby_boost_and_freewheeling_belong_to_the_open_loop() {
    let mut axis = Axis::new(&[
        (Ap::CurrentScaleEnable, 0),
        (Ap::StandbyCurrent, 8),
        (Ap::PowerDownDelay, 10),
        (Ap::FreewheelingDelay, 200),
        (Ap::BoostCurrent, 255),
    ]);
    axis.land(20_000);
    axis.run_ms(500);
    assert_flows(&mut axis, 128, "half a second at rest");
    axis.go(0);
    axis.run_ms(100);
    assert_flows(&mut axis, 128, "speeding up");
}

/// RMS current, shaft and a quarter of the full torque at two turns a second.
fn move_at_quarter_load(settings: &[(Ap, i32)]) -> f64 {
    let quarter_nm = full_torque_nm(MOTOR, rms_a(128)) / 4.0;
    let rad_s = 2.0 * std::f64::consts::TAU;
    let file = bench(MOTOR, 40_000, &format!("viscous_nm_s_per_rad = {:.5}", (quarter_nm - 0.01) / rad_s));
    let mut axis = Axis::on(&file, 40_000, &[(Ap::MaxAcceleration, 4 * TURN)]);
    axis.set_all(settings);
    axis.land(0);
    axis.go(400_000);
    let (mut squares, mut ticks, mut readings) = (0.0, 0.0, 0.0);
    let mut torque_nm = 0.0;
    while axis.gap(Ap::PositionReached) == 0 {
        let figures = axis.figures();
        assert!(ticks < 200_000.0, "{settings:?}: never arrives; {figures}");
        axis.run_ticks(1);
        let physical = axis.physical();
        squares += (physical.coil_a_a.powi(2) + physical.coil_b_a.powi(2)) / 2.0;
        readings += f64::from(axis.gap(Ap::MotorCurrent)).powi(2) / 2e6;
        torque_nm += physical.torque_nm;
        ticks += 1.0;
    }
    // 5.5 s of which 4.5 at speed.
    let mean_nm = torque_nm / ticks;
    assert!(mean_nm > 0.75 * quarter_nm, "{mean_nm} Nm are no quarter of the load");
    axis.assert_at(400_000);
    axis.run_ms(300);
    axis.assert_at(400_000);
    assert!((axis.shaft() - 400_000.0).abs() <= 52.0, "steps are lost");
    let rms = f64::sqrt(squares / ticks);
    let read = f64::sqrt(readings / ticks);
    assert!((read / rms - 1.0).abs() < 0.02, "AP 150 makes {read} A RMS, the coils carry {rms}");
    rms
}

#[test]
fn regulation_saves_current_at_a_quarter_of_the_load() {
    let without = move_at_quarter_load(&[(Ap::CurrentScaleEnable, 0)]);
    assert!((without / rms_a(128) - 1.0).abs() < 0.03, "AP 122 = 0: {without} A RMS, AP 6 is {}", rms_a(128));
    let raw = (Ap::CurrentScaleInput, 0);
    for settings in [&[raw][..], &[raw, PROMPT[0]]] {
        let with = move_at_quarter_load(settings);
        assert!(with < 0.6 * without, "{settings:?}: {with:.3} A RMS with regulation, {without:.3} without");
    }
    // At defaults the amplified error asks for more; for less than everything all the same.
    let defaults = move_at_quarter_load(&[]);
    assert!(defaults < without, "defaults: {defaults:.3} A RMS with regulation, {without:.3} without");
}

/// At rest nothing pulls, and next to nothing flows.
#[test]
fn at_rest_the_minimum_flows() {
    for minimum in [15, 100] {
        let mut axis = Axis::new(&PROMPT);
        axis.sap(Ap::CurrentScaleMin, minimum);
        axis.sap(Ap::CurrentScaleLowerErrorLimit, 600);
        axis.sap(Ap::CurrentScaleUpperErrorLimit, 1200);
        axis.land(8000);
        axis.run_ms(500);
        assert_eq!(axis.gap(Ap::ActualCurrentScale), minimum, "AP 123 at rest");
        assert_flows(&mut axis, 128, &format!("AP 113 = {minimum}"));
    }
}

/// Something that a host may do.
#[derive(Clone, Debug)]
enum Action {
    Write(Ap, i32),
    Command(Command, u8, i32),
    /// 0 and 5 of AP 167, off and on.
    Driver(bool),
    ClosedLoop(bool),
    Load(f64),
    PowerCycle,
}

fn actions() -> impl Strategy<Value = Vec<(Action, u64)>> {
    let written = [
        (Ap::MaxCurrent, 255),
        (Ap::MaxCurrent, 255),
        (Ap::StandbyCurrent, 255),
        (Ap::BoostCurrent, 255),
        (Ap::Vsense, 1),
        (Ap::PowerDownDelay, 10),
        (Ap::FreewheelingDelay, 50),
        (Ap::TorqueTargetCurrent, 3000),
        (Ap::TorqueActualCurrent, 3000),
        (Ap::TorqueCurrentSlope, 100_000),
        (Ap::TorqueStartStopCurrent, 3000),
        (Ap::CurrentScaleMin, 255),
        (Ap::CurrentScaleMax, 255),
        (Ap::CurrentScaleInput, 1),
        (Ap::CurrentScaleLowerErrorLimit, 1000),
        (Ap::CurrentScaleUpperErrorLimit, 1000),
        (Ap::CurrentScaleIncrement, 255),
        (Ap::CurrentScaleDecrement, 255),
        (Ap::CurrentScaleIncrementDelay, 5),
        (Ap::CurrentScaleDecrementDelay, 5),
        (Ap::CurrentScaleEnable, 1),
        (Ap::CorrectionVelocityP, 65_535),
        (Ap::MaxFollowingError, 10_000),
        (Ap::MaxCorrectionVelocity, 10 * TURN),
        (Ap::MaxVelocity, 5 * TURN),
        (Ap::MaxAcceleration, 100 * TURN),
        (Ap::StandstillGain, 50),
        (Ap::StandstillDamping, 65_535),
        (Ap::StandstillErrorLimit, 10_000),
        (Ap::FieldWeakeningMinVelocity, 10 * TURN),
        (Ap::FieldWeakeningMaxVelocity, 10 * TURN),
        (Ap::EncoderOffset, 1000),
        (Ap::MaxEncoderDeviation, 10_000),
        (Ap::EncoderResolution, 65_535),
        (Ap::MotorFullSteps, 400),
        (Ap::EncoderInitialization, 1),
        (Ap::RampMode, 2),
        (Ap::CoolstepHysteresisStart, 15),
        (Ap::CoolstepSlowRunCurrent, 255),
        (Ap::CoolstepThresholdVelocity, 5 * TURN),
        (Ap::ActualPosition, 100_000),
        (Ap::EncoderCounter, 100_000),
        (Ap::TargetPosition, 100_000),
    ];
    let write =
        (proptest::sample::select(written.to_vec()), any::<i32>()).prop_map(|((parameter, limit), any)| {
            // Whatever of it the tables allow is valid; the rest is refused.
            let spec = SPEC.axis_parameter(parameter.number()).expect("a parameter");
            let negative = spec.from_wire(-1) < 0
                && matches!(
                    parameter,
                    Ap::TorqueTargetCurrent
                        | Ap::TorqueActualCurrent
                        | Ap::MaxEncoderDeviation
                        | Ap::EncoderOffset
                );
            let size = (i64::from(any).rem_euclid(i64::from(limit) + 1)) as i32;
            Action::Write(parameter, if negative && any < 0 { -size } else { size })
        });
    let motion = prop_oneof![
        (-5 * TURN..5 * TURN).prop_map(|velocity| Action::Command(Command::RotateRight, 0, velocity)),
        (-5 * TURN..5 * TURN).prop_map(|velocity| Action::Command(Command::RotateLeft, 0, velocity)),
        (0..2_u8, -100_000..100_000).prop_map(|(kind, position)| Action::Command(
            Command::MoveToPosition,
            kind,
            position
        )),
        Just(Action::Command(Command::MotorStop, 0, 0)),
        (0..2_u8).prop_map(|kind| Action::Command(Command::ReferenceSearch, kind, 0)),
    ];
    let bench = prop_oneof![
        4 => any::<bool>().prop_map(Action::Driver),
        4 => any::<bool>().prop_map(Action::ClosedLoop),
        2 => (-0.8..0.8).prop_map(Action::Load),
        1 => Just(Action::PowerCycle),
    ];
    let action = prop_oneof![6 => write, 3 => motion, 2 => bench];
    proptest::collection::vec((action, 1..60_u64), 1..40)
}

fn apply(module: &mut Module, action: &Action) {
    let sap = |module: &mut Module, parameter: Ap, value: i32| {
        let status = module.status(Command::SetAxisParameter, parameter.number(), 0, value);
        assert!(
            matches!(status, Status::Ok | Status::InvalidValue | Status::NotAvailable),
            "SAP {parameter:?}, {value}: {status:?}"
        );
    };
    match action {
        Action::Write(parameter, value) => sap(module, *parameter, *value),
        Action::Command(command, kind, value) => {
            module.status(*command, *kind, 0, *value);
        }
        Action::Driver(on) => sap(module, Ap::ChopperOffTime, if *on { 5 } else { 0 }),
        Action::ClosedLoop(on) => sap(module, Ap::ClosedLoopMode, i32::from(*on)),
        Action::Load(load_nm) => module.set("load.torque_nm", load_nm),
        Action::PowerCycle => module.power_cycle(),
    }
}

/// The largest amplitude that the settings allow now: AP 6, in open loop AP 200 too.
fn allowed_a(module: &mut Module) -> f64 {
    let boost = if module.gap(Ap::ClosedLoopMode) == 0 { module.gap(Ap::BoostCurrent) } else { 0 };
    let halves = f64::from(2 - module.gap(Ap::Vsense)) / 2.0;
    SQRT_2 * rms_a(module.gap(Ap::MaxCurrent).max(boost)) * halves
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Whatever is written, in whatever mode: never more than AP 6 (or 200), and nothing with the driver off.
    #[test]
    fn no_sequence_of_writes_exceeds_the_current(closed in any::<bool>(), actions in actions()) {
        // Enough friction that no back EMF comes near the supply and drives currents of its own.
        let mut module = Module::on(&bench(MOTOR, 40_000, "viscous_nm_s_per_rad = 0.02"));
        if closed {
            prop_assert!(try_initialize(&mut module).is_some());
        }
        // How many ms ago this much was allowed: a current takes its time to fall.
        let mut history = [allowed_a(&mut module); 20];
        let mut off_ms = 0;
        for (index, (action, ms)) in actions.iter().enumerate() {
            apply(&mut module, action);
            let (allowed, off) = (allowed_a(&mut module), module.gap(Ap::ChopperOffTime) == 0);
            for elapsed in 0..*ms {
                history.rotate_right(1);
                history[0] = allowed;
                off_ms = if off { off_ms + 1 } else { 0 };
                for _ in 0..4 {
                    module.run_ticks(5);
                    let flows = amplitude_a(&module);
                    let limit = history.iter().copied().fold(0.0, f64::max) * 1.04 + 0.05;
                    prop_assert!(
                        flows <= limit,
                        "{flows:.3} A flow, {limit:.3} are allowed, {elapsed} ms after action {index}, {action:?}"
                    );
                    prop_assert!(
                        off_ms < 30 || flows < 0.02,
                        "{flows:.3} A flow, the driver is off for {off_ms} ms, after action {index}, {action:?}"
                    );
                }
            }
        }
    }
}
