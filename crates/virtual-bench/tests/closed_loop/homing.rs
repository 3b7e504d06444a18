//! Reference search in closed loop (TMCM-1311 §9; decisions 5.9): AP 1 and AP 209 are 0 at the physical edge or middle.
//!
//! What mode and speed allow: every switching point is sampled once a control period, at AP 195; a contact that bounces is a
//! coin toss until it is steady; and the encoder tells whole counts. See [`allowed`].

use crate::common::TURN;
use crate::common::closed_loop::{Axis, MOTOR, MOTORS, bench};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp};

/// The left stop switch is a cam with two edges, as modes 3 and 4 need it.
const LEFT: (f64, f64) = (-0.55, -0.5);
const RIGHT: f64 = 0.5;
const HOME: (f64, f64) = (0.1, 0.15);

const MODES: [i32; 12] = [1, 2, 3, 4, 5, 6, 7, 8, 133, 134, 135, 136];

const START: u8 = 0;
const STATUS: u8 = 2;

/// What is searched for, how, and from where.
#[derive(Clone, Copy, Debug)]
struct Case {
    motor: &'static str,
    max_current: i32,
    counts: i32,
    bounce_ms: f64,
    start: f64,
    /// AP 195.
    switch_pps: i32,
    settings: &'static [(Ap, i32)],
}

const USUAL: Case = Case {
    motor: MOTOR,
    max_current: 128,
    counts: 40_000,
    bounce_ms: 0.0,
    start: 0.0,
    switch_pps: TURN / 4,
    settings: &[],
};

/// How far a place that was measured may be from the truth, in turns. Two instants are averaged, so whatever delays both alike
/// cancels; each is up to a control period late, or with a bouncing contact up to eight more tosses of a coin. The encoder adds
/// a count where it was, one where the zero is written, and a µstep of rounding each.
fn allowed(case: &Case) -> f64 {
    let periods = if case.bounce_ms == 0.0 { 1.0 } else { 8.0 };
    let sampling = f64::from(case.switch_pps) * 50e-6 * periods / 2.0;
    (sampling + 2.0) / f64::from(TURN) + 2.0 / f64::from(case.counts)
}

fn file(case: &Case) -> String {
    let (left, home) = ((LEFT.0 + LEFT.1) / 2.0, (HOME.0 + HOME.1) / 2.0);
    let bounce_ms = case.bounce_ms;
    format!(
        "{}[module.switches]\n\
         left = {{ at_turns = {left}, width_turns = 0.05, bounce_ms = {bounce_ms:.1} }}\n\
         right = {{ at_turns = {RIGHT}, bounce_ms = {bounce_ms:.1} }}\n\
         home = {{ at_turns = {home}, width_turns = 0.05, bounce_ms = {bounce_ms:.1} }}\n",
        bench(case.motor, case.counts, "")
    )
}

/// In closed loop at the place to start from.
#[track_caller]
fn at(case: &Case) -> Axis {
    let settings = [
        (Ap::MaxCurrent, case.max_current),
        (Ap::LeftLimitSwitchDisable, 1),
        (Ap::RightLimitSwitchDisable, 1),
        (Ap::MaxVelocity, TURN),
        (Ap::ReferenceSwitchVelocity, case.switch_pps),
    ];
    let mut axis = Axis::on(&file(case), case.counts, &settings);
    axis.set_all(case.settings);
    axis.go(axis.steps(case.start - axis.zero_turns));
    axis.reach();
    axis
}

/// Where the zero is, and what AP 196 says, in turns.
fn truth(mode: i32) -> (f64, f64) {
    let left_middle = (LEFT.0 + LEFT.1) / 2.0;
    match mode & !128 {
        1 => (LEFT.1, 0.0),
        2 => (LEFT.1, RIGHT - LEFT.1),
        3 => (left_middle, RIGHT - left_middle),
        4 => (left_middle, 0.0),
        _ => ((HOME.0 + HOME.1) / 2.0, 0.0),
    }
}

