//! Torque mode: AP 14, 15, 19, 20, 141 (TMCM-1311 §8.7; decisions 5.1, 5.13), judged by torque, speed and coil currents.

use std::f64::consts::{SQRT_2, TAU};

use crate::common::TURN;
use crate::common::closed_loop::{Axis, MOTOR, MOTORS, amplitude_a, bench, bit, full_torque_nm};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, Status};

/// Holds a motor in torque mode to a few turns a second.
const VISCOUS: &str = "viscous_nm_s_per_rad = 0.1";

const UNREGULATED: (Ap, i32) = (Ap::CurrentScaleEnable, 0);

/// The current follows at once.
const AT_ONCE: (Ap, i32) = (Ap::TorqueCurrentSlope, 0);

fn torque(axis: &mut Axis, current_ma: i32) {
    axis.sap(Ap::TorqueTargetCurrent, current_ma);
}

/// The mean torque by the angle over so many turns: the work done, by the angle.
fn mean_torque_nm(axis: &mut Axis, turns: f64) -> f64 {
    let start = axis.turns();
    let (mut before, mut work) = (start, 0.0);
    for _ in 0..200_000 {
        axis.run_ticks(1);
        let now = axis.turns();
        work += axis.physical().torque_nm * (now - before);
        before = now;
        if (now - start).abs() >= turns {
            return work / (now - start);
        }
    }
    panic!("only {} turns in 10 s; {}", axis.turns() - start, axis.figures())
}

#[test]
fn the_torque_is_that_of_the_current() {
    for (motor, max_current) in MOTORS {
        let largest = if max_current < 128 { 900 } else { 2700 };
        for current_ma in [largest / 5, largest / 2, -largest / 2, largest, -largest] {
            let viscous = if max_current < 128 { "viscous_nm_s_per_rad = 0.03" } else { VISCOUS };
            let mut axis =
                Axis::on(&bench(motor, 40_000, viscous), 40_000, &[AT_ONCE, (Ap::MaxCurrent, max_current)]);
            torque(&mut axis, current_ma);
            axis.run_ms(1000);
            let what = format!("{motor}, {current_ma} mA");
            let expected = full_torque_nm(motor, f64::from(current_ma) / 1000.0);
            let mean = mean_torque_nm(&mut axis, 1.0);
            assert!(
                (mean / expected - 1.0).abs() < 0.05,
                "{what}: {mean:.4} Nm over a turn, not {expected:.4}"
            );
            let flows = amplitude_a(&axis);
            let commanded = f64::from(current_ma.abs()) / 1000.0 * SQRT_2;
            assert!(
                (flows / commanded - 1.0).abs() < 0.05,
                "{what}: an amplitude of {flows} A, not {commanded}"
            );
            assert_eq!(axis.gap(Ap::TorqueActualCurrent), current_ma, "{what}: AP 19");
            assert_eq!(axis.gap(Ap::TorqueTargetCurrent), current_ma, "{what}: AP 14");
            // 90° ahead, on the side of the sign.
            let lead_deg = axis.mean(400, |axis| axis.physical().load_angle_deg);
            let side = f64::from(current_ma.signum());
            assert!((lead_deg - 90.0 * side).abs() < 6.0, "{what}: the field leads by {lead_deg:.1}°");
            axis.assert_agrees();
        }
    }
}

/// The same at 4000 counts, and with the field weakening out of reach.
#[test]
fn a_coarse_encoder_gives_the_same_torque() {
    for current_ma in [1000, -1000] {
        let settings = [AT_ONCE, (Ap::MaxCurrent, 255)];
        let mut axis = Axis::on(&bench(MOTOR, 4000, VISCOUS), 4000, &settings);
        torque(&mut axis, current_ma);
        axis.run_ms(1000);
        let (mean, expected) =
            (mean_torque_nm(&mut axis, 1.0), full_torque_nm(MOTOR, f64::from(current_ma) / 1000.0));
        assert!(
            (mean / expected - 1.0).abs() < 0.05,
            "{current_ma} mA: {mean:.4} Nm over a turn, not {expected:.4}"
        );
    }
}

