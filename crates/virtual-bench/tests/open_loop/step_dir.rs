//! Step/direction mode in open loop (TMCM-1311 §6, AP 254; decisions in `docs/fidelity.md`): judged by the rotor and the coils.

use crate::common::{Module, TURN};
use proptest::prelude::*;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, Status};

/// The coil amplitude at AP 6 = 255: 3 A RMS.
const FULL_A: f64 = 3.0 * std::f64::consts::SQRT_2;

/// AP 6 and AP 7 in these tests.
const RUN: i32 = 200;
const HOLD: i32 = 40;

/// AP 214 in these tests.
const DELAY_MS: u64 = 300;

const FULL_STEP: f64 = 1.0 / 200.0;

fn measured_a(module: &Module) -> f64 {
    let physical = module.physical();
    physical.coil_a_a.hypot(physical.coil_b_a)
}

#[track_caller]
fn assert_flows(module: &Module, setting: i32) {
    let expected = FULL_A * f64::from(setting / 8 + 1) / 32.0;
    let measured = measured_a(module);
    assert!((measured / expected - 1.0).abs() < 0.03, "{measured} A, not {expected} A");
}

#[track_caller]
fn assert_off(module: &Module) {
    assert!(measured_a(module) < 0.001, "{} A", measured_a(module));
}

/// The rotor stands where so many microsteps of 1/256 full step lead, to a tenth of a full step.
#[track_caller]
fn assert_turned(module: &Module, microsteps: i32) {
    let expected = f64::from(microsteps) / f64::from(TURN);
    let turns = module.turns();
    assert!((turns - expected).abs() < FULL_STEP / 10.0, "{turns} turns, not {expected}");
}

fn module(mode: i32) -> Module {
    let mut module = Module::new();
    prepare(&mut module, mode);
    module
}

fn prepare(module: &mut Module, mode: i32) {
    module.sap(Ap::MaxCurrent, RUN);
    module.sap(Ap::StandbyCurrent, HOLD);
    module.sap(Ap::PowerDownDelay, (DELAY_MS / 10) as i32);
    module.sap(Ap::StepDirMode, mode);
    module.run_ms(DELAY_MS + 100);
}

/// So many pulses, the sign as the direction, and a moment to settle.
fn pulse(module: &mut Module, pulses: i32, frequency_hz: i32) {
    module.set("step_dir.frequency_hz", frequency_hz * pulses.signum());
    module.set("step_dir.pulses", pulses.abs());
    let periods_ms = pulses.unsigned_abs() * 1000 / frequency_hz.unsigned_abs();
    module.run_ms(u64::from(periods_ms) + 200);
}

#[test]
fn as_delivered_pulses_and_enable_do_nothing() {
    let mut pulsed = Module::on(
        "[[module]]\nkind = \"tmcm-1311\"\n[module.step_dir]\nfrequency_hz = 12345.6\nenable = 1\n",
    );
    let mut other = Module::new();
    for module in [&mut pulsed, &mut other] {
        module.ok(Command::MoveToPosition, 0, 0, TURN);
        module.run_ms(1800);
        module.ok(Command::SetAxisParameter, Ap::StepDirMode.number(), 0, 0);
        module.run_ms(3000);
    }
    assert_eq!(pulsed.physical(), other.physical());
    assert_eq!(pulsed.gap(Ap::ActualPosition), TURN);
    assert!(pulsed.read("sensed.step_pulses") == (4.8_f64 * 12345.6).floor());
}

#[test]
fn a_pulse_is_a_microstep_of_the_resolution() {
    for resolution in 0..=8 {
        let mut module = module(3);
        module.sap(Ap::MicrostepResolution, resolution);
        let scale = 1 << resolution;
        // Slow enough that a rotor thrown from full step to full step settles.
        pulse(&mut module, 50 * scale, 10 * scale);
        assert_eq!(module.gap(Ap::ActualPosition), 50 * scale, "AP 140 = {resolution}");
        assert_turned(&module, 50 * 256);
        pulse(&mut module, -(77 * scale), 10 * scale);
        assert_eq!(module.gap(Ap::ActualPosition), -27 * scale);
        assert_turned(&module, -27 * 256);
        assert!((module.read("sensed.step_pulses") - f64::from(-27 * scale)).abs() < 0.5);
    }
}

