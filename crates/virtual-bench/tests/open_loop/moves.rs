//! Moves of the TMCM-1311 in open loop, in virtual time: how long, how fast, how far; reported, sensed and real.

use crate::common::motion::{assert_agree, assert_turned, finish, finish_within_limits, move_to};
use crate::common::{Module, TICKS_PER_MS, TURN};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, Status};
use tmcl_wire::Reply;

mod one_turn_in_two_seconds {
    use super::*;

    /// The move: up for 1 s, down for 1 s. AP 4 and AP 5 are 51 200 by default (decisions 5.15).
    fn started() -> Module {
        let mut module = Module::new();
        module.run_ms(1);
        assert_eq!((module.gap(Ap::MaxVelocity), module.gap(Ap::MaxAcceleration)), (TURN, TURN));
        move_to(&mut module, TURN);
        module
    }

    fn assert_two_seconds(ticks: u64) {
        assert!((1999 * TICKS_PER_MS..=2001 * TICKS_PER_MS).contains(&ticks), "{ticks} ticks of 50 µs");
    }

    #[test]
    fn by_the_position_reached_flag_with_neither_limit_exceeded() {
        let mut module = started();
        assert_two_seconds(finish_within_limits(&mut module));
        assert_eq!(module.gap(Ap::ActualPosition), TURN);
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualPosition), TURN, "it stays");
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
    }

    #[test]
    fn by_the_second_reply_to_command_138() {
        let mut module = started();
        module.ok(Command::RequestPositionReachedEvent, 0, 0, 0);
        let mut ticks = 0;
        let event = loop {
            module.run_ticks(1);
            ticks += 1;
            match module.unasked()[..] {
                [] => assert!(ticks < 60_000, "no event"),
                [event] => break event,
                ref events => panic!("{events:?}"),
            }
        };
        assert_eq!(event, Reply { status: Status::Delayed, command: 138, value: 1 });
        assert_two_seconds(ticks);
        assert_eq!(module.gap(Ap::ActualPosition), TURN);
    }

    #[test]
    fn reported_sensed_and_real_position_agree_all_the_way() {
        let mut module = started();
        let zero = module.turns();
        for _ in 0..2100 {
            module.run_ms(1);
            assert_agree(&mut module, zero);
        }
        assert_turned(&module, zero, 1.0);
        move_to(&mut module, 0);
        finish(&mut module);
        module.run_ms(1);
        assert_agree(&mut module, zero);
    }

    #[test]
    fn backwards_it_takes_just_as_long() {
        let mut module = started();
        finish(&mut module);
        move_to(&mut module, 0);
        assert_two_seconds(finish_within_limits(&mut module));
    }
}

/// Distance / velocity + velocity / acceleration, or twice the root of distance / acceleration for a triangle.
#[test]
fn moves_take_the_time_that_the_ramp_says() {
    for (distance, velocity, acceleration) in [
        (300_000, 200_000, 400_000),
        (-300_000, 200_000, 400_000),
        (1000, 51_200, 51_200),
        (100_000, 1_000_000, 10_000_000),
        (500, 100, 24_999_998),
        (5000, 327_679_999, 100_000),
        (100, 500, 100),
        (1, 51_200, 51_200),
    ] {
        let mut module = Module::new();
        module.sap(Ap::MaxVelocity, velocity);
        module.sap(Ap::MaxAcceleration, acceleration);
        move_to(&mut module, distance);
        let ticks = finish_within_limits(&mut module) as f64 / 20_000.0;
        let (d, v, a) = (f64::from(distance).abs(), f64::from(velocity), f64::from(acceleration));
        let expected = if d > v * v / a { d / v + v / a } else { 2.0 * (d / a).sqrt() };
        // A ramp ends exactly on its target: the last fraction of a step may cost or save some ticks.
        let tolerance = 0.001 + (2.0 / a).sqrt();
        assert!((ticks - expected).abs() < tolerance, "{distance}: {ticks} s, expected {expected} s");
        assert_eq!(module.gap(Ap::ActualPosition), distance);
    }
}

