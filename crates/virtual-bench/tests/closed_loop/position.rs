//! Closed-loop positioning: where moves land, what the readings say, overloads and their compensation, stops
//! (TMCM-1311 §8.1, §8.4, §8.5, §9; decisions 2a, 5.1, 5.3, 5.9, 5.12, 5.13), judged by the shaft.

use crate::common::closed_loop::{Axis, MOTOR, MOTORS, amplitude_a, bench, bit};
use crate::common::motion::{finish, move_to};
use crate::common::program::listening;
use crate::common::{Module, TICKS_PER_MS, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

/// Full current all the time, so that nothing but positioning is looked at.
const UNREGULATED: (Ap, i32) = (Ap::CurrentScaleEnable, 0);

/// More than the motor pulls at any current.
const JAM_NM: i32 = 5;

#[test]
fn moves_land_whatever_motor_and_encoder() {
    for (motor, max_current) in MOTORS {
        for counts in [4000, 40_000] {
            // 50 of 4000 would be more than a full step.
            let window = counts / 800;
            let settings = [(Ap::MaxCurrent, max_current), (Ap::PositionReachedWindow, window)];
            let mut axis = Axis::on(&bench(motor, counts, ""), counts, &settings);
            for turns in [1.0, -0.7, 0.005, 0.0, 2.345, 2.35] {
                let target = axis.steps(turns);
                axis.land(target);
                assert_eq!(axis.gap(Ap::TargetPosition), target, "{motor}, {counts}");
            }
        }
    }
}

/// At defaults, from a single step to many turns, and with a weight that pulls either way.
#[test]
fn moves_land_at_defaults() {
    // At the default gain more would keep it farther from the target at rest than AP 134.
    for load_nm in [0.0, 0.05, -0.05] {
        let mut axis = Axis::new(&[(Ap::MaxVelocity, 6 * TURN), (Ap::MaxAcceleration, 20 * TURN)]);
        axis.set("load.torque_nm", load_nm);
        let start = axis.gap(Ap::ActualPosition);
        for distance in [200, 1000, -3000, 40_000, -400_000, 77] {
            axis.land(start + distance);
        }
    }
}

/// The ramp's time is kept, and its speed.
#[test]
fn an_unloaded_move_takes_the_time_of_the_ramp() {
    let mut axis = Axis::new(&[UNREGULATED, (Ap::PositionReachedTime, 0)]);
    let ticks = axis.land(80_000);
    // Two turns at 2 turns/s and 10 turns/s²: 1 s of travel and 0.2 s for the ramp.
    let seconds = ticks as f64 / 20_000.0;
    assert!((1.15..1.3).contains(&seconds), "{seconds} s for a move of 1.2 s");
    axis.go(0);
    axis.run_ms(600);
    let rpm = axis.mean(2000, |axis| axis.physical().velocity_rpm);
    assert!((rpm + 120.0).abs() < 2.4, "{rpm} rpm in mid-move, AP 4 is 120 rpm");
}

/// AP 8 is set when the shaft has been within AP 134 of the target for AP 135, not before and not much later.
#[test]
fn reached_means_inside_the_window_for_the_time() {
    for (window, tenths) in [(50, 100), (50, 0), (50, 5000), (10, 2000), (200, 2000), (30, 10_000)] {
        let what = format!("AP 134 = {window}, AP 135 = {tenths}");
        let mut axis =
            Axis::new(&[UNREGULATED, (Ap::PositionReachedWindow, window), (Ap::PositionReachedTime, tenths)]);
        let target = 20_000;
        axis.go(target);
        let [mut outside_narrow, mut outside_wide] = [0; 2];
        let mut tick = 0;
        while axis.gap(Ap::PositionReached) == 0 {
            assert!(tick < 60_000, "{what}: never set; {}", axis.figures());
            let off = (axis.shaft() - f64::from(target)).abs();
            let window = f64::from(window);
            if off > window - 2.5 {
                outside_narrow = tick;
            }
            if off > window + 2.5 {
                outside_wide = tick;
            }
            axis.run_ticks(1);
            tick += 1;
        }
        let time = 2 * tenths;
        assert!(
            tick - outside_wide >= time - 4,
            "{what}: set {} ticks after it was outside",
            tick - outside_wide
        );
        // It may count from the end of the ramp: from the edge of the widest of these windows that takes 40 ms.
        let latest = time + 860;
        assert!(tick - outside_narrow <= latest, "{what}: set only {} ticks after", tick - outside_narrow);
        axis.assert_at(target);
    }
}

#[test]
fn reached_is_not_set_short_of_the_target() {
    let mut axis = Axis::new(&[]);
    axis.go(40_000);
    assert_eq!(axis.gap(Ap::PositionReached), 0, "a motion command clears it before its reply");
    assert!(!axis.status_bit(bit::REACHED) && !axis.status_bit(bit::HOLD), "bits 0 and 12 of AP 18");
    axis.run_ms(300);
    axis.set("load.friction_nm", JAM_NM);
    for _ in 0..200 {
        axis.run_ms(10);
        let figures = axis.figures();
        assert_eq!(axis.gap(Ap::PositionReached), 0, "it is jammed; {figures}");
    }
    axis.set("load.friction_nm", 0.01);
    axis.reach();
    axis.assert_at(40_000);
    assert!(axis.status_bit(bit::REACHED) && axis.status_bit(bit::HOLD), "bits 0 and 12 of AP 18");
}

#[test]
fn the_readings_fit_each_other_and_the_shaft() {
    for counts in [4000, 40_000] {
        let settings = [UNREGULATED, (Ap::PositionReachedWindow, counts / 200)];
        let mut axis = Axis::on(&bench(MOTOR, counts, ""), counts, &settings);
        axis.set("load.friction_nm", 0.1);
        let microsteps = f64::from(TURN) / f64::from(counts);
        let target = 2 * counts;
        axis.go(target);
        let mut largest = 0.0_f64;
        for _ in 0..3000 {
            axis.run_ticks(9);
            axis.assert_agrees();
            let [position, virtual_position, error] =
                [Ap::ActualPosition, Ap::VirtualPosition, Ap::PositionError]
                    .map(|parameter| f64::from(axis.gap(parameter)));
            let expected = virtual_position / microsteps - position;
            assert!(
                (error - expected).abs() <= 1.5,
                "{counts}: AP 237 = {error}; AP 233 = {virtual_position} and AP 1 = {position} make {expected}"
            );
            largest = largest.max((virtual_position / microsteps - axis.shaft()).abs() * microsteps);
        }
        // The field is at most a full step ahead of the rotor, and the load far below what stalls.
        assert!((5.0..256.0).contains(&largest), "{counts}: AP 233 was {largest} µsteps from the shaft");
        assert_eq!(axis.gap(Ap::TargetPosition), target);
        axis.assert_at(target);
    }
}

#[test]
fn writing_the_position_moves_nothing() {
    for (parameter, value) in [
        (Ap::ActualPosition, 123_456),
        (Ap::EncoderCounter, -999_999),
        (Ap::ActualPosition, 0),
        (Ap::EncoderCounter, 7),
    ] {
        let mut axis = Axis::new(&[]);
        axis.land(12_345);
        let shaft = axis.turns();
        let before = [Ap::ActualPosition, Ap::TargetPosition, Ap::VirtualPosition].map(|p| axis.gap(p));
        axis.sap(parameter, value);
        let after = [Ap::ActualPosition, Ap::TargetPosition, Ap::VirtualPosition].map(|p| axis.gap(p));
        let shift = value - before[0];
        assert_eq!(after[0], value, "{parameter:?}: AP 1");
        assert_eq!(axis.gap(Ap::EncoderCounter), value, "{parameter:?}: AP 209");
        assert_eq!(after[1] - before[1], shift, "{parameter:?}: AP 0 shifts with AP 1");
        let virtual_shift = f64::from(after[2] - before[2]) - f64::from(shift) * 1.28;
        assert!(virtual_shift.abs() <= 2.0, "{parameter:?}: AP 233 is {virtual_shift} µsteps off");
        axis.run_ms(300);
        let moved = (axis.turns() - shaft) * 40_000.0;
        assert!(moved.abs() < 3.0, "SAP {parameter:?}, {value} moved the shaft by {moved} encoder steps");
        assert_eq!(axis.gap(Ap::PositionReached), 1, "{parameter:?}: AP 8");
        axis.zero_turns -= f64::from(shift) / 40_000.0;
        axis.assert_agrees();
        axis.land(value + 10_000);
    }
}

/// In mid-move too: the target shifts along.
#[test]
fn writing_the_position_in_mid_move_does_not_disturb_it() {
    for parameter in [Ap::ActualPosition, Ap::EncoderCounter] {
        let mut axis = Axis::new(&[UNREGULATED]);
        axis.go(60_000);
        for _ in 0..5 {
            axis.run_ms(133);
            let before = axis.gap(Ap::ActualPosition);
            axis.sap(parameter, -5000);
            axis.zero_turns -= f64::from(-5000 - before) / 40_000.0;
            let rpm = axis.mean(100, |axis| axis.physical().velocity_rpm);
            assert!(rpm > 30.0, "{parameter:?}: it stops, at {rpm} rpm");
            axis.assert_agrees();
        }
        axis.reach();
        let target = axis.gap(Ap::TargetPosition);
        axis.assert_at(target);
        let turned = axis.turns() * 40_000.0;
        assert!((turned - 60_000.0).abs() <= 55.0, "{parameter:?}: {turned} encoder steps instead of 60000");
    }
}

/// MVP REL counts from the last target, the ramp generator or the encoder, which a load sets apart.
#[test]
fn relative_moves_count_from_where_ap_127_says() {
    for option in [0, 1, 2] {
        let mut axis = Axis::new(&[UNREGULATED, (Ap::RelativePositioningOption, option)]);
        axis.set("load.friction_nm", 0.3);
        axis.go(60_000);
        axis.run_ms(700);
        let [target, position, virtual_position] =
            [Ap::TargetPosition, Ap::ActualPosition, Ap::VirtualPosition]
                .map(|parameter| axis.gap(parameter));
        let ramp = f64::from(virtual_position) / 1.28;
        assert!(ramp - f64::from(position) > 10.0, "the load is to set them apart; {}", axis.figures());
        axis.ok(Command::MoveToPosition, 1, 0, 10_000);
        let base = match option {
            0 => f64::from(target),
            1 => ramp,
            _ => f64::from(position),
        };
        let new = axis.gap(Ap::TargetPosition);
        assert!(
            (f64::from(new) - base - 10_000.0).abs() <= 1.5,
            "AP 127 = {option}: the target is {new}, not {base} + 10000"
        );
        axis.set("load.friction_nm", 0.01);
        axis.reach();
        axis.assert_at(new);
    }
}

/// At rest all three are as good as the same, and relative moves do not drift.
#[test]
fn relative_moves_from_rest_land() {
    for option in [0, 1, 2] {
        let mut axis = Axis::new(&[(Ap::RelativePositioningOption, option)]);
        for count in 1..=5 {
            axis.ok(Command::MoveToPosition, 1, 0, 4000);
            axis.reach();
            let off = axis.shaft() - f64::from(count * 4000);
            // Only the encoder's position takes what each landing was off.
            let allowed = if option == 2 { f64::from(count) * 52.0 } else { 52.0 };
            assert!(off.abs() <= allowed, "AP 127 = {option}, move {count}: {off} encoder steps off");
        }
    }
}

/// Three turns at a turn a second with so much friction between 2.3 and 2.6 s of 3.25 s. Returns the axis or module and how many ticks
/// the move took.
fn through_a_jam(settings: &[(Ap, i32)], jam_nm: f64) -> (Axis, u64) {
    let mut axis = Axis::new(&[UNREGULATED, (Ap::MaxVelocity, TURN), (Ap::MaxAcceleration, 4 * TURN)]);
    axis.set_all(settings);
    axis.go(120_000);
    axis.run_ms(2300);
    axis.set("load.friction_nm", jam_nm);
    axis.run_ms(300);
    axis.set("load.friction_nm", 0.01);
    let ticks = axis.reach() + 2600 * TICKS_PER_MS;
    axis.assert_at(120_000);
    (axis, ticks)
}

#[test]
fn open_loop_loses_the_steps_that_closed_loop_does_not() {
    let mut open = Module::new();
    open.sap(Ap::MaxVelocity, TURN);
    open.sap(Ap::MaxAcceleration, 4 * TURN);
    open.run_ms(100);
    move_to(&mut open, 3 * TURN);
    open.run_ms(1000);
    open.set("load.friction_nm", JAM_NM);
    open.run_ms(300);
    open.set("load.friction_nm", 0.01);
    finish(&mut open);
    open.run_ms(500);
    let lost = (3.0 - open.turns()) * 200.0;
    assert!(lost > 3.5, "open loop is meant to lose steps, and lost {lost}");
    // The same in closed loop lands, which `through_a_jam` checks.
    let (mut axis, _) = through_a_jam(&[], f64::from(JAM_NM));
    axis.run_ms(300);
    axis.assert_at(120_000);
}

#[test]
fn the_time_an_overload_costs_shrinks_with_the_correction_velocity() {
    let free = through_a_jam(&[], 0.01).1;
    let cost_ms = |correction: i32| {
        let (_, ticks) = through_a_jam(&[(Ap::MaxCorrectionVelocity, correction)], f64::from(JAM_NM));
        (ticks as f64 - free as f64) / TICKS_PER_MS as f64
    };
    let costs = [0, TURN / 2, TURN, TURN * 9 / 8, TURN * 5 / 4, 4 * TURN].map(cost_ms);
    let [none, half, equal, eighth, quarter, much] = costs;
    // The shaft need not slow down with the ramp while it is behind, which saves it up to 125 ms.
    for (name, cost) in [("0", none), ("AP 4 / 2", half), ("AP 4", equal)] {
        assert!(
            (150.0..400.0).contains(&cost),
            "AP 126 = {name}: a jam of 300 ms cost {cost} ms; all: {costs:?}"
        );
    }
    assert!(eighth < equal - 20.0, "AP 126 = 9/8 AP 4 saves nothing: {costs:?} ms");
    assert!(quarter < eighth - 20.0, "AP 126 = 5/4 AP 4 saves no more: {costs:?} ms");
    assert!(much < 10.0, "AP 126 = 4 AP 4 should be in time: {costs:?} ms");
}

/// While it catches up, the shaft turns no faster than AP 126 allows.
#[test]
fn it_catches_up_at_the_correction_velocity() {
    for factor in [2, 3] {
        let correction = factor * TURN;
        let settings = [
            UNREGULATED,
            (Ap::MaxVelocity, TURN),
            (Ap::MaxAcceleration, 4 * TURN),
            (Ap::MaxCorrectionVelocity, correction),
        ];
        let mut axis = Axis::new(&settings);
        axis.go(200_000);
        axis.run_ms(1000);
        axis.set("load.friction_nm", JAM_NM);
        axis.run_ms(500);
        axis.set("load.friction_nm", 0.01);
        // Coming free the rotor swings.
        axis.run_ms(100);
        let mut fastest = 0.0_f64;
        for _ in 0..300 {
            fastest = fastest.max(axis.mean(200, |axis| axis.physical().velocity_rpm));
        }
        let limit = 60.0 * f64::from(factor);
        assert!(
            (0.9 * limit..1.15 * limit).contains(&fastest),
            "AP 126 is {limit} rpm, AP 4 60 rpm: catching up it turned at {fastest:.1} rpm at most"
        );
        axis.reach();
        axis.assert_at(200_000);
    }
}

/// Driven backwards against all its torque, the motor comes back; at defaults too, where the current is regulated.
#[test]
fn being_overpowered_loses_nothing() {
    // At defaults the current takes its time to rise (AP 120), and the push goes farther.
    let cases: [(&[(Ap, i32)], u64); 3] =
        [(&[UNREGULATED], 40), (&[(Ap::MaxCorrectionVelocity, 6 * TURN), UNREGULATED], 40), (&[], 15)];
    for (settings, push_ms) in cases {
        for load_nm in [-0.9, 0.9_f64] {
            let file = bench(MOTOR, 40_000, "inertia_kgm2 = 1e-4");
            let mut axis = Axis::on(&file, 40_000, settings);
            axis.go(100_000);
            axis.run_ms(600);
            let before = axis.turns();
            axis.set("load.torque_nm", load_nm);
            axis.run_ms(push_ms);
            axis.set("load.torque_nm", 0);
            let pushed = (axis.turns() - before - 0.002 * push_ms as f64) * load_nm.signum();
            assert!(pushed > 0.02, "{load_nm} Nm are meant to be too much, and pushed it by {pushed} turns");
            axis.reach();
            axis.assert_at(100_000);
            axis.run_ms(300);
            axis.assert_at(100_000);
        }
    }
}

/// AP 125: a lag that is smaller is left alone while the ramp runs.
#[test]
fn small_lags_are_left_alone() {
    let lag_after = |allowed: i32| {
        let mut axis = Axis::new(&[
            UNREGULATED,
            (Ap::MaxVelocity, TURN),
            (Ap::MaxAcceleration, 4 * TURN),
            (Ap::MaxCorrectionVelocity, 4 * TURN),
            (Ap::MaxFollowingError, allowed),
        ]);
        axis.go(120_000);
        axis.run_ms(1000);
        axis.set("load.friction_nm", JAM_NM);
        axis.run_ms(60);
        axis.set("load.friction_nm", 0.01);
        axis.run_ms(500);
        let lag = f64::from(axis.gap(Ap::VirtualPosition)) - axis.shaft() * 1.28;
        axis.reach();
        axis.assert_at(120_000);
        lag
    };
    // 60 ms at a turn a second are 3072 µsteps.
    let [tolerated, half, corrected] = [6000, 1500, 0].map(lag_after);
    assert!(
        (2600.0..3400.0).contains(&tolerated),
        "AP 125 = 6000: a lag of 3072 µsteps became {tolerated:.0}"
    );
    assert!((1200.0..1900.0).contains(&half), "AP 125 = 1500: a lag of 3072 µsteps became {half:.0}");
    assert!(corrected.abs() < 200.0, "AP 125 = 0: a lag of 3072 µsteps became {corrected:.0}");
}

/// AP 124: the higher, the quicker.
#[test]
fn the_proportional_factor_makes_it_quick() {
    let lag_after = |factor: i32| {
        let mut axis = Axis::new(&[
            UNREGULATED,
            (Ap::MaxVelocity, TURN),
            (Ap::MaxAcceleration, 4 * TURN),
            (Ap::MaxCorrectionVelocity, 4 * TURN),
            (Ap::CorrectionVelocityP, factor),
        ]);
        axis.go(120_000);
        axis.run_ms(1000);
        axis.set("load.friction_nm", JAM_NM);
        axis.run_ms(60);
        axis.set("load.friction_nm", 0.01);
        axis.run_ms(60);
        f64::from(axis.gap(Ap::VirtualPosition)) - axis.shaft() * 1.28
    };
    let [slow, quick, quickest] = [1000, 4000, 30_000].map(lag_after);
    assert!(
        slow > quick + 200.0 && quick > quickest + 200.0 && quickest < 300.0,
        "60 ms after a lag of 3072 µsteps, with AP 124 = 1000, 4000, 30000, it is {slow:.0}, {quick:.0}, {quickest:.0}"
    );
}

/// A jam at 120 rpm, until the deviation stops it. Returns the lag in µsteps when AP 207 was set.
#[track_caller]
fn jam_until_deviation(axis: &mut Axis, limit: i32) -> f64 {
    axis.sap(Ap::MaxEncoderDeviation, limit);
    axis.go(200_000);
    axis.run_ms(700);
    assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0, "AP 207 without a jam");
    axis.set("load.friction_nm", JAM_NM);
    let start = axis.shaft();
    for tick in 0..20_000_u32 {
        if axis.gap(Ap::EncoderDeviationFlag) == 1 {
            // The ramp's speed is known, the shaft stands.
            return f64::from(tick) * 2.0 * f64::from(TURN) / 20_000.0 - (axis.shaft() - start) * 1.28;
        }
        axis.run_ticks(1);
    }
    let figures = axis.figures();
    panic!("AP 207 is not set, AP 212 = {limit}; {figures}")
}