/// Against a weight: less current than it needs lets it sink, more lifts it, whatever way the motor turns.
#[test]
fn the_torque_does_not_depend_on_the_direction_of_motion() {
    for (load_nm, sinks) in [(-0.3, true), (-0.5, true), (-0.05, false)] {
        let file = bench(MOTOR, 40_000, "viscous_nm_s_per_rad = 0.05");
        let mut axis = Axis::on(&file, 40_000, &[AT_ONCE, (Ap::MaxCurrent, 255)]);
        axis.set("load.torque_nm", load_nm);
        torque(&mut axis, 500);
        axis.run_ms(1000);
        let expected = full_torque_nm(MOTOR, 0.5);
        let mean = mean_torque_nm(&mut axis, 0.5);
        let rpm = axis.physical().velocity_rpm;
        assert_eq!(rpm < 0.0, sinks, "{expected:.3} Nm against {load_nm} Nm turn it at {rpm} rpm");
        assert!(
            (mean / expected - 1.0).abs() < 0.05,
            "{load_nm} Nm: {mean:.4} Nm over half a turn, not {expected:.4}"
        );
    }
}

/// The shaft's speed is what load and torque make of it.
#[test]
fn the_speed_follows_from_the_load() {
    let mut axis = Axis::on(&bench(MOTOR, 40_000, VISCOUS), 40_000, &[AT_ONCE, (Ap::MaxCurrent, 255)]);
    for current_ma in [2000, 1000, -1500] {
        torque(&mut axis, current_ma);
        axis.run_ms(1000);
        let amps = f64::from(current_ma) / 1000.0;
        let expected_rad_s = (full_torque_nm(MOTOR, amps) - 0.01 * amps.signum()) / 0.1;
        let before = axis.turns();
        axis.run_ms(1000);
        let rad_s = (axis.turns() - before) * TAU;
        assert!(
            (rad_s / expected_rad_s - 1.0).abs() < 0.05,
            "{current_ma} mA: {rad_s} rad/s, not {expected_rad_s}"
        );
        let bits = [bit::POSITION, bit::VELOCITY, bit::TORQUE].map(|bit| axis.status_bit(bit));
        assert_eq!(bits, [false, false, true], "bits 3 to 5 of AP 18");
        assert_eq!(axis.gap(Ap::RampMode), 2, "AP 128");
    }
}

/// Ticks until AP 19 has this value.
#[track_caller]
fn ticks_until(axis: &mut Axis, current_ma: i32) -> f64 {
    for ticks in 0..400_000_u32 {
        if axis.gap(Ap::TorqueActualCurrent) == current_ma {
            return f64::from(ticks);
        }
        axis.run_ticks(1);
    }
    panic!("AP 19 never is {current_ma}; it is {}", axis.gap(Ap::TorqueActualCurrent))
}

#[test]
fn the_current_follows_the_slope() {
    for slope in [500, 1000, 8000] {
        let mut axis = Axis::on(
            &bench(MOTOR, 40_000, VISCOUS),
            40_000,
            &[(Ap::MaxCurrent, 255), (Ap::TorqueCurrentSlope, slope)],
        );
        let what = |from: i32, to: i32| format!("AP 20 = {slope}: from {from} to {to} mA");
        for (from, to) in [(0, 1000), (1000, 1500), (1500, -500), (-500, 0)] {
            torque(&mut axis, to);
            assert_eq!(axis.gap(Ap::TorqueTargetCurrent), to, "AP 14");
            let expected_ms = f64::from((to - from).abs()) / f64::from(slope) * 1000.0;
            axis.run_ms((expected_ms / 2.0) as u64);
            let half = axis.gap(Ap::TorqueActualCurrent);
            let off = f64::from(half) - f64::from(from + to) / 2.0;
            assert!(
                off.abs() <= 5.0 + f64::from(slope) / 500.0,
                "{}: half-way AP 19 is {half}",
                what(from, to)
            );
            if half.abs() > 200 {
                let (flows, commanded) = (amplitude_a(&axis), f64::from(half.abs()) / 1000.0 * SQRT_2);
                assert!(
                    (flows / commanded - 1.0).abs() < 0.06,
                    "{}: {flows} A flow, AP 19 means {commanded}",
                    what(from, to)
                );
            }
            let ms = expected_ms / 2.0 + ticks_until(&mut axis, to) / 20.0;
            assert!((ms - expected_ms).abs() < 4.0, "{}: {ms} ms, not {expected_ms}", what(from, to));
        }
    }
}

