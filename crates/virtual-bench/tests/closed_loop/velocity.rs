//! Closed-loop velocity mode and field weakening: AP 3, 16, 17, 108, 109, 131, 230 (TMCM-1311 §8.6, §8.9; decision 5.13),
//! judged by how fast the shaft turns.

use crate::common::TURN;
use crate::common::closed_loop::{Axis, MOTOR, MOTORS, bench, bit, full_torque_nm, rms_a};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

/// No field weakening: its corner velocities are out of reach.
const WITHOUT: [(Ap, i32); 2] =
    [(Ap::FieldWeakeningMinVelocity, 327_679_998), (Ap::FieldWeakeningMaxVelocity, 327_679_999)];

const UNREGULATED: (Ap, i32) = (Ap::CurrentScaleEnable, 0);

/// How fast the shaft really turns, in µsteps per second.
fn true_pps(axis: &Axis) -> f64 {
    axis.physical().velocity_rpm / 60.0 * f64::from(TURN)
}

/// The mean velocity by what the shaft turned in so many ms, in µsteps per second.
fn mean_pps(axis: &mut Axis, ms: u64) -> f64 {
    let before = axis.turns();
    axis.run_ms(ms);
    (axis.turns() - before) * f64::from(TURN) / (ms as f64 / 1000.0)
}

fn turning(file: &str, counts: i32, velocity_pps: i32, settings: &[(Ap, i32)]) -> Axis {
    let mut axis = Axis::on(file, counts, &[(Ap::MaxVelocity, 200 * TURN)]);
    axis.set_all(settings);
    axis.rotate(velocity_pps);
    axis.run_ms(velocity_pps.unsigned_abs() as u64 * 100 / u64::from(TURN.unsigned_abs()) + 1500);
    axis
}

#[test]
fn the_shaft_turns_as_fast_as_it_is_told() {
    for (motor, max_current) in MOTORS {
        for velocity in [TURN / 10, TURN, -3 * TURN, 5 * TURN] {
            for counts in [4000, 40_000] {
                let what = format!("{motor}, {counts} counts, {velocity} pps");
                let settings = [(Ap::MaxCurrent, max_current)];
                let mut axis = turning(&bench(motor, counts, ""), counts, velocity, &settings);
                let truth = mean_pps(&mut axis, 1000);
                let off = truth / f64::from(velocity) - 1.0;
                assert!(off.abs() < 0.005, "{what}: the shaft turns at {truth:.0} pps; {}", axis.figures());
                assert_eq!(axis.gap(Ap::ActualVelocity), velocity, "{what}: AP 3 is the ramp's");
                assert_eq!(axis.gap(Ap::TargetVelocity), velocity, "{what}: AP 2");
                let bits = [bit::POSITION, bit::VELOCITY, bit::TORQUE].map(|bit| axis.status_bit(bit));
                assert_eq!(bits, [false, true, false], "{what}: bits 3 to 5 of AP 18");
                axis.assert_agrees();
            }
        }
    }
}

#[test]
fn the_measured_velocity_is_the_true_one() {
    for counts in [4000, 40_000] {
        for velocity in [TURN / 2, -TURN, 4 * TURN, -10 * TURN] {
            let mut axis = turning(&bench(MOTOR, counts, ""), counts, velocity, &[UNREGULATED]);
            let (mut truth, mut measured) = (0.0, 0.0);
            for _ in 0..4000 {
                axis.run_ticks(1);
                truth += true_pps(&axis) / 4000.0;
                measured += f64::from(axis.gap(Ap::MeasuredVelocity)) / 4000.0;
            }
            let off = measured / truth - 1.0;
            // Where the detent torque makes the speed swing, too.
            assert!(
                off.abs() < 0.01,
                "{counts} counts, {velocity} pps: AP 131 is {measured:.0} on average, the truth {truth:.0}"
            );
        }
    }
}

/// Single readings too, and in motion that speeds up.
#[test]
fn single_readings_of_the_measured_velocity_are_close() {
    let mut axis = turning(&bench(MOTOR, 40_000, ""), 40_000, 3 * TURN, &[UNREGULATED]);
    let mut worst = 0.0_f64;
    axis.sap(Ap::MaxAcceleration, 4 * TURN);
    axis.rotate(6 * TURN);
    for _ in 0..1200 {
        axis.run_ms(1);
        let measured = f64::from(axis.gap(Ap::MeasuredVelocity));
        worst = worst.max((measured / true_pps(&axis) - 1.0).abs());
    }
    assert!(worst < 0.04, "a reading of AP 131 is off by {:.1} %", worst * 100.0);
}