/// Axis parameter 130: "When set to equal to the target speed, no ramp is generated."
#[test]
fn the_start_stop_velocity_begins_and_ends_the_ramp() {
    let mut module = Module::new();
    module.sap(Ap::StartStopVelocity, TURN);
    move_to(&mut module, TURN);
    let ticks = finish(&mut module);
    assert!((999 * TICKS_PER_MS..=1001 * TICKS_PER_MS).contains(&ticks), "no ramp: {ticks} ticks");

    let mut module = Module::new();
    module.sap(Ap::StartStopVelocity, 20_000);
    move_to(&mut module, TURN);
    module.run_ticks(1);
    let first = module.gap(Ap::ActualVelocity);
    assert!((20_000..=20_010).contains(&first), "begins at {first} pps");
    let mut last = first;
    while module.gap(Ap::PositionReached) == 0 {
        last = module.gap(Ap::ActualVelocity);
        module.run_ticks(1);
    }
    assert!((19_900..=20_500).contains(&last), "ends at {last} pps");
    assert_eq!(module.gap(Ap::ActualPosition), TURN);
}

mod rotation {
    use super::*;

    #[test]
    fn ror_counts_up_and_rol_counts_down() {
        for (command, sign) in [(Command::RotateRight, 1), (Command::RotateLeft, -1)] {
            let mut module = Module::new();
            module.run_ms(1);
            let zero = module.turns();
            module.ok(command, 0, 0, 25_600);
            assert_eq!(module.gap(Ap::RampMode), 1, "velocity mode");
            assert_eq!(module.gap(Ap::TargetVelocity), sign * 25_600);
            module.run_ms(250);
            let half = module.gap(Ap::ActualVelocity);
            assert!((half - sign * 12_800).abs() <= 10, "{half} pps after half of the ramp");
            module.run_ms(260);
            assert_eq!(module.gap(Ap::ActualVelocity), sign * 25_600);
            let (position, turns) = (module.gap(Ap::ActualPosition), module.turns());
            module.run_ms(4000);
            let moved = module.gap(Ap::ActualPosition) - position;
            assert!((moved - sign * 102_400).abs() <= 1, "{moved} µsteps in 4 s");
            assert_turned(&module, turns, f64::from(sign) * 2.0);
            assert_agree(&mut module, zero);
        }
    }

    #[test]
    fn negative_velocities_turn_the_other_way() {
        let mut module = Module::new();
        module.ok(Command::RotateRight, 0, 0, -1000);
        module.run_ms(500);
        assert_eq!(module.gap(Ap::ActualVelocity), -1000);
        module.ok(Command::RotateLeft, 0, 0, -1000);
        module.run_ms(500);
        assert_eq!(module.gap(Ap::ActualVelocity), 1000);
    }

    /// Decisions 2a.2.
    #[test]
    fn mst_ramps_down_with_axis_parameter_5() {
        let mut module = Module::new();
        module.ok(Command::RotateRight, 0, 0, TURN);
        module.run_ms(1500);
        assert_eq!(module.gap(Ap::ActualVelocity), TURN);
        let position = module.gap(Ap::ActualPosition);
        module.ok(Command::MotorStop, 0, 0, 0);
        assert_eq!((module.gap(Ap::RampMode), module.gap(Ap::TargetVelocity)), (1, 0));
        module.run_ms(500);
        assert!((module.gap(Ap::ActualVelocity) - TURN / 2).abs() <= 10, "half way down");
        module.run_ms(510);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        let braking = module.gap(Ap::ActualPosition) - position;
        assert!((braking - TURN / 2).abs() <= 60, "v²/2a = 25 600, but it took {braking}");
        let stopped = module.gap(Ap::ActualPosition);
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualPosition), stopped);
    }

    #[test]
    fn mst_interrupts_a_move_for_good() {
        let mut module = Module::new();
        move_to(&mut module, 10 * TURN);
        module.run_ms(1000);
        module.ok(Command::MotorStop, 0, 0, 0);
        assert_eq!(module.gap(Ap::RampMode), 1);
        module.run_ms(2000);
        let stopped = module.gap(Ap::ActualPosition);
        assert!((TURN / 2..2 * TURN).contains(&stopped), "{stopped}");
        module.run_ms(2000);
        assert_eq!(module.gap(Ap::ActualPosition), stopped);
    }

    /// Decisions 2a.5.
    #[test]
    fn velocities_beyond_axis_parameter_4_are_limited_in_effect() {
        let mut module = Module::new();
        module.ok(Command::RotateRight, 0, 0, 10 * TURN);
        assert_eq!(module.gap(Ap::TargetVelocity), 10 * TURN, "reads as written");
        for _ in 0..3000 {
            module.run_ms(1);
            assert!(module.gap(Ap::ActualVelocity) <= TURN);
        }
        assert_eq!(module.gap(Ap::ActualVelocity), TURN);
        // §8.4, open point 269: the limit counts while it turns.
        module.sap(Ap::MaxVelocity, 2 * TURN);
        module.run_ms(1010);
        assert_eq!(module.gap(Ap::ActualVelocity), 2 * TURN);
        module.sap(Ap::MaxVelocity, 1000);
        module.run_ms(2010);
        assert_eq!(module.gap(Ap::ActualVelocity), 1000);
    }

    #[test]
    fn reversal_goes_through_zero_at_the_acceleration() {
        let mut module = Module::new();
        module.ok(Command::RotateRight, 0, 0, TURN);
        module.run_ms(1100);
        module.ok(Command::RotateLeft, 0, 0, TURN);
        for ms in 1..=2000 {
            module.run_ms(1);
            let expected = f64::from(TURN) * (1.0 - f64::from(ms) / 1000.0);
            let velocity = f64::from(module.gap(Ap::ActualVelocity));
            assert!((velocity - expected).abs() <= 110.0, "{velocity} pps after {ms} ms");
        }
        module.run_ms(10);
        assert_eq!(module.gap(Ap::ActualVelocity), -TURN);
    }
}