/// AP 141: between 0 and this the current jumps.
#[test]
fn it_starts_and_stops_with_the_start_stop_current() {
    let settings = [(Ap::MaxCurrent, 255), (Ap::TorqueCurrentSlope, 1000), (Ap::TorqueStartStopCurrent, 300)];
    let mut axis = Axis::on(&bench(MOTOR, 40_000, VISCOUS), 40_000, &settings);
    torque(&mut axis, 1000);
    axis.run_ms(2);
    let start = axis.gap(Ap::TorqueActualCurrent);
    assert!((300..=304).contains(&start), "2 ms after the start AP 19 is {start}");
    axis.run_ms(3);
    let flows = amplitude_a(&axis);
    assert!((flows / (0.305 * SQRT_2) - 1.0).abs() < 0.1, "{flows} A flow after the start");
    let ms = ticks_until(&mut axis, 1000) / 20.0 + 5.0;
    assert!((ms - 700.0).abs() < 4.0, "from 300 to 1000 mA in {ms} ms, not 700");
    torque(&mut axis, 0);
    let ms = ticks_until(&mut axis, 0) / 20.0;
    assert!((ms - 700.0).abs() < 6.0, "from 1000 to 300 mA and off in {ms} ms, not 700");
    // A target below it is jumped to.
    torque(&mut axis, -200);
    axis.run_ms(2);
    assert_eq!(axis.gap(Ap::TorqueActualCurrent), -200, "a target below AP 141");
    torque(&mut axis, -600);
    let ms = ticks_until(&mut axis, -600) / 20.0;
    assert!((300.0..404.0).contains(&ms), "from -200 to -600 mA in {ms} ms");
    // Through 0: 300 down, 300 up at the slope.
    torque(&mut axis, 600);
    let ms = ticks_until(&mut axis, 600) / 20.0;
    assert!((ms - 600.0).abs() < 8.0, "from -600 to 600 mA in {ms} ms, not 600: AP 141 jumps over 0");
}

/// AP 19 can be set: the slope goes on from there.
#[test]
fn writing_the_actual_current_goes_on_from_there() {
    let settings = [(Ap::MaxCurrent, 255), (Ap::TorqueCurrentSlope, 1000)];
    let mut axis = Axis::on(&bench(MOTOR, 40_000, VISCOUS), 40_000, &settings);
    torque(&mut axis, 1000);
    axis.run_ms(100);
    axis.sap(Ap::TorqueActualCurrent, 800);
    let ms = ticks_until(&mut axis, 1000) / 20.0;
    assert!((ms - 200.0).abs() < 4.0, "from 800 to 1000 mA in {ms} ms, not 200");
}

