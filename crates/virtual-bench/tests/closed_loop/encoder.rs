//! The encoder in closed loop: its offset (AP 112), null events (AP 201), and what a coarse one changes (AP 127, 212); against
//! the field and the shaft.

use crate::common::TURN;
use crate::common::closed_loop::{Axis, MOTOR, bench, full_torque_nm};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

const UNREGULATED: (Ap, i32) = (Ap::CurrentScaleEnable, 0);

/// More than the motor has.
const JAM_NM: f64 = 3.0;

/// Electrical degrees of so many encoder steps.
fn electrical_deg(axis: &Axis, steps: i32) -> f64 {
    f64::from(steps) / axis.counts * 50.0 * 360.0
}

/// On a shaft that nothing moves.
#[test]
fn the_offset_turns_the_field_ahead_by_just_that() {
    for counts in [40_000, 4000] {
        let mut axis = Axis::on(&bench(MOTOR, counts, ""), counts, &[UNREGULATED]);
        axis.land(0);
        axis.set("load.friction_nm", JAM_NM);
        axis.run_ms(50);
        let before = axis.physical().load_angle_deg;
        for steps in [1, 10, 20, -20, -1] {
            axis.sap(Ap::EncoderOffset, steps);
            axis.run_ms(50);
            let turned = axis.physical().load_angle_deg - before;
            let expected = electrical_deg(&axis, steps);
            // Half a µstep of rounding; the currents follow their commands to some percent.
            assert!(
                (turned - expected).abs() < 0.3 + 0.02 * expected.abs(),
                "{counts} counts, AP 112 = {steps}: the field turned by {turned}°, not {expected}°"
            );
        }
    }
}

/// At rest the loop makes up for it, and stays where it was told to be: AP 14 is ahead by as much less.
#[test]
fn at_rest_the_loop_makes_up_for_the_offset() {
    for steps in [40, -40] {
        let mut axis = Axis::new(&[UNREGULATED, (Ap::StandstillGain, 20), (Ap::PositionReachedWindow, 100)]);
        axis.land(10_000);
        axis.sap(Ap::EncoderOffset, steps);
        axis.run_ms(500);
        assert_eq!(axis.gap(Ap::PositionReached), 1, "{}", axis.figures());
        let off = axis.shaft() - 10_000.0;
        let lead = f64::from(axis.gap(Ap::TorqueTargetCurrent)) / 1.28;
        // Friction and detent torque want some, too.
        assert!((lead + f64::from(steps)).abs() < 25.0, "AP 112 = {steps}: AP 14 is {lead} encoder steps");
        assert!((off - f64::from(steps)).abs() < 25.0, "AP 112 = {steps}: {off} encoder steps off");
    }
}

/// A field that is not at 90° has the cosine of what it is off by, to either side.
#[test]
fn a_wrong_offset_costs_torque_as_its_cosine() {
    let viscous = "viscous_nm_s_per_rad = 0.1";
    let current_ma = 1000;
    for counts in [40_000, 4000] {
        for degrees in [0.0, 20.0, -20.0, 45.0, -45.0, 60.0, -60.0] {
            for sign in [1, -1] {
                let settings = [UNREGULATED, (Ap::TorqueCurrentSlope, 0)];
                let mut axis = Axis::on(&bench(MOTOR, counts, viscous), counts, &settings);
                let steps = (degrees / 360.0 / 50.0 * f64::from(counts)).round() as i32;
                axis.sap(Ap::EncoderOffset, steps);
                axis.sap(Ap::TorqueTargetCurrent, sign * current_ma);
                axis.run_ms(1500);
                let mean = axis.mean(10_000, |axis| axis.physical().torque_nm);
                let cosine = electrical_deg(&axis, steps).to_radians().cos();
                let expected =
                    full_torque_nm(MOTOR, f64::from(current_ma) / 1000.0) * cosine * f64::from(sign);
                // What the encoder's rounding and the control period make of the angle counts for more where it is off.
                let slack = 0.05 * expected.abs() + 0.05;
                assert!(
                    (mean - expected).abs() < slack,
                    "{counts} counts, {degrees}°, {sign} A: {mean:.3} Nm, not {expected:.3}"
                );
            }
        }
    }
}

/// An axis whose index is at a quarter of a turn.
fn with_index(mode: i32, settings: &[(Ap, i32)]) -> Axis {
    let file = bench(MOTOR, 40_000, "").replace("counts = 40000\n", "counts = 40000\noffset_turns = 0.25\n");
    let switches =
        "[module.switches]\nleft = { at_turns = -1.5 }\nhome = { at_turns = 0.5, width_turns = 0.1 }\n";
    let mut axis = Axis::on(&format!("{file}{switches}"), 40_000, settings);
    axis.sap(Ap::EncoderMode, mode);
    axis
}

