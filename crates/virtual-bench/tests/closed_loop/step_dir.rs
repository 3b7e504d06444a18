//! Step/direction mode in closed loop (TMCM-1311 §6, AP 254): judged by the shaft and the coils.
//!
//! A pulse is a µstep of 1/256 full step whatever AP 140 is. The field follows the pulses as it follows the ramp: it waits for
//! an overloaded rotor, and makes up for the lag.

use crate::common::closed_loop::{Axis, MOTOR, amplitude_a, bench, rms_a};
use crate::common::{Module, TURN};
use proptest::prelude::*;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, Status};

/// More than the motor has.
const JAM_NM: f64 = 3.0;

const MAX_CURRENT: i32 = 128;

/// What detent torque and friction make of a target, in turns: a tenth of a full step.
const SLACK: f64 = 1.0 / 2000.0;

/// Virtual position in µsteps (AP 233): what was ordered, to the rounding of an encoder step.
#[track_caller]
fn assert_ordered(axis: &mut Axis, microsteps: i32) {
    let ordered = axis.gap(Ap::VirtualPosition);
    let figures = axis.figures();
    assert!((ordered - microsteps).abs() <= 1, "AP 233 = {ordered}, not {microsteps}; {figures}");
}

/// The shaft turned by so many µsteps since `from`.
#[track_caller]
fn assert_turned(axis: &mut Axis, from: f64, microsteps: i32) {
    let off = axis.turns() - from - f64::from(microsteps) / f64::from(TURN);
    let slack = SLACK + 1.0 / axis.counts;
    let figures = axis.figures();
    assert!(off.abs() < slack, "{off} turns from where {microsteps} pulses lead; {figures}");
}

/// An amplitude that is so much of AP 6, in 1/256.
#[track_caller]
fn assert_flows(axis: &Axis, scale: i32, what: &str) {
    let expected = rms_a(MAX_CURRENT) * std::f64::consts::SQRT_2 * f64::from(scale + 1) / 256.0;
    let flows = amplitude_a(axis);
    assert!((flows - expected).abs() < 0.03 * expected + 0.02, "{what}: {flows} A, not {expected} A");
}

/// At position 0, listening to pulses with ENABLE active.
#[track_caller]
fn listening(counts: i32, mode: i32, settings: &[(Ap, i32)]) -> Axis {
    let mut axis = Axis::on(&bench(MOTOR, counts, ""), counts, &[(Ap::MaxCurrent, MAX_CURRENT)]);
    axis.set_all(&[(Ap::StandstillGain, 20)]);
    axis.set_all(settings);
    axis.land(0);
    axis.set("step_dir.enable", 1);
    axis.sap(Ap::StepDirMode, mode);
    axis.run_ms(50);
    axis
}

/// So many pulses, the sign as the direction, as fast as that; returns after the last.
fn pulse(axis: &mut Axis, pulses: i32, frequency_hz: i32) {
    axis.set("step_dir.frequency_hz", frequency_hz * pulses.signum());
    axis.set("step_dir.pulses", pulses.abs());
    axis.run_ticks(u64::from(pulses.unsigned_abs()) * 20_000 / u64::from(frequency_hz.unsigned_abs()) + 2);
}

#[test]
fn a_pulse_is_a_microstep_whatever_ap_140_is() {
    for counts in [40_000, 4000] {
        for resolution in [8, 4, 0] {
            for mode in 1..=5 {
                let mut axis = listening(counts, mode, &[(Ap::MicrostepResolution, resolution)]);
                let (start, from) = (axis.gap(Ap::VirtualPosition), axis.turns());
                for (pulses, sum) in [(TURN + 100, TURN + 100), (-2 * TURN, 100 - TURN), (7, 107 - TURN)] {
                    pulse(&mut axis, pulses, 40_000);
                    axis.run_ms(400);
                    assert_ordered(&mut axis, start + sum);
                    assert_turned(&mut axis, from, sum);
                    axis.assert_agrees();
                    let target = f64::from(axis.gap(Ap::VirtualPosition)) * axis.counts / f64::from(TURN);
                    let off = f64::from(axis.gap(Ap::TargetPosition)) - target;
                    assert!(off.abs() <= 1.0, "AP 0 is {off} from what was pulsed");
                }
            }
        }
    }
}