#[test]
fn at_rest_the_measured_velocity_is_zero() {
    let mut axis = Axis::new(&[]);
    axis.land(4000);
    axis.run_ms(500);
    assert_eq!(axis.physical().velocity_rpm, 0.0, "it is to stand");
    assert_eq!(axis.gap(Ap::MeasuredVelocity), 0, "AP 131 at rest");
    assert_eq!(axis.gap(Ap::ActualVelocity), 0, "AP 3 at rest");
}

/// AP 16 and bit 1 of AP 18 say whether AP 131 is within AP 17 of AP 2, at every instant.
#[test]
fn velocity_reached_is_about_the_measured_velocity() {
    for window in [1000, 5000, 20_000] {
        let mut axis =
            Axis::new(&[UNREGULATED, (Ap::MaxVelocity, 20 * TURN), (Ap::VelocityReachedWindow, window)]);
        let target = 4 * TURN;
        axis.rotate(target);
        let mut first = None;
        for tick in 0..14_000_u32 {
            axis.run_ticks(1);
            let off = (axis.gap(Ap::MeasuredVelocity) - target).abs();
            let reached = axis.gap(Ap::VelocityReached);
            assert_eq!(
                reached,
                i32::from(off <= window),
                "AP 17 = {window}: AP 16, and AP 131 is {off} pps off"
            );
            assert_eq!(axis.status_bit(bit::VELOCITY_REACHED), reached == 1, "bit 1 of AP 18");
            if first.is_none() && reached == 1 {
                first = Some(tick);
                let off = (true_pps(&axis) - f64::from(target)).abs();
                assert!(
                    off <= f64::from(window) + 0.05 * f64::from(target),
                    "AP 17 = {window}: reached, and the shaft is {off:.0} pps off"
                );
            }
        }
        // 4 turns/s at 10 turns/s² take 0.4 s.
        let first = f64::from(first.expect("AP 16 is never set")) / 20_000.0;
        let expected = 0.4 - f64::from(window) / f64::from(10 * TURN);
        assert!(
            (first - expected).abs() < 0.05,
            "AP 17 = {window}: set after {first} s, expected {expected}"
        );
    }
}

/// Once it turns steadily, AP 16 stays set, with a window that is wider than the detent torque makes it swing.
#[test]
fn velocity_reached_stays() {
    for velocity in [4 * TURN, -4 * TURN] {
        let settings = [UNREGULATED, (Ap::VelocityReachedWindow, TURN / 5)];
        let mut axis = turning(&bench(MOTOR, 40_000, ""), 40_000, velocity, &settings);
        let share = axis.mean(4000, |axis| f64::from(axis.gap(Ap::VelocityReached)));
        let (low, high) = axis.range(4000, |axis| true_pps(axis));
        assert!(
            share > 0.99,
            "{velocity} pps: AP 16 is set {share} of the time; truth {low:.0} to {high:.0} pps"
        );
    }
}

#[test]
fn a_jam_clears_velocity_reached() {
    let mut axis = turning(&bench(MOTOR, 40_000, ""), 40_000, 2 * TURN, &[UNREGULATED]);
    axis.set("load.friction_nm", 5);
    axis.run_ms(100);
    // Not faster than an encoder step in the time that none came.
    let measured = axis.gap(Ap::MeasuredVelocity);
    assert!((0..=50).contains(&measured), "AP 131 of a shaft that is jammed for 100 ms: {measured} pps");
    assert_eq!(axis.gap(Ap::VelocityReached), 0, "AP 16 of a jammed shaft");
    axis.set("load.friction_nm", 0.01);
    axis.run_ms(500);
    let truth = mean_pps(&mut axis, 500);
    assert!((truth / f64::from(2 * TURN) - 1.0).abs() < 0.01, "free again it turns at {truth:.0} pps");
}

/// What an overload cost is lost: at most 768 µsteps of it are made up.
#[test]
fn an_overload_is_not_made_up_later() {
    for velocity in [2 * TURN, -2 * TURN] {
        let mut axis = turning(&bench(MOTOR, 40_000, ""), 40_000, velocity, &[UNREGULATED]);
        axis.set("load.friction_nm", 5);
        axis.run_ms(500);
        let jammed = axis.turns();
        axis.set("load.friction_nm", 0.01);
        axis.run_ms(1000);
        let gained =
            ((axis.turns() - jammed) * f64::from(TURN) - f64::from(velocity)) * f64::from(velocity.signum());
        // To come up to speed costs less than a full step.
        assert!(
            (-300.0..768.0 + 300.0).contains(&gained),
            "{velocity} pps: after a jam that cost 51200 µsteps it turned {gained:.0} more than it should"
        );
        axis.assert_agrees();
    }
}