/// A whole turn and one microstep: the last pulse counts like the others.
#[test]
fn no_pulse_is_lost_and_the_parameters_follow() {
    let mut module = module(2);
    module.set("step_dir.frequency_hz", 40_000);
    module.set("step_dir.pulses", TURN + 1);
    module.run_ms(500);
    for (parameter, expected) in
        [(Ap::PositionReached, 0), (Ap::TargetVelocity, 0), (Ap::RampMode, 0), (Ap::StepDirMode, 2)]
    {
        assert_eq!(module.gap(parameter), expected, "{parameter:?}");
    }
    assert_eq!(module.gap(Ap::TargetPosition), module.gap(Ap::ActualPosition));
    assert!((module.gap(Ap::ActualPosition) - 20_000).abs() <= 2, "{}", module.gap(Ap::ActualPosition));
    let reported_pps = f64::from(module.gap(Ap::ActualVelocity));
    assert!((reported_pps / 40_000.0 - 1.0).abs() < 0.01, "{reported_pps}");
    let before = module.turns();
    module.run_ms(200);
    let real_pps = (module.turns() - before) * f64::from(TURN) / 0.2;
    assert!((real_pps / 40_000.0 - 1.0).abs() < 0.05, "{real_pps}");
    module.run_ms(580 + 95);
    assert_eq!(module.gap(Ap::PositionReached), 0, "a pulse may be late by 100 ms");
    module.run_ms(10);
    assert_eq!(module.gap(Ap::PositionReached), 1);
    assert_eq!(module.gap(Ap::ActualVelocity), 0);
    assert_eq!(module.gap(Ap::ActualPosition), TURN + 1);
    assert_turned(&module, TURN + 1);
}

mod current {
    use super::*;

    #[test]
    fn mode_1_enable_selects_and_nothing_else() {
        let mut module = module(1);
        assert_flows(&module, HOLD);
        pulse(&mut module, 5120, 10_000);
        assert_flows(&module, HOLD);
        assert_turned(&module, 5120);
        module.set("step_dir.enable", 1);
        module.run_ms(20);
        assert_flows(&module, RUN);
        module.sap(Ap::FreewheelingDelay, 50);
        module.run_ms(10 * DELAY_MS);
        assert_flows(&module, RUN);
        module.set("step_dir.enable", 0);
        module.run_ms(20);
        assert_flows(&module, HOLD);
    }

    #[test]
    fn modes_2_and_4_run_from_the_first_pulse_until_the_delay_after_the_last() {
        for mode in [2, 4] {
            let mut module = module(mode);
            module.set("step_dir.enable", i32::from(mode == 4));
            module.run_ms(20);
            assert_flows(&module, HOLD);
            module.set("step_dir.frequency_hz", 50);
            module.set("step_dir.pulses", 2);
            module.run_ms(19);
            assert_flows(&module, HOLD);
            module.run_ms(15);
            assert_flows(&module, RUN);
            // The second and last comes after 40 ms, and is seen a control period later.
            module.run_ms(6 + DELAY_MS);
            assert_flows(&module, RUN);
            module.run_ticks(1);
            let before = module.read("coolstep_actual_current");
            module.run_ticks(3);
            assert!(module.read("coolstep_actual_current") < before, "to the control period");
            module.run_ms(20);
            assert_flows(&module, HOLD);
            // In mode 2 ENABLE is not used.
            module.set("step_dir.enable", i32::from(mode == 2));
            module.run_ms(20);
            if mode == 2 { assert_flows(&module, HOLD) } else { assert_off(&module) }
        }
    }