/// AP 3 is the pulses' rate and AP 131 the shaft's speed; AP 8 and bit 12 of AP 18 wait for 100 ms without a pulse.
#[test]
fn reached_means_that_no_pulse_came() {
    let mut axis = listening(40_000, 2, &[]);
    axis.set("step_dir.frequency_hz", TURN);
    axis.set("step_dir.pulses", TURN);
    axis.run_ms(500);
    for parameter in [Ap::ActualVelocity, Ap::MeasuredVelocity] {
        let velocity_pps = axis.gap(parameter);
        assert!((velocity_pps - TURN).abs() < TURN / 20, "{parameter:?} = {velocity_pps}");
    }
    assert_eq!((axis.gap(Ap::PositionReached), axis.gap(Ap::TargetVelocity)), (0, 0));
    axis.run_ms(500 + 95);
    assert_eq!(axis.gap(Ap::PositionReached), 0, "a pulse may be late by 100 ms");
    axis.run_ms(20);
    assert_eq!(axis.gap(Ap::PositionReached), 1, "{}", axis.figures());
    assert!(axis.status_bit(crate::common::closed_loop::bit::HOLD));
    assert_eq!((axis.gap(Ap::ActualVelocity), axis.gap(Ap::RampMode)), (0, 0));
    // Standstill mode holds what the pulses ordered: against a push, and after it.
    let ordered = axis.gap(Ap::VirtualPosition);
    axis.set("load.torque_nm", 0.2);
    axis.run_ms(300);
    assert!((f64::from(axis.gap(Ap::ActualPosition)) * 1.28 - f64::from(ordered)).abs() < 128.0);
    axis.set("load.torque_nm", 0);
    axis.run_ms(300);
    assert_ordered(&mut axis, ordered);
    let target = axis.gap(Ap::TargetPosition);
    axis.assert_at(target);
}

/// Beyond AP 138 too: no ramp leads back, and no pulse is forgotten.
#[test]
fn pushed_far_away_it_comes_back() {
    let mut axis = listening(40_000, 2, &[]);
    pulse(&mut axis, TURN / 2, TURN);
    axis.run_ms(300);
    let (ordered, from) = (axis.gap(Ap::VirtualPosition), axis.turns());
    axis.set("load.torque_nm", 1.5);
    axis.run_ms(15);
    assert!((axis.turns() - from).abs() > 0.01, "it is pushed away, by {}", axis.turns() - from);
    axis.set("load.torque_nm", 0);
    axis.run_ms(3000);
    assert_ordered(&mut axis, ordered);
    assert_turned(&mut axis, from, 0);
    assert_eq!(axis.gap(Ap::PositionReached), 1);
}

mod current {
    use super::*;

    #[test]
    fn mode_1_is_regulated_and_the_others_are_not() {
        let regulated = [(Ap::CurrentScaleEnable, 1), (Ap::CurrentScaleMin, 60), (Ap::CurrentScaleMax, 200)];
        for mode in 1..=5 {
            let mut axis = listening(40_000, mode, &regulated);
            axis.run_ms(2000);
            let scale = if mode == 1 { 60 } else { 255 };
            assert_eq!(axis.gap(Ap::ActualCurrentScale), scale, "mode {mode}: AP 123");
            assert_flows(&axis, scale, &format!("mode {mode}, at rest"));
            pulse(&mut axis, TURN / 2, TURN);
            let scale = axis.gap(Ap::ActualCurrentScale);
            if mode == 1 {
                assert!(scale <= 200);
            } else {
                assert_eq!(scale, 255);
            }
            // With AP 254 = 0 as without it ever.
            axis.run_ms(500);
            axis.sap(Ap::StepDirMode, 0);
            axis.run_ms(2000);
            assert_flows(&axis, 60, &format!("after mode {mode}"));
        }
    }