#[test]
fn a_deviation_stops_the_motor() {
    for (limit, off) in [(3000, false), (-3000, true)] {
        let mut axis = Axis::new(&[UNREGULATED]);
        let lag = jam_until_deviation(&mut axis, limit);
        // The rotor was some µsteps behind before.
        assert!((2800.0..3100.0).contains(&lag), "AP 212 = {limit}: stopped at {lag:.0} µsteps");
        assert_eq!(axis.gap(Ap::ActualVelocity), 0, "AP 3");
        axis.run_ms(20);
        let flows = amplitude_a(&axis);
        if off {
            assert!(flows < 0.02, "AP 212 = {limit}: {flows} A flow");
            axis.set("load.friction_nm", 0.001);
            axis.set("load.torque_nm", 0.1);
            let at = axis.turns();
            axis.run_ms(200);
            assert!(axis.turns() - at > 0.2, "it can be turned freely");
            axis.set("load.torque_nm", 0);
            axis.set("load.friction_nm", 0.05);
            axis.run_ms(1500);
        } else {
            assert!(flows > 1.0, "AP 212 = {limit}: only {flows} A flow");
        }
        axis.set("load.friction_nm", 0.01);
        let at = axis.turns();
        axis.run_ms(1000);
        let moved = axis.turns() - at;
        assert!(moved.abs() < 0.1, "AP 212 = {limit}: stopped, and moves on by {moved} turns");
        assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 1, "until the next motion command");
        axis.assert_agrees();
        axis.go(10_000);
        assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0, "a motion command clears AP 207");
        axis.reach();
        axis.assert_at(10_000);
        assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0, "driven as usual");
    }
}