    #[test]
    fn modes_3_and_5_run_for_ever() {
        for mode in [3, 5] {
            let mut module = module(mode);
            module.sap(Ap::FreewheelingDelay, 50);
            module.set("step_dir.enable", i32::from(mode == 5));
            module.run_ms(20);
            assert_flows(&module, RUN);
            pulse(&mut module, 5000, 10_000);
            module.run_ms(10 * DELAY_MS);
            assert_flows(&module, RUN);
            module.set("step_dir.enable", i32::from(mode == 3));
            module.run_ms(20);
            if mode == 3 { assert_flows(&module, RUN) } else { assert_off(&module) }
        }
    }

    #[test]
    fn freewheeling_ends_with_a_pulse_in_mode_2() {
        let mut module = module(2);
        module.sap(Ap::FreewheelingDelay, 500);
        module.run_ms(600);
        assert_off(&module);
        module.set("step_dir.frequency_hz", 1000);
        module.run_ms(50);
        assert_flows(&module, RUN);
    }

    #[test]
    fn a_slow_pulse_train_is_no_rest() {
        let mut module = module(2);
        module.set("step_dir.frequency_hz", 5);
        module.run_ms(250);
        for _ in 0..20 {
            assert_flows(&module, RUN);
            module.run_ms(100);
        }
    }
}

/// With the driver stage off the shaft is free; pulses are lost; on again, it is pulled to where the field was left.
#[test]
fn enable_switches_the_driver_stage_off_and_on() {
    for mode in [4, 5] {
        let mut module = module(mode);
        module.set("step_dir.enable", 1);
        pulse(&mut module, 12_800, 12_800);
        assert_turned(&module, 12_800);
        module.set("step_dir.enable", 0);
        module.run_ms(50);
        assert_off(&module);
        let held = module.turns();
        pulse(&mut module, 6400, 12_800);
        assert_eq!(module.gap(Ap::ActualPosition), 12_800, "lost");
        assert!((module.turns() - held).abs() < FULL_STEP, "detent torque");
        module.set("load.torque_nm", 0.1);
        module.run_ms(200);
        assert!(module.turns() > held + 0.1, "free");
        module.set("load.torque_nm", 0.0);
        module.run_ms(1000);
        let coasted = module.turns();
        module.set("step_dir.enable", 1);
        module.run_ms(2000);
        assert_eq!(module.gap(Ap::ActualPosition), 12_800);
        // Four full steps further it looks the same; nearest is where it goes.
        let fours = (module.turns() - 0.25) / (4.0 * FULL_STEP);
        assert!((fours - fours.round()).abs() < 0.05, "{fours}");
        assert!((module.turns() - coasted).abs() < 4.0 * FULL_STEP);
        let before = module.turns();
        pulse(&mut module, 12_800, 12_800);
        assert!((module.turns() - before - 0.25).abs() < FULL_STEP / 5.0);
    }
}

/// Statuses and the way in and out.
mod commands {
    use super::*;

