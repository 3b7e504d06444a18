//! Automatic encoder detection: AP 132 (TMCM-1311 §3.2, §6; decision 5.4), against the encoder that is really there.

use crate::common::closed_loop::{Axis, MOTOR, MOTORS, bench, try_initialize};
use crate::common::motion::SLACK;
use crate::common::{Module, TURN};
use proptest::prelude::*;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, Status};

const NONE: i32 = 0;
const UNDER_WAY: i32 = 1;
const COMPLETED: i32 = 2;
const INCORRECT: i32 = 3;

/// An electrical period ahead of the turn.
const TURNS: f64 = 1.02;

/// What a detection came to.
#[derive(Debug)]
struct Outcome {
    state: i32,
    resolution: i32,
    /// From where it stood; and how far it went back at most.
    turned: f64,
    back: f64,
    /// How fast the rotor turned when AP 132 said that it was over.
    rpm: f64,
}

fn module(motor: &str, counts: i32, max_current: i32) -> Module {
    let mut module = Module::on(&bench(motor, counts, ""));
    module.sap(Ap::MaxCurrent, max_current);
    module.run_ms(100);
    module
}

#[track_caller]
fn detect(module: &mut Module) -> Outcome {
    let start = module.turns();
    module.sap(Ap::EncoderInitialization, 1);
    assert_eq!(module.gap(Ap::EncoderInitialization), UNDER_WAY, "AP 132 at once");
    let mut back = 0.0_f64;
    for _ in 0..60_000 {
        let state = module.gap(Ap::EncoderInitialization);
        if state != UNDER_WAY {
            let resolution = module.gap(Ap::EncoderResolution);
            let (turned, rpm) = (module.turns() - start, module.physical().velocity_rpm);
            return Outcome { state, resolution, turned, back, rpm };
        }
        module.run_ms(1);
        back = back.min(module.turns() - start);
    }
    panic!("AP 132 is still 1 after a minute; the shaft turned {}", module.turns() - start)
}

#[track_caller]
fn assert_found(module: &mut Module, counts: i32, what: &str) {
    let outcome = detect(module);
    assert_eq!((outcome.state, outcome.resolution), (COMPLETED, counts), "{what}: {outcome:?}");
    assert!((outcome.turned - TURNS).abs() < SLACK, "{what}: {} turns, not {TURNS}", outcome.turned);
    assert!(outcome.back > -SLACK, "{what}: it went back by {}", outcome.back);
    assert!(outcome.rpm.abs() < 5.0, "{what}: over, yet it turns at {} rpm", outcome.rpm);
    let zeroed = [Ap::TargetPosition, Ap::ActualPosition, Ap::EncoderCounter, Ap::ActualVelocity];
    assert_eq!(zeroed.map(|parameter| module.gap(parameter)), [0; 4], "{what}: AP 0, 1, 209 and 3");
    let at = module.turns();
    module.run_ms(500);
    let moved = module.turns() - at;
    assert!(moved.abs() < SLACK, "{what}: zeroing the counters moved the shaft by {moved} turns");
    assert_eq!(module.gap(Ap::EncoderInitialization), COMPLETED, "{what}: it stays completed");
}

#[test]
fn it_finds_what_is_there() {
    for (motor, max_current) in MOTORS {
        for counts in [1000, 4000, 10_000, 16_384, 40_000] {
            assert_found(&mut module(motor, counts, max_current), counts, &format!("{motor}, {counts}"));
        }
    }
}

#[test]
fn it_finds_the_smallest_and_the_largest() {
    for counts in [404, 65_532] {
        assert_found(&mut module(MOTOR, counts, 128), counts, &format!("{counts}"));
    }
    // Fewer than two steps to a full step, more than AP 210 can hold, and a count that goes nowhere.
    for counts in [4, 200, 396, 65_600, 100_000] {
        let outcome = detect(&mut module(MOTOR, counts, 128));
        assert_eq!(outcome.state, INCORRECT, "{counts} counts: {outcome:?}");
        assert_eq!(outcome.resolution, 40_000, "{counts} counts: AP 210 stays");
    }
}