    /// AP 7, 204 and 214 are of the open loop.
    #[test]
    fn nothing_cuts_it_at_rest() {
        let settings = [(Ap::PowerDownDelay, 1), (Ap::FreewheelingDelay, 10), (Ap::StandbyCurrent, 0)];
        for mode in 2..=5 {
            let mut axis = listening(40_000, mode, &settings);
            axis.run_ms(2000);
            assert_flows(&axis, 255, &format!("mode {mode}"));
        }
    }
}

/// Off, the shaft is free, and position and target go along; pulses are lost. On again, it holds where it is.
#[test]
fn enable_switches_the_motor_off_and_on() {
    for mode in [1, 4, 5] {
        let mut axis = listening(40_000, mode, &[]);
        pulse(&mut axis, TURN / 4, TURN);
        axis.run_ms(300);
        axis.set("step_dir.enable", 0);
        axis.run_ms(50);
        assert!(amplitude_a(&axis) < 0.001, "mode {mode}: {} A", amplitude_a(&axis));
        let held = axis.turns();
        pulse(&mut axis, TURN / 4, TURN);
        axis.set("load.torque_nm", 0.1);
        for _ in 0..10 {
            axis.run_ms(20);
            axis.assert_agrees();
            assert_eq!(axis.gap(Ap::TargetPosition), axis.gap(Ap::ActualPosition));
            assert_eq!((axis.gap(Ap::PositionError), axis.gap(Ap::PositionReached)), (0, 0));
        }
        assert!(axis.turns() > held + 0.1, "mode {mode}: free");
        axis.set("load.torque_nm", 0.0);
        axis.run_ms(2000);
        let coasted = axis.turns();
        axis.set("step_dir.enable", 1);
        axis.run_ms(1000);
        assert!(
            (axis.turns() - coasted).abs() < SLACK,
            "mode {mode}: it holds where it is; {}",
            axis.figures()
        );
        assert!(amplitude_a(&axis) > 0.1);
        assert_eq!(axis.gap(Ap::PositionReached), 1, "mode {mode}; {}", axis.figures());
        let from = axis.gap(Ap::VirtualPosition);
        pulse(&mut axis, TURN / 4, TURN);
        axis.run_ms(400);
        assert_ordered(&mut axis, from + TURN / 4);
        assert_turned(&mut axis, coasted, TURN / 4);
    }
}

/// A shaft that turns when the driver comes back is caught, and held from there on.
#[test]
fn switched_on_while_the_shaft_turns_it_brakes() {
    let mut axis = listening(40_000, 4, &[]);
    axis.set("step_dir.enable", 0);
    axis.set("load.torque_nm", 0.3);
    axis.run_ms(30);
    axis.set("load.torque_nm", 0);
    assert!(axis.physical().velocity_rpm > 20.0, "{}", axis.figures());
    axis.set("step_dir.enable", 1);
    let caught = axis.turns();
    axis.run_ms(2000);
    let moved = axis.turns() - caught;
    assert!(moved.abs() < 4.0 / 200.0, "{moved} turns");
    assert_eq!(axis.gap(Ap::PositionReached), 1, "{}", axis.figures());
    axis.assert_agrees();
}

#[test]
fn modes_2_and_3_have_no_enable() {
    for mode in [2, 3] {
        let mut axis = listening(40_000, mode, &[]);
        let from = axis.turns();
        axis.set("step_dir.enable", 0);
        pulse(&mut axis, TURN / 4, TURN);
        axis.run_ms(300);
        assert_turned(&mut axis, from, TURN / 4);
        assert_flows(&axis, 255, &format!("mode {mode}"));
    }
}

