//! Moves: how they are started, watched and judged.

use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

use super::{Module, TURN};

const TICKS_PER_S: i64 = 20_000;

/// How far a rotor without load may be from its field, in turns: a full step, for detent torque and resonance. Steps get
/// lost four at a time (decisions 5.8), so this is none.
pub(crate) const SLACK: f64 = 1.0 / 200.0;

/// MVP ABS.
pub(crate) fn move_to(module: &mut Module, position: i32) {
    module.ok(Command::MoveToPosition, 0, 0, position);
}

/// Runs until AP 8 is set, and returns the ticks it took.
#[track_caller]
pub(crate) fn finish(module: &mut Module) -> u64 {
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
pub(crate) fn assert_agree(module: &mut Module, zero: f64) {
    let turns = module.turns() - zero;
    let reported = f64::from(module.gap(Ap::ActualPosition)) / f64::from(TURN);
    let sensed = f64::from(module.gap(Ap::EncoderCounter)) / 40_000.0;
    assert!((reported - turns).abs() < SLACK, "AP 1 says {reported} turns, truth is {turns}");
    // Whole counts, read at the beginning of a control period in which the rotor, at a turn a second, goes two on.
    assert!((sensed - turns).abs() < 8.0 / 40_000.0, "AP 209 says {sensed} turns, truth is {turns}");
}

/// The rotor has turned by `turns` since `zero`.
#[track_caller]
pub(crate) fn assert_turned(module: &Module, zero: f64, turns: f64) {
    let turned = module.turns() - zero;
    assert!((turned - turns).abs() < SLACK, "{turned} turns, not {turns}");
}

/// Runs to the end of a move and checks at every tick that neither limit is exceeded, that the position never goes back
/// and never beyond the target. Returns the ticks.
pub(crate) fn finish_within_limits(module: &mut Module) -> u64 {
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
