//! Moves of the TMCM-1311 in open loop, in virtual time: how long, how fast, how far; reported, sensed and real.

mod common;

use common::{Module, TICKS_PER_MS};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, Status};
use tmcl_wire::{Reply, Request};

/// µsteps in a turn at 256 µsteps per full step.
const TURN: i32 = 51_200;

const TICKS_PER_S: i64 = 20_000;

/// How far a rotor without load may be from its field, in turns: a full step, for detent torque and resonance. Steps get
/// lost four at a time (decisions 5.8), so this is none.
const SLACK: f64 = 1.0 / 200.0;

fn move_to(module: &mut Module, position: i32) {
    module.ok(Command::MoveToPosition, 0, 0, position);
}

/// Runs until AP 8 is set, and returns the ticks it took.
#[track_caller]
fn finish(module: &mut Module) -> u64 {
    for tick in 0..60 * TICKS_PER_S.cast_unsigned() {
        if module.gap(Ap::PositionReached) == 1 {
            return tick;
        }
        module.run_ticks(1);
    }
    panic!("the target is never reached; the position is {}", module.gap(Ap::ActualPosition));
}

/// Reported, sensed and real positions agree: AP 1, AP 209 at 40 000 counts a turn, and the rotor's turns since `zero`.
#[track_caller]
fn assert_agree(module: &mut Module, zero: f64) {
    let turns = module.turns() - zero;
    let reported = f64::from(module.gap(Ap::ActualPosition)) / f64::from(TURN);
    let sensed = f64::from(module.gap(Ap::EncoderCounter)) / 40_000.0;
    assert!((reported - turns).abs() < SLACK, "AP 1 says {reported} turns, truth is {turns}");
    // Whole counts, read at the beginning of a control period in which the rotor, at a turn a second, goes two on.
    assert!((sensed - turns).abs() < 8.0 / 40_000.0, "AP 209 says {sensed} turns, truth is {turns}");
}

/// The rotor has turned by `turns` since `zero`.
#[track_caller]
fn assert_turned(module: &Module, zero: f64, turns: f64) {
    let turned = module.turns() - zero;
    assert!((turned - turns).abs() < SLACK, "{turned} turns, not {turns}");
}

/// Runs to the end of a move and checks at every tick that neither limit is exceeded, that the position never goes back
/// and never beyond the target. Returns the ticks.
fn finish_within_limits(module: &mut Module) -> u64 {
    let limit = i64::from(module.gap(Ap::MaxVelocity));
    let acceleration = i64::from(module.gap(Ap::MaxAcceleration));
    let target = module.gap(Ap::TargetPosition);
    let mut position = module.gap(Ap::ActualPosition);
    let direction = (target - position).signum();
    let mut velocity = i64::from(module.gap(Ap::ActualVelocity));
    let mut past = vec![velocity];
    for tick in 0.. {
        if module.gap(Ap::PositionReached) == 1 {
            assert_eq!(position, target, "AP 8 in open loop is exact equality (decisions 5.3)");
            return tick;
        }
        assert!(tick < 60 * TICKS_PER_S.cast_unsigned(), "never arrives");
        module.run_ticks(1);
        let now = module.gap(Ap::ActualPosition);
        let step = (now - position) * direction;
        assert!(step >= 0, "tick {tick}: back from {position} to {now}");
        assert!(i64::from(step) * TICKS_PER_S <= limit + TICKS_PER_S, "tick {tick}: {step} µsteps");
        assert!((target - now) * direction >= 0, "tick {tick}: {now} is beyond {target}");
        position = now;
        velocity = i64::from(module.gap(Ap::ActualVelocity));
        assert!(velocity.abs() <= limit, "tick {tick}: {velocity} pps");
        // Over a tick AP 5 allows a few pps, rounded to integers; over 10 ms rounding no longer hides anything. The very
        // end may drop whatever the last fraction of a step leaves.
        past.push(velocity);
        if position != target && past.len() > 200 {
            let change = (velocity - past[past.len() - 201]).abs();
            assert!(change <= acceleration / 100 + 2, "tick {tick}: {change} pps in 10 ms");
        }
    }
    unreachable!()
}

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