/// The pulses go on while the shaft is jammed; the field never gets further ahead than a full step, and all is made up for.
#[test]
fn an_overload_loses_no_pulse() {
    for direction in [1, -1] {
        let mut axis = listening(40_000, 2, &[]);
        let (from, start) = (axis.turns(), axis.gap(Ap::VirtualPosition));
        axis.set("step_dir.frequency_hz", direction * TURN);
        axis.set("step_dir.pulses", 2 * TURN);
        axis.run_ms(500);
        let jammed = axis.turns();
        axis.set("load.friction_nm", JAM_NM);
        axis.run_ms(50);
        let (least, most) = axis.range(14_000, |axis| axis.physical().load_angle_deg);
        let ahead = if direction == 1 { most } else { -least };
        assert!((80.0..95.0).contains(&ahead), "the field waits 90° ahead, not {ahead}");
        assert!((axis.turns() - jammed).abs() < 0.02, "jammed");
        let lag = f64::from(axis.gap(Ap::PositionError)) / 40_000.0 * f64::from(direction);
        assert!((0.7..0.8).contains(&lag), "AP 237 says a lag of {lag} turns after 750 ms");
        axis.set("load.friction_nm", 0.01);
        let angles = axis.range(40_000, |axis| axis.physical().load_angle_deg);
        assert!(angles.0 > -100.0 && angles.1 < 100.0, "{angles:?}");
        assert_ordered(&mut axis, start + direction * 2 * TURN);
        assert_turned(&mut axis, from, direction * 2 * TURN);
        assert_eq!(axis.gap(Ap::PositionReached), 1, "{}", axis.figures());
    }
}

mod commands {
    use super::*;

    const SAP: Command = Command::SetAxisParameter;

    #[test]
    fn it_needs_a_motor_at_rest_to_begin() {
        let mut axis = Axis::new(&[]);
        axis.rotate(TURN);
        for ms in [0, 300] {
            axis.run_ms(ms);
            assert_eq!(axis.status(SAP, 254, 0, 2), Status::InvalidValue, "after {ms} ms");
        }
        axis.rotate(0);
        axis.run_ms(500);
        axis.sap(Ap::TorqueTargetCurrent, 300);
        axis.run_ms(300);
        assert_eq!(axis.status(SAP, 254, 0, 2), Status::InvalidValue, "torque turns it");
        axis.sap(Ap::TorqueTargetCurrent, 0);
        axis.run_ms(5000);
        axis.rotate(0);
        axis.run_ms(500);
        axis.go(400_000);
        assert_eq!(axis.status(SAP, 254, 0, 2), Status::InvalidValue, "about to move");
        axis.rotate(0);
        axis.run_ms(500);
        axis.ok(Command::ReferenceSearch, 0, 0, 0);
        axis.run_ms(100);
        assert_eq!(axis.status(SAP, 254, 0, 2), Status::InvalidValue, "it searches");
        axis.ok(Command::ReferenceSearch, 1, 0, 0);
        axis.run_ms(1000);
        assert_eq!(axis.status(SAP, 254, 0, 2), Status::Ok);
        axis.set("step_dir.frequency_hz", 10_000);
        axis.run_ms(100);
        assert_eq!(axis.status(SAP, 254, 0, 3), Status::Ok, "pulses are no hindrance");
        assert_eq!(axis.status(SAP, 254, 0, 0), Status::Ok);
        axis.run_ms(500);
        let from = axis.turns();
        axis.run_ms(500);
        assert_turned(&mut axis, from, 0);
    }

    #[test]
    fn what_the_ramp_would_do_is_not_available() {
        let mut axis = listening(40_000, 2, &[]);
        let from = axis.turns();
        for (command, kind, value) in [
            (Command::RotateRight, 0, 1000),
            (Command::RotateLeft, 0, 1000),
            (Command::MoveToPosition, 0, 1000),
            (Command::MoveToPosition, 1, 1000),
            (Command::MoveToPosition, 2, 1),
            (SAP, 0, 1000),
            (SAP, 2, 1000),
            (SAP, 14, 100),
            (SAP, 128, 0),
            (SAP, 128, 1),
            (SAP, 128, 2),
            (SAP, 132, 1),
            (Command::ReferenceSearch, 0, 0),
        ] {
            assert_eq!(axis.status(command, kind, 0, value), Status::NotAvailable, "{command:?} {kind}");
        }
        axis.run_ms(1000);
        assert_turned(&mut axis, from, 0);
        axis.sap(Ap::StepDirMode, 0);
        axis.land(10_000);
    }