/// AP 15 is the limit: more is accepted and not given.
#[test]
fn the_current_is_limited_to_the_possible() {
    for (max_current, vsense, limit_ma) in [(128, 0, 1593), (255, 0, 3000), (255, 1, 1500), (60, 0, 750)] {
        let settings = [AT_ONCE, (Ap::MaxCurrent, max_current), (Ap::Vsense, vsense)];
        let mut axis = Axis::on(&bench(MOTOR, 40_000, VISCOUS), 40_000, &settings);
        let what = format!("AP 6 = {max_current}, AP 179 = {vsense}");
        assert_eq!(axis.gap(Ap::MaxPossibleCurrent), limit_ma, "{what}: AP 15");
        for sign in [1, -1] {
            torque(&mut axis, sign * 3000);
            axis.run_ms(500);
            assert_eq!(axis.gap(Ap::TorqueActualCurrent), sign * limit_ma, "{what}: AP 19");
            let (flows, possible) = (amplitude_a(&axis), f64::from(limit_ma) / 1000.0 * SQRT_2);
            assert!(
                (flows / possible - 1.0).abs() < 0.05,
                "{what}: {flows} A flow, {possible} A are possible"
            );
        }
        let status = |value| (Command::SetAxisParameter, Ap::TorqueTargetCurrent.number(), 0, value);
        for value in [3001, -3001] {
            let (command, kind, motor, value) = status(value);
            assert_eq!(axis.status(command, kind, motor, value), Status::InvalidValue, "SAP 14, {value}");
        }
    }
}

/// In the other modes AP 14 reads the advance angle: how far the field leads the rotor, in µsteps.
#[test]
fn ap_14_reads_the_advance_angle_in_the_other_modes() {
    for turns_per_s in [1, -1, 3] {
        for friction_nm in [0.1, 0.3] {
            let mut axis = Axis::new(&[UNREGULATED, (Ap::MaxVelocity, 10 * TURN)]);
            axis.set("load.friction_nm", friction_nm);
            for mode in ["velocity", "position"] {
                if mode == "velocity" {
                    axis.rotate(turns_per_s * TURN);
                } else {
                    axis.sap(Ap::MaxVelocity, turns_per_s.abs() * TURN);
                    let far = axis.gap(Ap::ActualPosition) + turns_per_s * 400_000;
                    axis.go(far);
                }
                axis.run_ms(1000);
                let mut truth = 0.0;
                let read = axis.mean(8000, |axis| {
                    truth += axis.physical().load_angle_deg / 360.0 * 1024.0 / 8000.0;
                    f64::from(axis.gap(Ap::TorqueTargetCurrent))
                });
                // The rotor turns on while the field is held for a control period.
                let tolerance = 6.0 + 3.0 * f64::from(turns_per_s.abs()) + 0.05 * truth.abs();
                assert!(
                    (read - truth).abs() < tolerance && truth * f64::from(turns_per_s) > 10.0,
                    "{mode} mode, {turns_per_s} turns/s, {friction_nm} Nm: AP 14 is {read:.1}, the field leads by {truth:.1}"
                );
            }
        }
    }
}

/// Turning at 300 mA with a flywheel, until the speed is steady: a few turns a second.
fn spinning() -> (Axis, f64) {
    let file = bench(MOTOR, 40_000, "inertia_kgm2 = 1e-3\nviscous_nm_s_per_rad = 0.004");
    let settings = [UNREGULATED, AT_ONCE, (Ap::MaxVelocity, 20 * TURN), (Ap::MaxAcceleration, 2 * TURN)];
    let mut axis = Axis::on(&file, 40_000, &settings);
    torque(&mut axis, 300);
    axis.run_ms(2500);
    let turns_per_s = axis.physical().velocity_rpm / 60.0;
    assert!((3.0..5.0).contains(&turns_per_s), "300 mA turn it at {turns_per_s} turns/s");
    (axis, turns_per_s)
}

/// The shaft's speed follows a straight line from the speed it has, `slope` in turns/s².
#[track_caller]
fn assert_follows(axis: &mut Axis, from: f64, slope: f64, ms: u64, what: &str) {
    for elapsed in 1..=ms {
        axis.run_ms(1);
        let now = axis.physical().velocity_rpm / 60.0;
        let expected = from + slope * elapsed as f64 / 1000.0;
        assert!(
            (now - expected).abs() < 0.08 * from,
            "{what}: {elapsed} ms later it turns at {now:.3} turns/s, not {expected:.3}; {}",
            axis.figures()
        );
    }
}

