//! Position mode of the TMCM-1640 (§7.5; decisions 6.1, 6.11): where the shaft really goes, by encoder and by halls.

use crate::common::bldc::{Bldc, ENCODER_TURN, HALL_TURN, RATED_NM, bench, flag};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

/// A sensor that positions are counted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sensor {
    Hall,
    Encoder,
}

/// Milliseconds after the end flag in which the velocity regulator's integral overcomes the friction of the last few counts.
const SETTLE_MS: u64 = 3000;

impl Sensor {
    const ALL: [Self; 2] = [Self::Encoder, Self::Hall];

    fn counts(self) -> i32 {
        match self {
            Self::Hall => HALL_TURN,
            Self::Encoder => ENCODER_TURN,
        }
    }

    /// A module at rest that counts by it, with AP 1 = 0, and the turns of its shaft there.
    #[track_caller]
    fn axis(self) -> (Bldc, f64) {
        let mut axis = Bldc::strong();
        if self == Self::Encoder {
            axis.use_encoder();
        }
        axis.run_ms(50);
        axis.sap(Ap::ActualPosition, 0);
        let zero = axis.turns();
        (axis, zero)
    }
}

/// Where the shaft is, in counts from where it was when AP 1 was 0.
fn shaft(axis: &Bldc, zero: f64, sensor: Sensor) -> f64 {
    (axis.turns() - zero) * f64::from(sensor.counts())
}

/// The shaft stands within AP 10 of a position, to the count that each of the two readings is uncertain by.
#[track_caller]
fn assert_at(axis: &mut Bldc, zero: f64, sensor: Sensor, position: i32) {
    let window = f64::from(axis.gap(Ap::TargetReachedDistance));
    let off = shaft(axis, zero, sensor) - f64::from(position);
    let figures = axis.figures();
    assert!(off.abs() <= window + 1.5, "{sensor:?}: {off:.2} counts off {position}; {figures}");
}

#[test]
fn fifty_turns_and_back() {
    for sensor in Sensor::ALL {
        let (mut axis, zero) = sensor.axis();
        for target in [50 * sensor.counts(), 0] {
            axis.go(target);
            assert_eq!(axis.gap(Ap::PositionReached), 0, "the flag goes with the command");
            assert!(axis.flag(flag::POSITION_MODE) && !axis.flag(flag::POSITION_END));
            let ms = axis.reach(6000);
            // 2000 rpm/s: 2.4 s at the least.
            assert!(ms > 2300, "{sensor:?}: {ms} ms is faster than AP 11 allows");
            axis.run_ms(SETTLE_MS);
            assert_at(&mut axis, zero, sensor, target);
            assert_eq!(axis.gap(Ap::PositionReached), 1);
            assert!(axis.flag(flag::POSITION_END));
            for _ in 0..500 {
                axis.run_ms(1);
                assert_at(&mut axis, zero, sensor, target);
            }
        }
    }
}

/// Bit 14 and AP 8: only when position and velocity say so (§7.5, figure 7.5), by the truth; always when both have for a while.
#[test]
fn the_end_flag_needs_position_and_velocity() {
    for sensor in Sensor::ALL {
        for (distance, velocity) in [(5, 500), (2, 30), (sensor.counts(), 60)] {
            let (mut axis, zero) = sensor.axis();
            axis.set_all(&[
                (Ap::TargetReachedDistance, distance),
                (Ap::TargetReachedVelocity, velocity),
                (Ap::MaxAcceleration, 10_000),
            ]);
            let target = 5 * sensor.counts();
            axis.go(target);
            let mut reached = 0;
            for _ in 0..3000 {
                axis.run_ms(1);
                let said = axis.gap(Ap::PositionReached) == 1;
                assert_eq!(said, axis.flag(flag::POSITION_END), "AP 8 is bit 14");
                let off = (shaft(&axis, zero, sensor) - f64::from(target)).abs();
                let rpm = axis.rpm().abs();
                let in_a_ms = rpm / 60e3 * f64::from(sensor.counts());
                let near = off <= f64::from(distance) + 1.5 + 2.0 * in_a_ms;
                // By halls the speed is a mean since the last edge, so only position is judged sharply there.
                let slow = rpm <= f64::from(velocity) * 1.3 + 60.0 || sensor == Sensor::Hall;
                assert!(!said || near && slow, "{sensor:?}: flag at {off:.1} counts off and {rpm:.0} rpm");
                reached += u32::from(said);
            }
            assert!(reached > 500, "{sensor:?} {distance} {velocity}: {reached} ms; {}", axis.figures());
        }
    }
}