mod relative_moves {
    use super::*;

    /// AP 127: 0 the last target, 1 (the default) the ramp generator's position, 2 the encoder's (decisions 2a.3).
    #[test]
    fn count_from_what_axis_parameter_127_selects() {
        for (option, base, slack) in [(0, 100_000, 0), (1, 25_600, 0), (2, 25_600, (SLACK * 51_200.0) as i32)]
        {
            let mut module = Module::new();
            move_to(&mut module, 100_000);
            while module.gap(Ap::ActualPosition) < 25_600 {
                module.run_ticks(1);
            }
            module.sap(Ap::RelativePositioningOption, option);
            let position = module.gap(Ap::ActualPosition);
            module.ok(Command::MoveToPosition, 1, 0, 1000);
            let target = module.gap(Ap::TargetPosition);
            let past = if option == 0 { 0 } else { position - 25_600 };
            assert!((target - base - past - 1000).abs() <= slack, "AP 127 = {option}: {target}");
            finish(&mut module);
            assert_eq!(module.gap(Ap::ActualPosition), target);
        }
    }

    #[test]
    fn are_exact_from_standstill_and_add_up() {
        let mut module = Module::new();
        for (offset, target) in [(1000, 1000), (-300, 700), (0, 700), (-1700, -1000)] {
            module.ok(Command::MoveToPosition, 1, 0, offset);
            assert_eq!(module.gap(Ap::TargetPosition), target);
            finish(&mut module);
            assert_eq!(module.gap(Ap::ActualPosition), target);
        }
    }

    /// Decisions 2a.3: a target beyond 32 bits wraps, and the shorter way is taken.
    #[test]
    fn wrap_around_the_end_of_the_counter() {
        let mut module = Module::new();
        module.run_ms(1);
        module.sap(Ap::ActualPosition, i32::MAX - 100);
        let zero = module.turns();
        module.ok(Command::MoveToPosition, 1, 0, TURN);
        let target = (i32::MAX - 100).wrapping_add(TURN);
        assert_eq!(module.gap(Ap::TargetPosition), target);
        finish(&mut module);
        module.run_ms(1);
        assert_eq!(module.gap(Ap::ActualPosition), target);
        assert_turned(&module, zero, 1.0);
        // And back, absolutely (§5.7.4).
        move_to(&mut module, i32::MAX - 100);
        finish(&mut module);
        module.run_ms(1);
        assert_turned(&module, zero, 0.0);
    }
}

/// Decisions 2a.1: SAP 1 shifts AP 0 and AP 1 by the same amount.
mod setting_the_position {
    use super::*;

    #[test]
    fn moves_nothing_while_standing() {
        let mut module = Module::new();
        move_to(&mut module, 1000);
        finish(&mut module);
        module.run_ms(10);
        let mut plain = module.clone();
        for position in [0, -123_456, i32::MAX, i32::MIN, 77] {
            module.sap(Ap::ActualPosition, position);
            assert_eq!(module.gap(Ap::ActualPosition), position);
            assert_eq!(module.gap(Ap::TargetPosition), position);
            assert_eq!(module.gap(Ap::PositionReached), 1);
            module.run_ms(100);
            plain.run_ms(100);
            assert_eq!(module.gap(Ap::ActualPosition), position);
            assert_eq!(module.turns(), plain.turns());
            let counts = plain.gap(Ap::EncoderCounter);
            assert_eq!(module.gap(Ap::EncoderCounter), counts, "independent in open loop");
        }
    }

    #[test]
    fn changes_nothing_about_a_move_under_way() {
        let mut plain = Module::new();
        move_to(&mut plain, TURN);
        plain.run_ms(700);
        let mut shifted = plain.clone();
        let velocity = shifted.gap(Ap::ActualVelocity);
        let shift = 1_000_000 - shifted.gap(Ap::ActualPosition);
        shifted.sap(Ap::ActualPosition, 1_000_000);
        assert_eq!(shifted.gap(Ap::TargetPosition), TURN + shift);
        assert_eq!(shifted.gap(Ap::ActualVelocity), velocity);
        let ticks = finish(&mut plain);
        assert_eq!(finish(&mut shifted), ticks);
        assert_eq!(shifted.gap(Ap::ActualPosition), TURN + shift);
        plain.run_ms(1);
        shifted.run_ms(1);
        assert_eq!(shifted.turns(), plain.turns(), "the rotor does not notice");
    }