    #[test]
    fn what_the_ramp_would_do_is_not_available() {
        let mut module = module(3);
        let sap = Command::SetAxisParameter;
        for (command, kind, value) in [
            (Command::RotateRight, 0, 1000),
            (Command::RotateLeft, 0, 1000),
            (Command::MoveToPosition, 0, 1000),
            (Command::MoveToPosition, 1, 1000),
            (Command::MoveToPosition, 2, 1),
            (sap, 0, 1000),
            (sap, 2, 1000),
            (sap, 128, 0),
            (sap, 128, 1),
            (Command::ReferenceSearch, 0, 0),
        ] {
            assert_eq!(module.status(command, kind, 0, value), Status::NotAvailable, "{command:?} {kind}");
        }
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualPosition), 0);
        assert_turned(&module, 0);
        assert_eq!(module.status(sap, 254, 0, 6), Status::InvalidValue);
        assert_eq!(module.status(Command::ReferenceSearch, 1, 0, 0), Status::Ok, "nothing to stop");
    }

    #[test]
    fn it_needs_a_motor_at_rest_to_begin() {
        let mut module = Module::new();
        let step_dir = |module: &mut Module, mode| module.status(Command::SetAxisParameter, 254, 0, mode);
        module.ok(Command::RotateRight, 0, 0, 10_000);
        assert_eq!(step_dir(&mut module, 2), Status::InvalidValue, "about to move");
        assert_eq!(step_dir(&mut module, 0), Status::Ok, "nothing to change");
        module.run_ms(500);
        assert_eq!(step_dir(&mut module, 2), Status::InvalidValue);
        assert_eq!(module.gap(Ap::StepDirMode), 0);
        assert_eq!(module.gap(Ap::TargetVelocity), 10_000);
        module.ok(Command::MotorStop, 0, 0, 0);
        module.run_ms(50);
        assert_eq!(step_dir(&mut module, 2), Status::InvalidValue, "slowing down");
        module.run_ms(1000);
        assert_eq!(step_dir(&mut module, 2), Status::Ok);
        module.set("step_dir.frequency_hz", 10_000);
        module.run_ms(100);
        assert_eq!(step_dir(&mut module, 3), Status::Ok, "pulses are no hindrance");
        assert_eq!(step_dir(&mut module, 0), Status::Ok);
    }

    #[test]
    fn a_search_must_be_over_first() {
        let mut module = Module::new();
        module.ok(Command::ReferenceSearch, 0, 0, 0);
        module.run_ms(100);
        assert_eq!(module.status(Command::SetAxisParameter, 254, 0, 1), Status::InvalidValue);
    }

    #[test]
    fn the_ramp_takes_over_where_the_motor_stands() {
        let mut module = module(3);
        pulse(&mut module, 10_001, 10_000);
        module.sap(Ap::StepDirMode, 0);
        module.run_ms(500);
        assert_eq!(module.gap(Ap::ActualPosition), 10_001);
        assert_turned(&module, 10_001);
        pulse(&mut module, 3000, 10_000);
        assert_eq!(module.gap(Ap::ActualPosition), 10_001, "pulses are none of its business");
        module.ok(Command::MoveToPosition, 1, 0, 5000);
        module.arrive();
        module.run_ms(200);
        assert_turned(&module, 15_001);
    }

    #[test]
    fn the_position_can_be_called_something_else() {
        let mut module = module(3);
        pulse(&mut module, 5000, 10_000);
        module.sap(Ap::ActualPosition, -100);
        assert_eq!(module.gap(Ap::TargetPosition), -100);
        pulse(&mut module, 5000, 10_000);
        assert_eq!(module.gap(Ap::ActualPosition), 4900);
        assert_turned(&module, 10_000);
        module.sap(Ap::StepDirMode, 0);
        module.run_ms(500);
        assert_turned(&module, 10_000);
    }

    #[test]
    fn a_stored_mode_is_there_after_power_on() {
        let mut module = module(3);
        for parameter in [Ap::StepDirMode, Ap::MaxCurrent] {
            module.ok(Command::StoreAxisParameter, parameter.number(), 0, 0);
        }
        module.sap(Ap::StepDirMode, 0);
        module.power_cycle();
        assert_eq!(module.gap(Ap::StepDirMode), 3);
        assert_eq!(module.status(Command::MoveToPosition, 0, 0, 100), Status::NotAvailable);
        pulse(&mut module, 12_800, 12_800);
        assert_eq!(module.gap(Ap::ActualPosition), 12_800);
        assert_turned(&module, 12_800);
        module.run_ms(3000);
        assert_flows(&module, RUN);
    }

    /// Pulses from before power-on are nobody's.
    #[test]
    fn pulses_of_the_past_do_not_count() {
        let mut module = Module::new();
        module.sap(Ap::StepDirMode, 3);
        module.ok(Command::StoreAxisParameter, 254, 0, 0);
        module.set("step_dir.frequency_hz", 1_000_000);
        module.run_ms(1);
        module.set("step_dir.frequency_hz", 0);
        module.power_cycle();
        module.run_ms(10);
        assert_eq!(module.gap(Ap::ActualPosition), 0);
    }
}