#[test]
fn the_end_flag_falls_when_the_shaft_is_forced_away() {
    let (mut axis, zero) = Sensor::Encoder.axis();
    axis.go(ENCODER_TURN);
    axis.reach(3000);
    axis.run_ms(SETTLE_MS);
    axis.sap(Ap::MaxCurrent, 500);
    axis.set("load.torque_nm", RATED_NM / 4.0);
    axis.run_ms(60);
    assert!(shaft(&axis, zero, Sensor::Encoder) > f64::from(ENCODER_TURN) + 100.0);
    assert_eq!(axis.gap(Ap::PositionReached), 0);
    axis.set("load.torque_nm", 0);
    axis.sap(Ap::MaxCurrent, 7000);
    axis.run_ms(5000);
    assert_at(&mut axis, zero, Sensor::Encoder, ENCODER_TURN);
    assert_eq!(axis.gap(Ap::PositionReached), 1);
}

#[test]
fn with_the_ramp_it_hardly_overshoots_and_keeps_axis_parameter_4() {
    for sensor in Sensor::ALL {
        for acceleration in [2000, 10_000] {
            let (mut axis, zero) = sensor.axis();
            axis.set_all(&[(Ap::MaxAcceleration, acceleration), (Ap::MaxVelocity, 1500)]);
            let target = 30 * sensor.counts();
            axis.go(target);
            let mut fastest = 0.0_f64;
            let mut farthest = 0.0_f64;
            for _ in 0..5500 {
                axis.run_ms(1);
                fastest = fastest.max(axis.rpm());
                farthest = farthest.max(shaft(&axis, zero, sensor));
            }
            assert!(fastest < 1500.0 * 1.05, "{sensor:?}: {fastest:.0} rpm with 1500 allowed");
            assert!(fastest > 1300.0, "{sensor:?}: {fastest:.0} rpm");
            let over = farthest - f64::from(target);
            // A hundredth of a turn by encoder; by halls two of the coarse counts (decisions 6.11).
            let allowed = if sensor == Sensor::Hall { 3.0 } else { 45.0 };
            assert!(over < allowed, "{sensor:?}, {acceleration} rpm/s: {over:.1} counts beyond the target");
            assert_at(&mut axis, zero, sensor, target);
        }
    }
}

/// §7.5: without the ramp the target goes through the P regulator alone, clipped to AP 4.
#[test]
fn without_the_ramp_it_arrives_faster() {
    let mut times = Vec::new();
    for ramp in [1, 0] {
        let (mut axis, zero) = Sensor::Encoder.axis();
        axis.set_all(&[(Ap::EnableRamp, ramp), (Ap::MaxVelocity, 2000)]);
        axis.go(10 * ENCODER_TURN);
        if ramp == 0 {
            axis.run_ms(100);
            assert!((axis.rpm() / 2000.0 - 1.0).abs() < 0.1, "{}", axis.figures());
        }
        times.push(axis.reach(4000));
        axis.run_ms(SETTLE_MS);
        assert_at(&mut axis, zero, Sensor::Encoder, 10 * ENCODER_TURN);
    }
    assert!(times[1] < times[0], "{times:?} ms with and without ramp");
}

#[test]
fn relative_moves_are_relative_to_the_actual_position() {
    let (mut axis, zero) = Sensor::Encoder.axis();
    axis.go(ENCODER_TURN);
    axis.reach(3000);
    axis.run_ms(SETTLE_MS);
    // Away from the target by a turn and something: MVP REL still counts from AP 1 (§4.6.4).
    axis.rotate(120);
    axis.run_ms(700);
    axis.halt();
    axis.run_ms(500);
    let from = axis.gap(Ap::ActualPosition);
    axis.go_by(1000);
    let target = axis.gap(Ap::TargetPosition);
    assert!((target - from - 1000).abs() <= 2, "from {from} by 1000 to {target}");
    axis.reach(3000);
    axis.run_ms(SETTLE_MS);
    assert_at(&mut axis, zero, Sensor::Encoder, target);
    axis.go_by(-3000);
    axis.reach(3000);
    axis.run_ms(SETTLE_MS);
    let target = axis.gap(Ap::TargetPosition);
    assert!((target - from + 2000).abs() <= 12, "from {from} by 1000 and −3000 to {target}");
    assert_at(&mut axis, zero, Sensor::Encoder, target);
}

/// Decisions 2a.1: SAP 0 moves as MVP ABS does; the reply to either leaves AP 8 at 0.
#[test]
fn writing_the_target_position_moves_there() {
    let (mut axis, zero) = Sensor::Encoder.axis();
    axis.sap(Ap::TargetPosition, -2048);
    assert_eq!(axis.gap(Ap::PositionReached), 0);
    assert!(axis.flag(flag::POSITION_MODE));
    axis.reach(3000);
    axis.run_ms(SETTLE_MS);
    assert_at(&mut axis, zero, Sensor::Encoder, -2048);
}