    #[test]
    fn changes_nothing_about_a_rotation() {
        let mut plain = Module::new();
        plain.ok(Command::RotateLeft, 0, 0, 30_000);
        plain.run_ms(300);
        let mut shifted = plain.clone();
        shifted.sap(Ap::ActualPosition, 0);
        plain.run_ms(1000);
        shifted.run_ms(1000);
        assert_eq!(shifted.turns(), plain.turns());
        assert_eq!(shifted.gap(Ap::ActualVelocity), plain.gap(Ap::ActualVelocity));
    }

    /// The encoder's counter is a thing of its own in open loop.
    #[test]
    fn of_the_encoder_does_not_touch_the_motor() {
        let mut plain = Module::new();
        move_to(&mut plain, TURN / 2);
        finish(&mut plain);
        let mut module = plain.clone();
        module.sap(Ap::EncoderCounter, 1000);
        assert_eq!(module.gap(Ap::EncoderCounter), 1000);
        assert_eq!(module.gap(Ap::ActualPosition), TURN / 2);
        let shift = plain.gap(Ap::EncoderCounter) - 1000;
        for module in [&mut plain, &mut module] {
            move_to(module, TURN);
            finish(module);
        }
        assert_eq!(module.turns(), plain.turns());
        assert_eq!(module.gap(Ap::EncoderCounter), plain.gap(Ap::EncoderCounter) - shift);
    }
}

/// 200 full steps are a turn, in however many µsteps they are taken (axis parameter 140, §6.1). Whole and half steps go
/// slowly, so that what they set swinging comes to rest.
#[test]
fn the_microstep_resolution_scales_positions_and_velocities() {
    for resolution in 0..=8 {
        let mut module = Module::new();
        let turn = 200 << resolution;
        let velocity = if resolution < 2 { turn / 5 } else { turn };
        module.sap(Ap::MicrostepResolution, resolution);
        module.sap(Ap::MaxVelocity, velocity);
        module.sap(Ap::MaxAcceleration, velocity);
        module.run_ms(1);
        let zero = module.turns();
        move_to(&mut module, turn);
        let seconds = finish(&mut module) as f64 / 20_000.0;
        module.run_ms(500);
        assert_turned(&module, zero, 1.0);
        // The last of few steps takes its time.
        let tolerance = 0.001 + (2.0 / f64::from(velocity)).sqrt();
        let expected = f64::from(turn / velocity + 1);
        assert!((seconds - expected).abs() < tolerance, "AP 140 = {resolution}: {seconds} s");
        module.ok(Command::RotateLeft, 0, 0, velocity / 2);
        module.run_ms(1000);
        let (from, at) = (module.turns(), module.gap(Ap::ActualPosition));
        module.run_ms(1000);
        let (turned, moved) = (from - module.turns(), at - module.gap(Ap::ActualPosition));
        assert!((moved - velocity / 2).abs() <= 1, "AP 140 = {resolution}: {moved} steps");
        let expected = f64::from(velocity) / 2.0 / f64::from(turn);
        assert!((turned - expected).abs() < 0.006, "AP 140 = {resolution}: {turned} turns");
    }
}

/// Axis parameter 167 = 0 "completely disables all driver transistors and the motor can free-wheel" (§6): the ramp does
/// not know, the encoder and the rotor do.
#[test]
fn without_current_the_rotor_stays_while_the_ramp_runs() {
    let mut module = Module::new();
    module.run_ms(1);
    let zero = module.turns();
    module.sap(Ap::ChopperOffTime, 0);
    move_to(&mut module, TURN);
    finish(&mut module);
    module.run_ms(1);
    assert_eq!(module.gap(Ap::ActualPosition), TURN);
    assert_agree_that_nothing_turned(&mut module, zero);
    assert_eq!(module.gap(Ap::MotorCurrent), 0);
    // With current again it snaps to the nearest of the 50 places where the field holds it: here, where it is.
    module.sap(Ap::ChopperOffTime, 5);
    move_to(&mut module, 2 * TURN);
    finish(&mut module);
    module.run_ms(1);
    module.run_ms(500);
    assert_turned(&module, zero, 1.0);
    assert_eq!(module.gap(Ap::ActualPosition), 2 * TURN, "it was told to turn twice");
}

