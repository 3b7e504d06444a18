//! What positions mean: relative moves, setting the counters, microstep resolution, and a rotor that does not follow.

use crate::common::motion::{SLACK, assert_turned, finish, move_to};
use crate::common::{Module, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

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
/// slowly, well below the resonance of motor and field, so that what they set swinging comes to rest.
#[test]
fn the_microstep_resolution_scales_positions_and_velocities() {
    for resolution in 0..=8 {
        let mut module = Module::new();
        let turn = 200 << resolution;
        let velocity = if resolution < 2 { turn / 10 } else { turn };
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