#[test]
fn a_deviation_raises_interrupt_21_once() {
    let mut axis = Axis::new(&[UNREGULATED]);
    axis.module = listening(axis.module, &[21], &[]);
    jam_until_deviation(&mut axis, 2000);
    axis.run_ms(50);
    assert_eq!(axis.variable(0), 1, "interrupt 21 counts in variable 0");
    axis.set("load.friction_nm", 0.01);
    axis.run_ms(500);
    assert_eq!(axis.variable(0), 1, "once");
}

#[test]
fn without_a_limit_there_is_no_deviation() {
    let mut axis = Axis::new(&[UNREGULATED]);
    axis.go(120_000);
    axis.run_ms(500);
    axis.set("load.friction_nm", JAM_NM);
    axis.run_ms(1000);
    assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0);
    axis.set("load.friction_nm", 0.01);
    axis.reach();
    axis.assert_at(120_000);
}

#[test]
fn the_ramp_can_be_changed_on_the_fly() {
    let mut axis = Axis::new(&[UNREGULATED]);
    axis.go(400_000);
    for (velocity, rpm) in [(2 * TURN, 120.0), (TURN / 2, 30.0), (3 * TURN, 180.0)] {
        axis.sap(Ap::MaxVelocity, velocity);
        axis.run_ms(600);
        let turns = axis.mean(6000, |axis| axis.physical().velocity_rpm);
        assert!((turns / rpm - 1.0).abs() < 0.03, "AP 4 = {velocity}: {turns} rpm, not {rpm}");
    }
    axis.sap(Ap::MaxAcceleration, 20 * TURN);
    let turned_round = axis.gap(Ap::ActualPosition);
    axis.go(turned_round - 50_000);
    axis.reach();
    axis.assert_at(turned_round - 50_000);
    // A deceleration that becomes gentler on the way may overrun the target, and comes back.
    axis.go(turned_round);
    axis.run_ms(300);
    axis.sap(Ap::MaxAcceleration, 8 * TURN);
    axis.reach();
    axis.assert_at(turned_round);
}