/// As fast and as slow as it is told, from wherever it stands, after moves and with a load.
#[test]
fn circumstances_do_not_matter() {
    let mut module = Module::on(&bench(MOTOR, 16_384, "torque_nm = -0.1"));
    module.sap(Ap::MaxVelocity, 2 * TURN);
    // Standing by it would not hold this.
    module.sap(Ap::StandbyCurrent, 128);
    module.run_ms(100);
    module.ok(Command::MoveToPosition, 0, 0, -12_345);
    module.run_ms(3000);
    let start = module.turns();
    assert_found(&mut module, 16_384, "against 0.1 Nm");
    assert!((module.turns() - start - TURNS).abs() < SLACK);
    assert_found(&mut module, 16_384, "a second time");
}

#[test]
fn closed_loop_runs_on_what_it_found() {
    for (motor, max_current) in MOTORS {
        for counts in [1000, 4000, 40_000] {
            let mut module = module(motor, counts, max_current);
            detect(&mut module);
            assert!(try_initialize(&mut module).is_some(), "{motor}, {counts}: no closed loop");
            let position = module.gap(Ap::ActualPosition);
            let zero_turns = module.turns() - f64::from(position) / f64::from(counts);
            let mut axis = Axis { module, zero_turns, counts: f64::from(counts) };
            // The default window of 50 would be 18° at 1000 counts.
            axis.sap(Ap::PositionReachedWindow, counts / 200);
            axis.land(counts);
            axis.land(-counts / 2);
        }
    }
}

#[test]
fn a_dead_line_is_seen() {
    for line in ["a", "b"] {
        let mut module = module(MOTOR, 40_000, 128);
        module.sap(Ap::EncoderResolution, 4000);
        module.set("fault.encoder_line", line);
        let outcome = detect(&mut module);
        assert_eq!(outcome.state, INCORRECT, "line {line} is dead: {outcome:?}");
        assert_eq!(outcome.resolution, 4000, "line {line} is dead: AP 210 stays");
        module.set("fault.encoder_line", "none");
        assert_found(&mut module, 40_000, "repaired");
    }
}

#[test]
fn a_blocked_rotor_is_seen() {
    let mut module = module(MOTOR, 40_000, 128);
    module.set("load.friction_nm", 5);
    let outcome = detect(&mut module);
    assert_eq!(outcome.state, INCORRECT, "blocked: {outcome:?}");
    assert_eq!(outcome.resolution, 40_000);
    assert!(outcome.turned.abs() < 1e-6, "it is blocked");
}

#[test]
fn swapped_channels_are_seen() {
    let mut module = Module::on("[[module]]\nkind = \"tmcm-1311\"\n[module.encoder]\ninverted = true\n");
    module.run_ms(100);
    let outcome = detect(&mut module);
    assert_eq!(outcome.state, INCORRECT, "it counts down: {outcome:?}");
    assert_eq!(outcome.resolution, 40_000, "AP 210 stays");
}

#[test]
fn writing_zero_aborts_it() {
    for after_ms in [10, 300, 900] {
        let mut module = module(MOTOR, 16_384, 128);
        assert_eq!(module.gap(Ap::EncoderInitialization), NONE);
        module.sap(Ap::EncoderInitialization, 1);
        module.run_ms(after_ms);
        assert_eq!(module.gap(Ap::EncoderInitialization), UNDER_WAY, "after {after_ms} ms");
        module.sap(Ap::EncoderInitialization, 0);
        assert_eq!(module.gap(Ap::EncoderInitialization), NONE, "aborted after {after_ms} ms");
        module.run_ms(1500);
        let (turned, rpm) = (module.turns(), module.physical().velocity_rpm);
        assert!(rpm.abs() < 1.0, "aborted after {after_ms} ms, it turns at {rpm} rpm 1.5 s later");
        assert_eq!(module.gap(Ap::EncoderResolution), 40_000, "AP 210 stays");
        module.run_ms(1500);
        assert!((module.turns() - turned).abs() < SLACK, "it moves on");
        assert_eq!(module.gap(Ap::EncoderInitialization), NONE);
        assert_found(&mut module, 16_384, "after an abort");
    }
}

#[test]
fn only_zero_and_one_can_be_written() {
    let mut module = Module::new();
    for value in [-1, 2, 3, 4] {
        let status = module.status(Command::SetAxisParameter, Ap::EncoderInitialization.number(), 0, value);
        assert_eq!(status, Status::InvalidValue, "SAP 132, {value}");
    }
    assert_eq!(module.gap(Ap::EncoderInitialization), NONE);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Whatever the encoder's lines, the count is exact.
    #[test]
    fn any_number_of_lines_is_found(lines in 101..16_384_i32) {
        assert_found(&mut module(MOTOR, 4 * lines, 128), 4 * lines, &format!("{lines} lines"));
    }
}