#[track_caller]
fn assert_agree_that_nothing_turned(module: &mut Module, zero: f64) {
    assert_turned(module, zero, 0.0);
    let counts = module.gap(Ap::EncoderCounter);
    assert!(f64::from(counts.abs()) < SLACK * 40_000.0, "{counts}");
}

/// Axis parameter 208, bit 7 (§6): no step during the last 2^20 clocks, 65.5 ms at 16 MHz.
#[test]
fn the_driver_reports_standstill() {
    const STANDSTILL: i32 = 1 << 7;
    let mut module = Module::new();
    module.ok(Command::RotateRight, 0, 0, 1000);
    module.run_ms(100);
    assert_eq!(module.gap(Ap::DriverErrorFlags) & STANDSTILL, 0);
    module.ok(Command::MotorStop, 0, 0, 0);
    module.run_ms(40);
    assert_eq!(module.gap(Ap::DriverErrorFlags) & STANDSTILL, 0, "not yet");
    module.run_ms(100);
    assert_eq!(module.gap(Ap::DriverErrorFlags) & STANDSTILL, STANDSTILL);
}

mod changes_in_flight {
    use super::*;

    /// Starts a move over four turns and lets it get to speed.
    fn under_way() -> Module {
        let mut module = Module::new();
        move_to(&mut module, 4 * TURN);
        module.run_ms(1500);
        assert_eq!(module.gap(Ap::ActualVelocity), TURN);
        module
    }

    #[test]
    fn a_farther_target_prolongs_the_move() {
        let mut module = under_way();
        move_to(&mut module, 6 * TURN);
        assert_eq!(module.gap(Ap::ActualVelocity), TURN, "without a halt");
        let ticks = finish_within_limits(&mut module);
        // 7 s in all: 6 turns at 1 turn/s, and 1 s for the ramps.
        assert!((5499 * TICKS_PER_MS..=5501 * TICKS_PER_MS).contains(&ticks), "{ticks}");
    }

    #[test]
    fn a_nearer_target_that_can_still_be_braked_for_is_reached_directly() {
        let mut module = under_way();
        move_to(&mut module, 2 * TURN);
        let ticks = finish_within_limits(&mut module);
        assert!((1499 * TICKS_PER_MS..=1501 * TICKS_PER_MS).contains(&ticks), "{ticks}");
    }