/// Searches, and holds the zero to the truth.
#[track_caller]
fn search(axis: &mut Axis, mode: i32, case: &Case) {
    if mode > 128 {
        // A contact that opens everywhere but at the switch: what GP 79 makes of the other kind, without the stop switches.
        axis.sgp(Gp::EndSwitchPolarity, 1);
        axis.set("fault.switch_left", "open");
        axis.set("fault.switch_right", "open");
    }
    axis.sap(Ap::ReferenceSearchMode, mode);
    axis.ok(Command::ReferenceSearch, START, 0, 0);
    for ms in 0.. {
        if axis.ok(Command::ReferenceSearch, STATUS, 0, 0) == 0 {
            break;
        }
        let figures = axis.figures();
        assert!(ms < 60_000, "mode {mode}, {case:?} never ends; {} turns; {figures}", axis.turns());
        axis.run_ms(1);
    }
    axis.run_ms(500);
    let here = [Ap::TargetPosition, Ap::ActualVelocity, Ap::TargetVelocity, Ap::RampMode];
    assert_eq!(here.map(|parameter| axis.gap(parameter)), [0; 4], "mode {mode}, {case:?}");
    assert_eq!(axis.gap(Ap::PositionReached), 1, "mode {mode}, {case:?}; {}", axis.figures());
    let position = axis.gap(Ap::ActualPosition);
    assert_eq!(position, axis.gap(Ap::EncoderCounter), "AP 1 is AP 209");
    let window = axis.gap(Ap::PositionReachedWindow);
    assert!(position.abs() <= window, "it stands on its zero, AP 1 = {position}, not within {window}");
    let (zero, distance) = truth(mode);
    axis.zero_turns = axis.turns() - f64::from(position) / axis.counts;
    let off = axis.zero_turns - zero;
    assert!(
        off.abs() <= allowed(case),
        "mode {mode}, {case:?}: {:.2} µsteps off, allowed {:.2}",
        off * f64::from(TURN),
        allowed(case) * f64::from(TURN)
    );
    let measured = f64::from(axis.gap(Ap::EndSwitchDistance)) / axis.counts;
    assert!(
        (measured - distance).abs() <= 2.0 * allowed(case),
        "mode {mode}, {case:?}: AP 196 is {measured} turns, not {distance}"
    );
}

/// Modes 7 and 8 do not turn round, and there is no stop switch to turn round at with an inverted home switch.
fn is_behind(mode: i32, start: f64) -> bool {
    match mode {
        7 | 134 | 135 => start > HOME.1,
        8 | 133 | 136 => start < HOME.0,
        _ => false,
    }
}

#[track_caller]
fn all_modes(case: &Case) {
    for mode in MODES {
        if !is_behind(mode, case.start) {
            search(&mut at(case), mode, case);
        }
    }
}

/// Between the switches, on each of them, and beside the home switch.
#[test]
fn every_mode_finds_its_zero_from_everywhere() {
    for bounce_ms in [0.0, 3.0] {
        for start in [0.0, -0.52, 0.53, 0.12, 0.3] {
            all_modes(&Case { bounce_ms, start, ..USUAL });
        }
    }
}

#[test]
fn with_every_motor() {
    for ((motor, max_current), start) in MOTORS.into_iter().zip([0.0, 0.3, 0.12, 0.0]) {
        all_modes(&Case { motor, max_current, start, ..USUAL });
    }
}

#[test]
fn with_a_coarse_encoder() {
    for counts in [1000, 4000] {
        for start in [0.0, 0.3] {
            all_modes(&Case { counts, start, ..USUAL });
        }
    }
}

/// From a hundredth of a turn a second to a whole one: the slower, the nearer.
#[test]
fn at_every_speed() {
    for switch_pps in [500, 3000, TURN / 2, TURN] {
        for start in [0.12, 0.3] {
            let settings: &[(Ap, i32)] =
                if switch_pps == 500 { &[(Ap::MaxVelocity, TURN / 2)] } else { &[(Ap::SoftStop, 1)] };
            let modes = if switch_pps == 500 { &[1, 5][..] } else { &[1, 2, 4, 5] };
            for &mode in modes {
                let case = Case { switch_pps, start, settings, ..USUAL };
                search(&mut at(&case), mode, &case);
            }
        }
    }
}

/// In closed loop the unit is 1/256 full step, and AP 140 does not matter.
#[test]
fn at_any_microstep_resolution() {
    for settings in [&[(Ap::MicrostepResolution, 4)], &[(Ap::MicrostepResolution, 8)]] {
        all_modes(&Case { settings, ..USUAL });
    }
}

/// The lag of a rotor that rubs, or of a field that is slow to make up for it, is none of the switch's business.
#[test]
fn friction_does_not_move_the_zero() {
    for settings in [&[(Ap::CorrectionVelocityP, 10_000)][..], &[(Ap::MaxFollowingError, 300)][..]] {
        for friction_nm in [0.0, 0.15] {
            let case = Case { settings, ..USUAL };
            for mode in [1, 2, 3, 4, 5] {
                let mut axis = at(&case);
                axis.set("load.friction_nm", friction_nm);
                search(&mut axis, mode, &case);
            }
        }
    }
}

/// A weight pulls to one side all the time.
#[test]
fn a_weight_does_not_move_the_zero() {
    for mode in [1, 2, 3, 4, 5] {
        let mut axis = at(&USUAL);
        axis.set("load.torque_nm", 0.15);
        search(&mut axis, mode, &USUAL);
    }
}

/// The axis moves to where it is told, in the new coordinates.
#[test]
fn moves_count_from_the_new_zero() {
    let mut axis = at(&USUAL);
    search(&mut axis, 5, &USUAL);
    for target in [5000, -5000, 0] {
        axis.land(target);
    }
}