    #[test]
    fn mst_makes_it_deaf() {
        let mut axis = listening(40_000, 2, &[]);
        axis.set("step_dir.frequency_hz", TURN);
        axis.run_ms(500);
        axis.ok(Command::MotorStop, 0, 0, 0);
        let stopped = axis.turns();
        axis.run_ms(1000);
        assert!((axis.turns() - stopped).abs() < 4.0 / 200.0, "{} turns", axis.turns() - stopped);
        assert_eq!(
            (axis.gap(Ap::ActualVelocity), axis.gap(Ap::PositionReached)),
            (0, 1),
            "{}",
            axis.figures()
        );
        axis.set("step_dir.frequency_hz", 0);
        axis.sap(Ap::StepDirMode, 2);
        axis.run_ms(20);
        let (from, ordered) = (axis.turns(), axis.gap(Ap::VirtualPosition));
        pulse(&mut axis, 1000, TURN);
        axis.run_ms(300);
        assert_ordered(&mut axis, ordered + 1000);
        assert_turned(&mut axis, from, 1000);
    }

    #[test]
    fn the_position_can_be_called_something_else() {
        let mut axis = listening(40_000, 2, &[]);
        pulse(&mut axis, TURN / 4, TURN);
        axis.run_ms(300);
        let from = axis.turns();
        for parameter in [Ap::ActualPosition, Ap::EncoderCounter] {
            axis.sap(parameter, -1000);
            axis.run_ms(300);
            assert_turned(&mut axis, from, 0);
            assert!((axis.gap(Ap::ActualPosition) + 1000).abs() <= 3);
        }
        pulse(&mut axis, TURN / 4, TURN);
        axis.run_ms(300);
        assert_turned(&mut axis, from, TURN / 4);
        assert!((axis.gap(Ap::ActualPosition) - 9000).abs() <= 25);
    }

    /// AP 129 goes on and off in the mode, at rest; what a pulse is worth changes with it.
    #[test]
    fn the_loop_closes_and_opens_in_the_mode() {
        let mut module = Module::on(&bench(MOTOR, 40_000, ""));
        module.sap(Ap::MicrostepResolution, 4);
        module.sap(Ap::MaxCurrent, MAX_CURRENT);
        module.sap(Ap::StepDirMode, 2);
        let (low_hz, high_hz) = (1600, 25_600);
        let turn = |module: &mut Module, frequency_hz: i32| {
            let from = module.turns();
            module.set("step_dir.frequency_hz", frequency_hz);
            module.set("step_dir.pulses", frequency_hz / 2);
            module.run_ms(300);
            let status = module.status(SAP, 129, 0, 1 - module.read("closed_loop_mode") as i32);
            module.run_ms(200 + 500);
            (module.turns() - from, status)
        };
        let (turned, status) = turn(&mut module, low_hz);
        assert!((turned - 0.25).abs() < SLACK, "{turned} turns, 16 µsteps a full step");
        assert_eq!(status, Status::InvalidValue, "pulses move it");
        assert!(crate::common::closed_loop::try_initialize(&mut module).is_some());
        module.run_ms(500);
        let position = module.gap(Ap::ActualPosition);
        assert!((f64::from(position) / 40_000.0 - module.turns()).abs() < 2.0 / 200.0, "AP 1 = {position}");
        let (turned, status) = turn(&mut module, high_hz);
        assert!((turned - 0.25).abs() < 2.0 * SLACK, "{turned} turns, 256 µsteps a full step");
        assert_eq!(status, Status::InvalidValue, "pulses move it");
        module.sap(Ap::ClosedLoopMode, 0);
        module.run_ms(500);
        assert_eq!((module.gap(Ap::ClosedLoopMode), module.gap(Ap::StepDirMode)), (0, 2));
        let (turned, _) = turn(&mut module, low_hz);
        assert!((turned - 0.25).abs() < 2.0 * SLACK, "{turned} turns, 16 µsteps a full step again");
    }
}