mod modes {
    use super::*;

    /// Decisions 2a.1.
    #[test]
    fn sap_0_selects_position_mode_and_sap_2_velocity_mode() {
        let mut module = Module::new();
        module.sap(Ap::TargetVelocity, 5000);
        assert_eq!(module.gap(Ap::RampMode), 1);
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualVelocity), 5000);
        module.sap(Ap::TargetPosition, 20_000);
        assert_eq!(module.gap(Ap::RampMode), 0);
        assert_eq!(module.gap(Ap::PositionReached), 0);
        finish(&mut module);
        assert_eq!(module.gap(Ap::ActualPosition), 20_000);
    }

    /// "Set by hardware: during acceleration to maximum speed, during deceleration and rest to zero" (§6).
    #[test]
    fn in_position_mode_the_ramp_sets_the_target_velocity() {
        let mut module = Module::new();
        for (target, velocity) in [(4 * TURN, TURN), (0, -TURN)] {
            move_to(&mut module, target);
            for ms in [300, 2000] {
                module.run_ms(ms);
                assert_eq!(module.gap(Ap::TargetVelocity), velocity, "accelerating and cruising");
            }
            module.run_ms(2200);
            let slow = module.gap(Ap::ActualVelocity).abs();
            assert!((1..TURN).contains(&slow), "{slow}");
            assert_eq!(module.gap(Ap::TargetVelocity), 0, "decelerating");
            finish(&mut module);
            assert_eq!(module.gap(Ap::TargetVelocity), 0, "at rest");
        }
    }

    /// Bits of axis parameter 18 (§6).
    #[test]
    fn the_status_word_shows_mode_and_target_reached() {
        const REACHED: i32 = 1;
        const POSITION_MODE: i32 = 1 << 3;
        const VELOCITY_MODE: i32 = 1 << 4;
        let mut module = Module::new();
        let bits =
            |module: &mut Module| module.gap(Ap::StatusWord) & (REACHED | POSITION_MODE | VELOCITY_MODE);
        assert_eq!(bits(&mut module), REACHED | POSITION_MODE);
        move_to(&mut module, 1000);
        assert_eq!(bits(&mut module), POSITION_MODE);
        finish(&mut module);
        assert_eq!(bits(&mut module), REACHED | POSITION_MODE);
        module.ok(Command::RotateRight, 0, 0, 1000);
        assert_eq!(bits(&mut module) & !REACHED, VELOCITY_MODE);
    }
}

/// Decisions 2a.1: hosts poll at once, so the flag must be down before the reply.
#[test]
fn position_reached_is_cleared_before_the_reply_to_a_motion_command() {
    for (command, kind, value) in [
        (Command::MoveToPosition, 0, 500),
        (Command::MoveToPosition, 1, 500),
        (Command::MoveToPosition, 2, 1),
        (Command::SetAxisParameter, 0, 500),
        (Command::AccumulatorToAxisParameter, 0, 0),
    ] {
        let mut module = Module::new();
        module.ok(Command::SetCoordinate, 1, 0, 500);
        module.ok(Command::Calculate, 9, 0, 500);
        assert_eq!(module.gap(Ap::PositionReached), 1);
        module.ok(command, kind, 0, value);
        assert_eq!(module.gap(Ap::PositionReached), 0, "{command:?} {kind}");
        finish(&mut module);
        assert_eq!(module.gap(Ap::ActualPosition), 500);
        // To where it stands already: reached at once, or at the latest a tick later.
        module.ok(Command::MoveToPosition, 0, 0, 500);
        module.run_ticks(1);
        assert_eq!(module.gap(Ap::PositionReached), 1);
    }
}