/// A null event calls the place 0, and that is all it does: the shaft moves as it does without, to the last bit.
#[test]
fn a_null_event_moves_nothing() {
    let moves = |axis: &mut Axis| {
        let mut truth = Vec::new();
        // Away over the index, back over it, and by velocity once more.
        for turns in [1.6, -3.1] {
            axis.ok(Command::MoveToPosition, 1, 0, (turns * 40_000.0) as i32);
            for _ in 0..300 {
                axis.run_ms(10);
                truth.push(axis.physical());
            }
            assert_eq!(axis.gap(Ap::PositionReached), 1, "{}", axis.figures());
            let [target, position, counter, lag, virtual_position] = [
                Ap::TargetPosition,
                Ap::ActualPosition,
                Ap::EncoderCounter,
                Ap::PositionError,
                Ap::VirtualPosition,
            ]
            .map(|parameter| axis.gap(parameter));
            assert_eq!(position, counter);
            assert!((target - position - lag).abs() <= 1, "{}", axis.figures());
            assert!((f64::from(virtual_position) - f64::from(target) * 1.28).abs() <= 1.0);
        }
        axis.rotate(TURN);
        for _ in 0..100 {
            axis.run_ms(10);
            truth.push(axis.physical());
        }
        truth
    };
    let settings = [(Ap::RelativePositioningOption, 0)];
    let plain = moves(&mut with_index(0, &settings));
    for (mode, index) in [(4, 0.25), (8, -0.75), (4 | 8, -0.75)] {
        let mut axis = with_index(mode, &settings);
        assert_eq!(moves(&mut axis), plain, "AP 201 = {mode}");
        assert_eq!(axis.gap(Ap::EncoderMode), mode & 8, "the bit for the next event clears");
        // Every event clears it, so that it counts from the last index that was passed.
        let counter = f64::from(axis.gap(Ap::EncoderCounter));
        let from_index = (axis.turns() - index) * 40_000.0;
        let off = (counter - from_index) % 40_000.0;
        assert!(off.abs() < 8.0, "AP 201 = {mode}: AP 209 = {counter}, {from_index} from the index");
        if mode == 4 {
            assert!((counter - from_index).abs() < 8.0, "once: {counter}");
        } else {
            assert!(counter.abs() <= 40_000.0, "each time: {counter}");
        }
    }
}

/// Nor does it disturb a search that crosses the index.
#[test]
fn a_null_event_does_not_disturb_a_search() {
    let mut ends = Vec::new();
    for mode in [0, 4, 8] {
        let mut axis = with_index(mode, &[(Ap::ReferenceSearchMode, 7)]);
        axis.go(-20_000);
        axis.reach();
        axis.ok(Command::ReferenceSearch, 0, 0, 0);
        while axis.ok(Command::ReferenceSearch, 2, 0, 0) != 0 {
            axis.run_ms(1);
        }
        axis.run_ms(300);
        let zero = axis.turns() - f64::from(axis.gap(Ap::ActualPosition)) / 40_000.0;
        assert!((zero - 0.5).abs() < 4.0 / 40_000.0, "AP 201 = {mode}: 0 is at {zero} turns");
        ends.push(axis.physical());
    }
    assert!(ends.iter().all(|end| *end == ends[0]), "{ends:?}");
}

/// AP 212 is in 1/256 full steps however coarse the encoder is.
#[test]
fn the_deviation_is_in_microsteps_at_4000_counts() {
    for limit in [1500, 3000, -3000] {
        let mut axis = Axis::on(&bench(MOTOR, 4000, ""), 4000, &[UNREGULATED]);
        axis.sap(Ap::MaxEncoderDeviation, limit);
        axis.go(20_000);
        axis.run_ms(700);
        assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0, "without a jam; {}", axis.figures());
        let lag = (f64::from(axis.gap(Ap::VirtualPosition)) - axis.shaft() * 12.8).abs();
        assert!(lag < 400.0, "it lags by {lag} µsteps already");
        axis.set("load.friction_nm", JAM_NM);
        let start = axis.shaft();
        let ticks = (0..20_000).find(|_| {
            axis.run_ticks(1);
            axis.gap(Ap::EncoderDeviationFlag) == 1
        });
        let ticks: i32 = ticks.expect("AP 207 is set");
        // The ramp goes on at two turns a second, the shaft stops.
        let more = f64::from(ticks) * 2.0 * f64::from(TURN) / 20_000.0 - (axis.shaft() - start) * 12.8;
        let lag = lag + more;
        assert!((lag - f64::from(limit.abs())).abs() < 300.0, "AP 212 = {limit}: stopped at {lag} µsteps");
    }
}

/// MVP REL counts from the target, the ramp or the encoder at 4000 counts, too.
#[test]
fn relative_moves_at_4000_counts() {
    for option in [0, 1, 2] {
        let settings = [UNREGULATED, (Ap::RelativePositioningOption, option)];
        let mut axis = Axis::on(&bench(MOTOR, 4000, ""), 4000, &settings);
        axis.set("load.friction_nm", 0.3);
        axis.go(6000);
        axis.run_ms(700);
        let [target, position, lag] =
            [Ap::TargetPosition, Ap::ActualPosition, Ap::PositionError].map(|parameter| axis.gap(parameter));
        assert!(lag >= 2, "the load is to set them apart; {}", axis.figures());
        axis.ok(Command::MoveToPosition, 1, 0, -1000);
        let base = [target, position + lag, position][option as usize];
        assert_eq!(axis.gap(Ap::TargetPosition), base - 1000, "AP 127 = {option}");
        axis.set("load.friction_nm", 0.01);
        axis.reach();
        axis.assert_at(base - 1000);
        // Back and forth from rest: the target and the ramp do not drift.
        let target = axis.gap(Ap::TargetPosition);
        for _ in 0..5 {
            for way in [500, -500] {
                axis.ok(Command::MoveToPosition, 1, 0, way);
                axis.reach();
            }
        }
        let drift = axis.gap(Ap::TargetPosition) - target;
        let window = axis.gap(Ap::PositionReachedWindow);
        let allowed = if option == 2 { 10 * window } else { 0 };
        assert!(drift.abs() <= allowed, "AP 127 = {option}: it drifts by {drift}");
    }
}