#[test]
fn a_stop_switch_stops_it() {
    for soft in [0, 1] {
        let file = format!("{}[module.switches]\nright = {{ at_turns = 0.5 }}\n", bench(MOTOR, 40_000, ""));
        let mut axis = Axis::on(
            &file,
            40_000,
            &[UNREGULATED, (Ap::MaxVelocity, TURN), (Ap::MaxAcceleration, 4 * TURN), (Ap::SoftStop, soft)],
        );
        axis.go(80_000);
        let (_, furthest) = axis.range(40_000, |axis| axis.turns());
        let standing = axis.turns();
        // At 4 turns/s² from a turn a second it takes an eighth of a turn.
        let (low, high) = if soft == 1 { (0.61, 0.64) } else { (0.498, 0.515) };
        assert!(
            (low..high).contains(&standing) && furthest < high + 0.01,
            "AP 149 = {soft}: the switch at 0.5 turns stops it at {standing}, after {furthest}; {}",
            axis.figures()
        );
        assert_eq!((axis.gap(Ap::RightLimitSwitch), axis.gap(Ap::PositionReached)), (1, 0), "AP 10 and 8");
        assert_eq!(axis.gap(Ap::TargetPosition), 80_000, "the target stays");
        axis.assert_agrees();
        axis.land(0);
    }
}