/// What stops a motor stops one that is pulsed; pulses are lost until AP 254 is written again.
mod stops {
    use super::*;

    #[test]
    fn mst_makes_it_deaf() {
        let mut module = module(3);
        module.set("step_dir.frequency_hz", 10_000);
        module.run_ms(300);
        module.ok(Command::MotorStop, 0, 0, 0);
        let stopped = module.gap(Ap::ActualPosition);
        module.run_ms(500);
        assert_eq!(module.gap(Ap::ActualPosition), stopped);
        assert_eq!((module.gap(Ap::ActualVelocity), module.gap(Ap::PositionReached)), (0, 1));
        assert_turned(&module, stopped);
        module.sap(Ap::StepDirMode, 3);
        module.run_ms(100);
        let moved = module.gap(Ap::ActualPosition) - stopped;
        assert!((moved - 1000).abs() <= 2, "{moved}");
    }

    #[test]
    fn a_stop_switch_lets_through_what_leads_away() {
        for sign in [1, -1] {
            let mut module = Module::on(
                "[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\nleft = { at_turns = -0.25 }\nright = { at_turns = 0.25 }\n",
            );
            prepare(&mut module, 3);
            pulse(&mut module, sign * 20_000, 10_000);
            let at_switch = module.turns() * f64::from(sign);
            assert!((at_switch - 0.25).abs() < FULL_STEP / 5.0, "{at_switch}");
            let position = module.gap(Ap::ActualPosition) * sign;
            assert!((position - 12_800).abs() < 64, "{position}");
            pulse(&mut module, sign * -6400, 10_000);
            assert_eq!(module.gap(Ap::ActualPosition) * sign, position - 6400);
            assert_turned(&module, sign * (position - 6400));
            // Switched off, the switch is none.
            module.sap(Ap::RightLimitSwitchDisable, 1);
            module.sap(Ap::LeftLimitSwitchDisable, 1);
            pulse(&mut module, sign * 10_000, 10_000);
            assert_turned(&module, sign * (position + 3600));
        }
    }

    #[test]
    fn deviation_of_the_encoder() {
        for limit in [2000, -2000] {
            let mut module = module(3);
            module.sap(Ap::MaxEncoderDeviation, limit);
            module.set("step_dir.frequency_hz", 25_600);
            module.run_ms(500);
            assert_eq!(module.gap(Ap::EncoderDeviationFlag), 0);
            module.set("load.friction_nm", 10);
            module.run_ms(500);
            assert_eq!(module.gap(Ap::EncoderDeviationFlag), 1);
            let (position, turns) = (module.gap(Ap::ActualPosition), module.turns());
            let deviation = f64::from(position) - turns * f64::from(TURN);
            assert!((1900.0..2100.0).contains(&deviation), "{deviation}");
            if limit < 0 {
                assert_off(&module);
            } else {
                assert_flows(&module, RUN);
            }
            module.set("load.friction_nm", 0.01);
            module.run_ms(500);
            assert_eq!(module.gap(Ap::ActualPosition), position);
            let encoder_position = (module.turns() * f64::from(TURN)).round() as i32;
            module.sap(Ap::ActualPosition, encoder_position);
            module.sap(Ap::StepDirMode, 3);
            module.run_ms(100);
            assert_eq!(module.gap(Ap::EncoderDeviationFlag), 0);
            assert!((module.gap(Ap::ActualPosition) - encoder_position - 2560).abs() <= 2);
            assert_flows(&module, RUN);
        }
    }