#[test]
fn mst_and_a_new_velocity_follow_the_ramp() {
    let mut axis = turning(&bench(MOTOR, 40_000, ""), 40_000, 4 * TURN, &[UNREGULATED]);
    axis.ok(Command::MotorStop, 0, 0, 0);
    axis.run_ms(200);
    // 10 turns/s².
    let truth = true_pps(&axis) / f64::from(TURN);
    assert!((truth - 2.0).abs() < 0.15, "200 ms after MST it turns at {truth:.3} turns/s, not 2");
    axis.run_ms(1000);
    let (low, high) = axis.range(2000, |axis| true_pps(axis));
    assert!(low > -1500.0 && high < 1500.0, "stopped, it turns at {low:.0} to {high:.0} pps");
    axis.rotate(-3 * TURN);
    axis.run_ms(140);
    let truth = mean_pps(&mut axis, 20) / f64::from(TURN);
    assert!((truth + 1.5).abs() < 0.15, "150 ms later it turns at {truth:.3} turns/s, not -1.5");
}

/// At rest in velocity mode a push is resisted, and not answered by turning on.
#[test]
fn velocity_zero_resists_a_push() {
    let mut axis = turning(&bench(MOTOR, 40_000, ""), 40_000, TURN, &[UNREGULATED]);
    axis.ok(Command::MotorStop, 0, 0, 0);
    axis.run_ms(1000);
    let before = axis.turns();
    for percent in 1..=100 {
        axis.set("load.torque_nm", 0.003 * f64::from(percent));
        axis.run_ms(3);
    }
    axis.run_ms(500);
    let moved = axis.turns() - before;
    assert!(moved.abs() < 1.0 / 200.0, "0.3 Nm turned the standing shaft by {moved} turns");
}

/// The top speed against so much friction.
fn top_turns_per_s(friction_nm: f64, settings: &[(Ap, i32)]) -> f64 {
    let mut axis = Axis::new(&[UNREGULATED, (Ap::MaxCurrent, 231), (Ap::MaxVelocity, 100 * TURN)]);
    axis.set("load.friction_nm", friction_nm);
    axis.sap(Ap::MaxAcceleration, 20 * TURN);
    axis.set_all(settings);
    axis.rotate(60 * TURN);
    axis.run_ms(3200);
    let turns_per_s = mean_pps(&mut axis, 800) / f64::from(TURN);
    let torque_nm = axis.mean(4000, |axis| axis.physical().torque_nm);
    let viscous_nm = 4e-4 * std::f64::consts::TAU * turns_per_s;
    // The speed is steady: the motor has just the torque of the load.
    let surplus = torque_nm - friction_nm - viscous_nm;
    assert!(
        surplus.abs() < 0.03,
        "{friction_nm} Nm, {settings:?}: not steady at {turns_per_s} turns/s, {surplus} Nm left"
    );
    turns_per_s
}

#[test]
fn field_weakening_raises_the_top_speed() {
    for friction_nm in [0.15, 0.3] {
        let without = top_turns_per_s(friction_nm, &WITHOUT);
        let defaults = top_turns_per_s(friction_nm, &[]);
        assert!(
            defaults > 1.1 * without,
            "against {friction_nm} Nm: {defaults:.2} turns/s with field weakening, {without:.2} without"
        );
    }
}