/// The zero is at the edge, and the encoder's counter counts from it.
#[test]
fn a_reference_search_sets_the_counter_to_zero_at_the_edge() {
    // The mode, its zero, and the distance of the right switch where it finds that.
    for (mode, edge, distance) in [
        (1, -0.5, None),
        (2, -0.5, Some(1.0)),
        (3, -0.525, Some(1.025)),
        (4, -0.525, None),
        (5, 0.125, None),
        (7, 0.125, None),
    ] {
        let switches = "[module.switches]\nleft = { at_turns = -0.525, width_turns = 0.05 }\n\
                        right = { at_turns = 0.5 }\nhome = { at_turns = 0.125, width_turns = 0.05 }\n";
        let file = format!("{}{switches}", bench(MOTOR, 40_000, ""));
        let settings = [
            UNREGULATED,
            (Ap::MaxVelocity, TURN),
            (Ap::MaxAcceleration, 10 * TURN),
            (Ap::ReferenceSearchMode, mode),
        ];
        let mut axis = Axis::on(&file, 40_000, &settings);
        axis.ok(Command::ReferenceSearch, 0, 0, 0);
        let mut ms = 0;
        while axis.ok(Command::ReferenceSearch, 2, 0, 0) != 0 {
            let figures = axis.figures();
            assert!(ms < 30_000, "mode {mode} never ends; {} turns; {figures}", axis.turns());
            axis.run_ms(1);
            ms += 1;
        }
        axis.run_ms(300);
        assert_eq!(axis.gap(Ap::TargetPosition), 0, "mode {mode}: AP 0");
        let readings = [Ap::ActualPosition, Ap::EncoderCounter].map(|parameter| axis.gap(parameter));
        assert_eq!(readings[0], readings[1], "mode {mode}: AP 1 is AP 209");
        assert!(readings[0].abs() <= 50, "mode {mode}: it stands on its zero, AP 1 = {}", readings[0]);
        let zero = axis.turns() - f64::from(readings[0]) / 40_000.0;
        let off = (zero - edge) * 40_000.0;
        assert!(
            off.abs() <= 8.0,
            "mode {mode}: AP 209 is 0 at {zero} turns, {off:.1} encoder steps from {edge}"
        );
        if let Some(distance) = distance {
            let measured = f64::from(axis.gap(Ap::EndSwitchDistance)) / 40_000.0;
            assert!(
                (measured - distance).abs() < 10.0 / 40_000.0,
                "mode {mode}: AP 196 is {measured} turns, not {distance}"
            );
        }
        axis.zero_turns = zero;
        let target = axis.steps(0.2 - edge.signum() * 0.1);
        axis.sap(Ap::RightLimitSwitchDisable, 1);
        axis.land(target);
    }
}