/// §5.1: "Set/get the position counter without moving the motor."
#[test]
fn writing_the_actual_position_moves_nothing() {
    for sensor in Sensor::ALL {
        let (mut axis, zero) = sensor.axis();
        let turn = sensor.counts();
        axis.go(2 * turn);
        axis.reach(3000);
        axis.run_ms(SETTLE_MS);
        let (position, before) = (axis.gap(Ap::ActualPosition), axis.turns());
        axis.sap(Ap::ActualPosition, 100 * turn);
        assert_eq!(axis.gap(Ap::ActualPosition), 100 * turn);
        assert_eq!(axis.gap(Ap::TargetPosition), 102 * turn - position, "the target goes along");
        axis.run_ms(500);
        let moved = (axis.turns() - before) * f64::from(turn);
        assert!(moved.abs() < 8.0, "{sensor:?}: moved by {moved:.1} counts");
        axis.go(101 * turn);
        axis.reach(3000);
        axis.run_ms(SETTLE_MS);
        assert_at(&mut axis, zero, sensor, 101 * turn - (100 * turn - position));
    }
}

/// The readings of the position follow the shaft, at rest and turning either way.
#[test]
fn positions_read_are_where_the_shaft_is() {
    for sensor in Sensor::ALL {
        let (mut axis, zero) = sensor.axis();
        let counter_zero = axis.gap(Ap::EncoderCounter);
        for rpm in [0, 600, -1500, 3000] {
            axis.rotate(rpm);
            for _ in 0..300 {
                axis.run_ms(3);
                let a_period = axis.rpm().abs() / 60.0 * 50e-6;
                let turn = f64::from(sensor.counts());
                let position = f64::from(axis.gap(Ap::ActualPosition));
                let real = shaft(&axis, zero, sensor);
                let off = (position - real).abs();
                assert!(off <= 1.5 + 3.0 * a_period * turn, "{sensor:?}: AP 1 = {position}, but {real:.1}");
                let counter = f64::from(axis.gap(Ap::EncoderCounter) - counter_zero);
                let real = (axis.turns() - zero) * f64::from(ENCODER_TURN);
                let off = (counter - real).abs();
                assert!(
                    off <= 2.5 + 3.0 * a_period * 4096.0,
                    "AP 209 went by {counter}, the shaft by {real:.1}"
                );
            }
        }
    }
}

#[test]
fn the_position_error_is_what_is_left_to_go() {
    let (mut axis, zero) = Sensor::Encoder.axis();
    let target = 20 * ENCODER_TURN;
    axis.go(target);
    for _ in 0..20 {
        axis.run_ms(50);
        let left = f64::from(target) - shaft(&axis, zero, Sensor::Encoder);
        let read = f64::from(axis.gap(Ap::PositionPidError));
        // The regulator ran up to a millisecond ago.
        let in_a_ms = axis.rpm().abs() / 60e3 * 4096.0;
        assert!((read - left).abs() <= 3.0 + 1.2 * in_a_ms, "AP 226 = {read}, {left:.1} are left");
    }
}

/// AP 230: the speed without ramp is P/256 rpm for each count (figure 7.4).
#[test]
fn the_position_gain_makes_velocity_of_distance() {
    for gain in [50, 300] {
        let (mut axis, zero) = Sensor::Encoder.axis();
        axis.set_all(&[(Ap::EnableRamp, 0), (Ap::PositionP, gain), (Ap::MaxVelocity, 4000)]);
        let target = 2 * ENCODER_TURN;
        axis.go(target);
        let mut checked = 0;
        for _ in 0..400 {
            axis.run_ms(1);
            let left = f64::from(target) - shaft(&axis, zero, Sensor::Encoder);
            let wanted = (left * f64::from(gain) / 256.0).min(4000.0);
            let ramp = f64::from(axis.gap(Ap::RampVelocity));
            let in_a_ms = axis.rpm().abs() / 60e3 * 4096.0 * f64::from(gain) / 256.0;
            assert!((ramp - wanted).abs() < 5.0 + 1.5 * in_a_ms, "AP 13 = {ramp}, P wants {wanted:.0}");
            checked += 1;
        }
        assert_eq!(checked, 400);
    }
    let (mut axis, zero) = Sensor::Encoder.axis();
    axis.sap(Ap::PositionP, 0);
    axis.go(ENCODER_TURN);
    axis.run_ms(500);
    assert!(shaft(&axis, zero, Sensor::Encoder).abs() < 30.0, "without gain it stays");
    assert_eq!(axis.gap(Ap::PositionReached), 0);
}