    #[test]
    fn stall() {
        let mut module = module(3);
        module.sap(Ap::StopOnStallVelocity, 60_000);
        module.set("step_dir.frequency_hz", 40_000);
        module.run_ms(300);
        // 80 000 pps in steps a motor can follow.
        for frequency_hz in (40_000..=80_000).step_by(2000) {
            module.set("step_dir.frequency_hz", frequency_hz);
            module.run_ms(20);
        }
        module.run_ms(300);
        let before = module.gap(Ap::ActualPosition);
        module.run_ms(100);
        assert!((module.gap(Ap::ActualPosition) - before - 8000).abs() <= 5, "it turns freely");
        module.set("load.friction_nm", 10);
        module.run_ms(200);
        let stopped = module.gap(Ap::ActualPosition);
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualPosition), stopped);
        assert!((f64::from(stopped) / f64::from(TURN) - module.turns()).abs() < 0.1);
    }
}

/// The example does what its comments say.
#[test]
fn the_example() {
    let mut module = Module::on(include_str!("../../../../examples/benches/step-direction.toml"));
    module.sap(Ap::StepDirMode, 4);
    module.run_ms(2990);
    let moved = module.gap(Ap::ActualPosition);
    assert!((module.turns() - 2.99 * 0.5).abs() < FULL_STEP, "{} turns", module.turns());
    assert!((moved - 2990 * 256 / 10).abs() <= 26, "{moved}");
    module.run_ms(10 + 2990);
    assert_eq!(module.gap(Ap::ActualPosition), 3 * 25_600 - TURN);
    assert!((module.turns() - 0.5).abs() < FULL_STEP / 5.0, "{} turns", module.turns());
    module.run_ms(100);
    assert_off(&module);
}

/// What happens when, at which control period, is the same however time is cut into pieces.
#[test]
fn how_finely_a_run_is_sliced_does_not_matter() {
    let text = "[[module]]\nkind = \"tmcm-1311\"\n[module.step_dir]\nfrequency_hz = 777.7\nenable = 1\n\
                [[event]]\nat = \"1s\"\nset = { \"step_dir.frequency_hz\" = -3.21, \"step_dir.enable\" = 0 }\n\
                [[event]]\nat = \"3s\"\nset = { \"step_dir.frequency_hz\" = 0.5, \"step_dir.enable\" = 1 }\n";
    let start = || {
        let mut module = Module::on(text);
        prepare(&mut module, 4);
        module
    };
    let state = |module: &Module| {
        (module.physical(), module.read("actual_position"), module.read("sensed.step_pulses"))
    };
    let mut whole = start();
    whole.run_ms(8000);
    for slice in [1, 17, 333] {
        let mut sliced = start();
        for _ in 0..8000 * 20 / slice {
            sliced.run_ticks(slice);
        }
        sliced.run_ticks(8000 * 20 % slice);
        assert_eq!(state(&sliced), state(&whole), "in slices of {slice}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// AP 1 counts what the source gave while it was listened to, whatever the frequencies.
    #[test]
    fn the_position_is_the_count(
        legs in proptest::collection::vec((-2_000_000..=2_000_000_i32, 1..2000_u64), 1..8),
        mode in 1..=5,
    ) {
        let mut module = Module::new();
        module.sap(Ap::StepDirMode, mode);
        module.set("step_dir.enable", 1);
        for (twice_hz, ticks) in legs {
            module.set("step_dir.frequency_hz", f64::from(twice_hz) / 2.0);
            module.run_ticks(ticks);
        }
        module.set("step_dir.frequency_hz", 0);
        module.run_ticks(1);
        let counted = module.read("sensed.step_pulses");
        prop_assert!(counted == f64::from(module.gap(Ap::ActualPosition)), "{counted}");
        prop_assert_eq!(module.gap(Ap::TargetPosition), module.gap(Ap::ActualPosition));
    }
}