#[test]
fn leaving_torque_mode_is_no_jump() {
    let (mut axis, speed) = spinning();
    axis.ok(Command::MotorStop, 0, 0, 0);
    assert_eq!(axis.gap(Ap::RampMode), 1, "MST selects velocity mode");
    assert_follows(&mut axis, speed, -2.0, (speed * 400.0) as u64, "MST");
    axis.run_ms(2000);
    let standing = axis.turns();
    axis.run_ms(200);
    assert!((axis.turns() - standing).abs() < 0.01, "MST stops it");

    let (mut axis, speed) = spinning();
    let same = (speed * f64::from(TURN)) as i32;
    axis.rotate(same);
    assert_follows(&mut axis, speed, 0.0, 500, "ROR at the speed it has");
    assert_eq!(axis.gap(Ap::RampMode), 1, "ROR selects velocity mode");
    axis.rotate(same + 2 * TURN);
    assert_follows(&mut axis, speed, 2.0, 900, "ROR to more");

    let (mut axis, speed) = spinning();
    axis.rotate(-TURN);
    assert_follows(&mut axis, speed, -2.0, 1000, "ROL");

    let (mut axis, speed) = spinning();
    let target = axis.gap(Ap::ActualPosition) + 400_000;
    axis.sap(Ap::MaxVelocity, (speed * f64::from(TURN)) as i32);
    axis.go(target);
    assert_eq!(axis.gap(Ap::RampMode), 0, "MVP selects position mode");
    assert_follows(&mut axis, speed, 0.0, 300, "MVP");
    axis.reach();
    axis.assert_at(target);
}

/// Into torque mode from motion, too: the current is there, in its direction.
#[test]
fn entering_torque_mode_from_motion() {
    let mut axis = Axis::on(&bench(MOTOR, 40_000, VISCOUS), 40_000, &[AT_ONCE, UNREGULATED]);
    axis.rotate(-2 * TURN);
    axis.run_ms(800);
    torque(&mut axis, 1000);
    axis.run_ms(1000);
    let (mean, expected) = (mean_torque_nm(&mut axis, 1.0), full_torque_nm(MOTOR, 1.0));
    assert!((mean / expected - 1.0).abs() < 0.05, "{mean:.4} Nm over a turn, not {expected:.4}");
    let rpm = axis.physical().velocity_rpm;
    assert!(rpm > 0.0, "turning to the right, not at {rpm} rpm");
}

/// AP 128 = 2 selects it as well, with the current there is: none.
#[test]
fn the_mode_can_be_selected_without_a_current() {
    let mut axis = Axis::on(&bench(MOTOR, 40_000, VISCOUS), 40_000, &[AT_ONCE]);
    axis.sap(Ap::RampMode, 2);
    axis.run_ms(100);
    assert!(axis.status_bit(bit::TORQUE), "bit 5 of AP 18");
    assert_eq!(axis.gap(Ap::TorqueActualCurrent), 0, "AP 19");
    let flows = amplitude_a(&axis);
    assert!(flows < 0.05, "no current is asked for, and {flows} A flow");
}

/// A motor that is stopped at once before a switch is braked, and not thrown back out of it time and again.
#[test]
fn it_comes_to_rest_before_a_stop_switch() {
    let file = format!("{}[module.switches]\nright = {{ at_turns = 2.0 }}\n", bench(MOTOR, 40_000, ""));
    let mut axis = Axis::on(&file, 40_000, &[]);
    torque(&mut axis, 600);
    axis.run_ms(1000);
    for _ in 0..100 {
        axis.run_ms(10);
        let (turns, rpm) = (axis.turns(), axis.physical().velocity_rpm);
        assert!((1.9..2.1).contains(&turns) && rpm.abs() < 60.0, "at {turns} turns, {rpm} rpm");
    }
}