/// AP 230: 0 up to AP 108, 255 from AP 109 on, a straight line between, by the velocity of the shaft.
#[test]
fn gamma_follows_the_measured_velocity() {
    let corners = [(Ap::FieldWeakeningMinVelocity, 4 * TURN), (Ap::FieldWeakeningMaxVelocity, 8 * TURN)];
    for (turns_per_s, gamma) in
        [(2.0, 0.0), (3.9, 0.0), (5.0, 63.75), (-6.0, 127.5), (7.0, 191.25), (8.1, 255.0), (-10.0, 255.0)]
    {
        let velocity = (turns_per_s * f64::from(TURN)) as i32;
        let mut axis =
            turning(&bench(MOTOR, 40_000, ""), 40_000, velocity, &[UNREGULATED, corners[0], corners[1]]);
        let mut truth = 0.0;
        let read = axis.mean(2000, |axis| {
            truth += true_pps(axis).abs() / f64::from(TURN) / 2000.0;
            f64::from(axis.gap(Ap::Gamma))
        });
        let expected = (255.0 * (truth - 4.0) / 4.0).clamp(0.0, 255.0);
        assert!((expected - gamma).abs() < 8.0, "{turns_per_s} turns/s are meant, and it turns at {truth}");
        assert!(
            (read - expected).abs() < 6.0,
            "at {truth:.3} turns/s AP 230 is {read:.1}, not {expected:.1}"
        );
    }
}

/// It acts in positioning too, beyond the corner velocities: a fast move is possible that is none without.
#[test]
fn a_fast_move_profits_from_field_weakening() {
    let time = |settings: &[(Ap, i32)]| {
        let mut axis = Axis::new(&[UNREGULATED, (Ap::MaxCurrent, 231), (Ap::MaxVelocity, 40 * TURN)]);
        axis.set("load.friction_nm", 0.15);
        axis.sap(Ap::MaxAcceleration, 60 * TURN);
        axis.set_all(settings);
        axis.go(40_000 * 60);
        let ticks = axis.reach();
        axis.assert_at(40_000 * 60);
        ticks as f64 / 20_000.0
    };
    let (with, without) = (time(&[]), time(&WITHOUT));
    assert!(with < without - 0.1, "60 turns take {with} s with field weakening and {without} s without");
}

/// The motor keeps its speed under a load of half its torque.
#[test]
fn a_load_does_not_slow_it() {
    let load_nm = 0.5 * full_torque_nm(MOTOR, rms_a(128));
    for sign in [1.0, -1.0] {
        let file = bench(MOTOR, 40_000, "");
        let mut axis = turning(&file, 40_000, 2 * TURN, &[UNREGULATED]);
        axis.set("load.torque_nm", sign * load_nm);
        axis.run_ms(1000);
        let truth = mean_pps(&mut axis, 500) / f64::from(TURN);
        assert!(
            (truth - 2.0).abs() < 0.02,
            "with {:.3} Nm it turns at {truth} turns/s, not 2",
            sign * load_nm
        );
        let (low, high) = axis.range(4000, |axis| true_pps(axis) / f64::from(TURN));
        assert!(
            low > 1.5 && high < 2.5,
            "with {:.3} Nm it swings from {low} to {high} turns/s",
            sign * load_nm
        );
    }
}

/// The ramp gives way to a jam after three full steps, which AP 212 does not.
#[test]
fn a_jam_is_a_deviation() {
    let mut axis = turning(&bench(MOTOR, 40_000, ""), 40_000, TURN, &[(Ap::MaxEncoderDeviation, 5000)]);
    axis.run_ms(1000);
    assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 0, "AP 207 while it turns");
    axis.set("load.friction_nm", 3.0);
    axis.run_ms(300);
    assert_eq!(axis.gap(Ap::EncoderDeviationFlag), 1, "AP 207 in a jam");
    assert_eq!(axis.gap(Ap::ActualVelocity), 0, "AP 3");
}

/// Three full steps are 15 counts here, for which AP 113 to 117 give less current than the load needs. It slows the motor, and
/// does not stop it.
#[test]
fn a_load_does_not_stop_it_with_a_coarse_encoder() {
    let mut axis = turning(&bench(MOTOR, 1000, ""), 1000, TURN, &[]);
    axis.set("load.friction_nm", 0.35);
    axis.run_ms(500);
    let start = axis.turns();
    axis.run_ms(2000);
    let turned = axis.turns() - start;
    assert!(turned > 1.0, "{turned} turns in 2 s");
}

/// The ramp of a move that begins above AP 4 has to brake first, and the motor goes with it.
#[test]
fn a_move_that_begins_above_its_speed_brakes_by_the_ramp() {
    let mut axis = turning(&bench(MOTOR, 40_000, ""), 40_000, 4 * TURN, &[]);
    axis.run_ms(1000);
    axis.sap(Ap::MaxVelocity, TURN);
    axis.go(1_000_000);
    axis.run_ms(10);
    for _ in 0..50 {
        axis.run_ms(10);
        let error = axis.gap(Ap::PositionError);
        assert!(error.abs() < 200, "{error} encoder steps behind the ramp");
    }
}