/// Decisions 6.12: AP 1 is rescaled, AP 0 becomes AP 1.
#[test]
fn changing_the_commutation_mode_rescales_the_position() {
    let (mut axis, zero) = Sensor::Hall.axis();
    axis.go(5 * HALL_TURN);
    axis.reach(3000);
    axis.run_ms(SETTLE_MS);
    let halls = axis.gap(Ap::ActualPosition);
    axis.sap(Ap::CommutationMode, 7);
    let counts = axis.gap(Ap::ActualPosition);
    let wanted = f64::from(halls) * f64::from(ENCODER_TURN) / f64::from(HALL_TURN);
    assert!((f64::from(counts) - wanted).abs() <= 3.0, "{halls} hall counts became {counts}");
    assert_eq!(axis.gap(Ap::TargetPosition), counts);
    axis.run_ms(1200);
    let off = f64::from(axis.gap(Ap::ActualPosition)) - shaft(&axis, zero, Sensor::Encoder);
    let a_hall_count = 4096.0 / 24.0;
    assert!(off.abs() < 1.2 * a_hall_count, "{off:.1} encoder counts between AP 1 and the shaft");
    let position = axis.gap(Ap::ActualPosition);
    axis.sap(Ap::CommutationMode, 6);
    let back = axis.gap(Ap::ActualPosition);
    assert!((f64::from(back) - f64::from(position) * 24.0 / 4096.0).abs() <= 1.0, "{position} became {back}");
    assert_eq!(axis.gap(Ap::TargetPosition), back);
}

/// AP 161 and 163: the N channel, which this bench has at every whole turn of the shaft and a quarter.
#[test]
fn the_null_channel_zeroes_the_position_once_or_always() {
    for once in [1, 0] {
        let mut axis = Bldc::strong_on(&bench("[module.encoder]\noffset_turns = 0.25"));
        axis.use_encoder();
        axis.set_all(&[(Ap::ActualPosition, 777_000), (Ap::ClearOnce, once), (Ap::ClearOnNull, 1)]);
        axis.rotate(300);
        let mut largest = 0;
        axis.run_ms(1500);
        for _ in 0..600 {
            axis.run_ms(1);
            largest = largest.max(axis.gap(Ap::ActualPosition));
        }
        let since = axis.turns() - 0.25;
        let position = f64::from(axis.gap(Ap::ActualPosition)) / 4096.0;
        if once == 1 {
            assert_eq!(axis.gap(Ap::ClearOnNull), 0, "done");
            assert!(largest > 2 * ENCODER_TURN, "{largest}");
            let off = position - since - (position - since).round();
            assert!(
                off.abs() < 0.01,
                "AP 1 = {position} turns, the shaft is at {since} since the first N pulse"
            );
        } else {
            assert!(largest < ENCODER_TURN + 20, "{largest}");
            assert!(largest > ENCODER_TURN - 80, "{largest}");
            assert!((position - since.rem_euclid(1.0)).abs() < 0.01, "{position}, but {since} turns");
        }
    }
}

/// AP 162: a stop switch's edge; IN_0 is the right one (§3.1).
#[test]
fn a_switch_event_zeroes_the_position() {
    for input in [0, 1] {
        let (mut axis, _) = Sensor::Encoder.axis();
        // Active high and not enabled: it does not stop the motor.
        axis.set_all(&[(Ap::StopSwitchPolarity, 3), (Ap::ClearOnSwitch, 1)]);
        axis.rotate(60);
        axis.run_ms(1500);
        assert!(axis.gap(Ap::ActualPosition) > ENCODER_TURN);
        axis.set(&format!("input.{input}"), 1);
        let at = axis.turns();
        axis.run_ms(500);
        let position = f64::from(axis.gap(Ap::ActualPosition));
        let turned = (axis.turns() - at) * f64::from(ENCODER_TURN);
        assert!(
            (position - turned).abs() < 5.0,
            "IN_{input}: AP 1 = {position}, {turned:.1} since the event"
        );
    }
}

/// MVP takes types 0 and 1 only; there are no coordinates (decisions 6.8).
#[test]
fn moves_to_coordinates_do_not_exist() {
    let mut axis = Bldc::new();
    for kind in 2..=3 {
        let status = axis.status(Command::MoveToPosition, kind, 0, 1);
        assert_eq!(status, tmcl_tables::Status::WrongType, "MVP {kind}");
    }
    assert!(axis.flag(flag::VELOCITY_MODE));
}