    #[test]
    fn a_target_behind_turns_it_round() {
        let mut module = under_way();
        move_to(&mut module, -TURN);
        let mut farthest = 0;
        let (mut before, limit) = (i64::from(TURN), i64::from(TURN));
        while module.gap(Ap::PositionReached) == 0 {
            module.run_ticks(1);
            farthest = farthest.max(module.gap(Ap::ActualPosition));
            let velocity = i64::from(module.gap(Ap::ActualVelocity));
            assert!(velocity.abs() <= limit);
            // 2.56 pps a tick, and what rounding makes of it; the last tick may drop the last fraction.
            let arrived = module.gap(Ap::ActualPosition) == -TURN;
            assert!((velocity - before).abs() <= 4 || arrived, "{before} to {velocity}");
            before = velocity;
        }
        // At one turn after 1.5 s, and v²/2a = half a turn of braking.
        assert!((farthest - 3 * TURN / 2).abs() < 100, "{farthest}");
        assert_eq!(module.gap(Ap::ActualPosition), -TURN);
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualPosition), -TURN);
    }

    /// §8.4, open point 269: updated on-line.
    #[test]
    fn a_new_velocity_counts_at_once() {
        for velocity in [3 * TURN / 2, TURN / 4] {
            let mut module = under_way();
            module.sap(Ap::MaxVelocity, velocity);
            module.run_ms(1010);
            assert_eq!(module.gap(Ap::ActualVelocity), velocity);
            finish_within_limits(&mut module);
            assert_eq!(module.gap(Ap::ActualPosition), 4 * TURN);
        }
    }

    #[test]
    fn a_new_acceleration_counts_at_once() {
        let mut module = under_way();
        module.sap(Ap::MaxAcceleration, 10 * TURN);
        let ticks = finish_within_limits(&mut module);
        // At 1 turn, 1 turn/s; braking takes 0.1 s and 0.05 turns: 2.95 s + 0.1 s.
        assert!((3049 * TICKS_PER_MS..=3051 * TICKS_PER_MS).contains(&ticks), "{ticks}");
        assert_eq!(module.gap(Ap::ActualPosition), 4 * TURN);
    }

    /// Too slow to brake now: it may overshoot, but it comes back and ends exactly.
    #[test]
    fn a_much_lower_acceleration_still_ends_exactly() {
        let mut module = under_way();
        move_to(&mut module, 7 * TURN / 4);
        module.run_ms(400);
        module.sap(Ap::MaxAcceleration, TURN / 4);
        finish(&mut module);
        assert_eq!(module.gap(Ap::ActualPosition), 7 * TURN / 4);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualPosition), 7 * TURN / 4);
    }

    #[test]
    fn a_move_from_a_rotation_and_a_rotation_from_a_move() {
        let mut module = Module::new();
        module.ok(Command::RotateLeft, 0, 0, TURN);
        module.run_ms(1500);
        move_to(&mut module, TURN);
        finish(&mut module);
        assert_eq!(module.gap(Ap::ActualPosition), TURN);
        move_to(&mut module, 5 * TURN);
        module.run_ms(1500);
        module.ok(Command::RotateLeft, 0, 0, 1000);
        module.run_ms(1100);
        assert_eq!(module.gap(Ap::ActualVelocity), -1000);
    }
}

mod determinism {
    use super::*;

    /// A day in the life of a module: everything it answers, and where the rotor really is.
    fn session(module: &mut Module, seed: u32) -> Vec<(Vec<u8>, u64)> {
        let mut random = seed;
        let mut next = |below: u32| {
            random ^= random << 13;
            random ^= random >> 17;
            random ^= random << 5;
            random % below
        };
        let mut seen = Vec::new();
        for _ in 0..400 {
            let position = next(200_000).cast_signed() - 100_000;
            let request = match next(8) {
                0 => Request::new(Command::RotateRight, 0, 0, position),
                1 => Request::new(Command::MoveToPosition, 0, 0, position),
                2 => Request::new(Command::MoveToPosition, 1, 0, position),
                3 => Request::new(Command::SetAxisParameter, 4, 0, position.abs()),
                4 => Request::new(Command::SetAxisParameter, 5, 0, position.abs() + 1),
                5 => Request::new(Command::GetGlobalParameter, 133, 0, 0),
                6 => Request::new(Command::GetAxisParameter, 209, 0, 0),
                _ => Request::new(Command::GetAxisParameter, 1, 0, 0),
            };
            let answer = module.exchange(&tmcl_wire::serial::encode_request(1, request));
            seen.push((answer, module.turns().to_bits()));
            module.run_ticks(u64::from(next(600)));
        }
        seen
    }

    #[test]
    fn the_same_inputs_give_the_same_replies_and_positions() {
        assert_eq!(session(&mut Module::new(), 1), session(&mut Module::new(), 1));
    }

    #[test]
    fn a_snapshot_runs_on_like_the_original() {
        let mut original = Module::new();
        session(&mut original, 2);
        // In the middle of a datagram, too.
        original.exchange(&[1, 6, 1]);
        let mut snapshot = original.clone();
        assert_eq!(session(&mut original, 3), session(&mut snapshot, 3));
        original.run_ms(1000);
        assert_eq!(original.turns(), {
            snapshot.run_ms(1000);
            snapshot.turns()
        });
    }
}