mod stops {
    use super::*;

    #[test]
    fn a_stop_switch_lets_through_what_leads_away() {
        for sign in [1, -1] {
            let switches = "[module.switches]\nleft = { at_turns = -0.25 }\nright = { at_turns = 0.25 }\n";
            let mut axis = Axis::on(&format!("{}{switches}", bench(MOTOR, 40_000, "")), 40_000, &[]);
            axis.sap(Ap::StepDirMode, 2);
            pulse(&mut axis, sign * TURN / 2, 10_000);
            axis.run_ms(300);
            let at_switch = axis.turns();
            assert!((at_switch * f64::from(sign) - 0.25).abs() < 0.002, "{at_switch}");
            let ordered = axis.gap(Ap::VirtualPosition);
            pulse(&mut axis, sign * -TURN / 8, 10_000);
            axis.run_ms(300);
            assert_ordered(&mut axis, ordered - sign * TURN / 8);
            assert_turned(&mut axis, at_switch, -sign * TURN / 8);
        }
    }

    #[test]
    fn a_deviation_stops_it() {
        for limit in [2000, -2000] {
            let mut axis = listening(40_000, 2, &[(Ap::MaxEncoderDeviation, limit)]);
            axis.set("step_dir.frequency_hz", TURN);
            axis.run_ms(500);
            assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0, "{}", axis.figures());
            axis.set("load.friction_nm", JAM_NM);
            axis.run_ms(200);
            assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 1, "{}", axis.figures());
            let stopped = axis.turns();
            axis.set("load.friction_nm", 0.01);
            axis.run_ms(1000);
            assert!((axis.turns() - stopped).abs() < 4.0 / 200.0, "{} turns", axis.turns() - stopped);
            let flows = amplitude_a(&axis);
            if limit < 0 {
                assert!(flows < 0.001, "{flows} A");
            } else {
                assert_flows(&axis, 255, "AP 212 > 0");
            }
            axis.set("step_dir.frequency_hz", 0);
            axis.sap(Ap::StepDirMode, 2);
            axis.run_ms(500);
            let from = axis.turns();
            pulse(&mut axis, TURN / 2, TURN);
            axis.run_ms(500);
            assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0);
            assert_turned(&mut axis, from, TURN / 2);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever the source gives and the load does: what was ordered is what was pulsed, and the shaft gets there.
    #[test]
    fn no_pulse_is_lost(
        legs in proptest::collection::vec((-60_000..=60_000_i32, 1..4000_u64, any::<bool>()), 1..8),
        mode in 1..=5,
    ) {
        let mut axis = listening(40_000, mode, &[]);
        let (from, start) = (axis.turns(), axis.gap(Ap::VirtualPosition));
        let pulsed_before = axis.read("sensed.step_pulses");
        for (frequency_hz, ticks, jammed) in legs {
            axis.set("load.friction_nm", if jammed { JAM_NM } else { 0.01 });
            axis.set("step_dir.frequency_hz", frequency_hz);
            axis.run_ticks(ticks);
        }
        axis.set("step_dir.frequency_hz", 0);
        axis.set("load.friction_nm", 0.01);
        axis.run_ms(6000);
        let pulsed = (axis.read("sensed.step_pulses") - pulsed_before) as i32;
        assert_ordered(&mut axis, start + pulsed);
        assert_turned(&mut axis, from, pulsed);
        prop_assert_eq!(axis.gap(Ap::PositionReached), 1, "{}", axis.figures());
    }
}
