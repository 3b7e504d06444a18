use proptest::prelude::*;

use super::*;

const TICKS_PER_MS: u32 = 20;

fn limits(max_velocity_pps: i32, acceleration_pps2: i32) -> Limits {
    Limits { max_velocity_pps, acceleration_pps2, start_stop_velocity_pps: 0 }
}

/// Ticks until the ramp stands on its target, at most `patience`.
fn run(ramp: &mut Ramp, limits: &Limits, patience: u32) -> Option<u32> {
    (0..=patience).find(|_| {
        let there = ramp.is_on_target();
        if !there {
            ramp.tick(limits);
        }
        there
    })
}

#[test]
fn a_triangle_takes_two_seconds() {
    let limits = limits(51_200, 51_200);
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Position(51_200));
    let ticks = run(&mut ramp, &limits, 50_000).expect("arrives");
    assert!(ticks.abs_diff(2000 * TICKS_PER_MS) <= TICKS_PER_MS, "{ticks} ticks");
    assert_eq!((ramp.position(), ramp.velocity_pps()), (51_200, 0));
}

#[test]
fn a_trapezoid_takes_distance_over_velocity_plus_velocity_over_acceleration() {
    for (distance, velocity, acceleration) in [
        (512_000, 51_200, 51_200),
        (-100_000, 20_000, 40_000),
        (10_000, 1_000, 100),
        (1 << 24, 327_679_999, 24_999_998),
    ] {
        let limits = limits(velocity, acceleration);
        let mut ramp = Ramp::default();
        ramp.set_goal(Goal::Position(distance));
        let ticks = run(&mut ramp, &limits, 10_000_000).expect("arrives");
        let (d, v, a) = (i64::from(distance).abs(), i64::from(velocity), i64::from(acceleration));
        let expected = if d * a >= v * v {
            (d * TICKS_PER_SECOND) / v + (v * TICKS_PER_SECOND) / a
        } else {
            2 * (d * TICKS_PER_SECOND * TICKS_PER_SECOND / a).isqrt()
        };
        assert!(i64::from(ticks).abs_diff(expected) <= 4, "{ticks} ticks, not {expected}");
        assert_eq!(ramp.position(), distance);
    }
}

#[test]
fn the_slowest_ramp_is_exact_too() {
    let limits = limits(10, 1);
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Position(4));
    let ticks = run(&mut ramp, &limits, 100_000).expect("arrives");
    assert!(ticks.abs_diff(4000 * TICKS_PER_MS) <= 4, "{ticks} ticks");
}

#[test]
fn velocity_mode_reaches_the_velocity_and_keeps_it_to_the_step() {
    let limits = limits(100_000, 100_000);
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Velocity(-33_333));
    for _ in 0..20_000 {
        ramp.tick(&limits);
    }
    assert_eq!(ramp.velocity_pps(), -33_333);
    let start = ramp.position();
    for _ in 0..3600 * 20_000 / 100 {
        ramp.tick(&limits);
    }
    assert_eq!(ramp.position() - start, -33_333 * 36);
}

#[test]
fn start_and_stop_velocity_skip_the_slow_ends() {
    let ramped = limits(10_000, 10_000);
    let mut slow = Ramp::default();
    slow.set_goal(Goal::Position(10_000));
    let slow_ticks = run(&mut slow, &ramped, 100_000).expect("arrives");
    let with_start = Limits { start_stop_velocity_pps: 5_000, ..ramped };
    let mut quick = Ramp::default();
    quick.set_goal(Goal::Position(10_000));
    quick.tick(&with_start);
    assert!(quick.velocity_pps() >= 5_000);
    let quick_ticks = run(&mut quick, &with_start, 100_000).expect("arrives");
    // 5000…10 000 and back takes 1 s over 7500 steps; the other 2500 take 0.25 s.
    assert!(quick_ticks.abs_diff(25_000) <= 4, "{quick_ticks}");
    assert!(slow_ticks.abs_diff(40_000) <= 4, "{slow_ticks}");
    // Equal to the target velocity: no ramp at all (§8.4).
    let square = Limits { start_stop_velocity_pps: 10_000, ..ramped };
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Position(10_000));
    assert_eq!(run(&mut ramp, &square, 100_000), Some(20_000));
}

#[test]
fn the_shorter_way_round() {
    let limits = limits(300_000_000, 24_999_998);
    let mut ramp = Ramp::default();
    ramp.redefine_position(i32::MAX - 10);
    ramp.set_goal(Goal::Position(i32::MIN + 10));
    assert!(run(&mut ramp, &limits, 10_000).is_some());
    assert_eq!(ramp.position(), i32::MIN + 10);
}

#[test]
fn redefining_the_position_moves_nothing() {
    let limits = limits(10_000, 10_000);
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Position(5_000));
    for _ in 0..1000 {
        ramp.tick(&limits);
    }
    let (position, velocity) = (ramp.position(), ramp.velocity_pps());
    ramp.redefine_position(-70_000);
    assert_eq!(ramp.goal(), Goal::Position(-70_000 + 5_000 - position));
    assert_eq!(ramp.velocity_pps(), velocity);
    assert!(run(&mut ramp, &limits, 100_000).is_some());
}

#[test]
fn a_target_behind_is_reached_after_braking_and_turning() {
    let limits = limits(50_000, 100_000);
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Position(40_000));
    for _ in 0..8_000 {
        ramp.tick(&limits);
    }
    ramp.set_goal(Goal::Position(0));
    assert!(run(&mut ramp, &limits, 100_000).is_some());
    assert_eq!(ramp.position(), 0);
}

#[test]
fn a_halt_is_at_once_and_for_good() {
    let limits = limits(50_000, 100_000);
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Position(40_000));
    for _ in 0..8_000 {
        ramp.tick(&limits);
    }
    let position = ramp.position();
    ramp.halt();
    ramp.tick(&limits);
    assert!(ramp.is_on_target() && ramp.position() == position);
}

#[test]
fn no_velocity_no_motion() {
    let limits = limits(0, 1000);
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Position(1000));
    for _ in 0..1000 {
        ramp.tick(&limits);
    }
    assert_eq!(ramp.position(), 0);
    assert!(ramp.is_settled(&limits));
}

/// Something a user changes in mid-flight.
#[derive(Clone, Debug)]
enum Change {
    Target(i32),
    Velocity(i32),
    MaxVelocity(i32),
    Acceleration(i32),
    StartStop(i32),
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        3 => (-3_000_000..3_000_000).prop_map(Change::Target),
        1 => (-50..50).prop_map(Change::Target),
        2 => (-3_000_000..3_000_000).prop_map(Change::Velocity),
        1 => (1_000..3_000_000).prop_map(Change::MaxVelocity),
        1 => (100_000..24_999_998).prop_map(Change::Acceleration),
        1 => (0..100_000).prop_map(Change::StartStop),
    ]
}

fn apply(change: &Change, ramp: &mut Ramp, limits: &mut Limits) {
    match *change {
        Change::Target(target) => ramp.set_goal(Goal::Position(target)),
        Change::Velocity(velocity) => ramp.set_goal(Goal::Velocity(velocity)),
        Change::MaxVelocity(velocity) => limits.max_velocity_pps = velocity,
        Change::Acceleration(acceleration) => limits.acceleration_pps2 = acceleration,
        Change::StartStop(velocity) => limits.start_stop_velocity_pps = velocity,
    }
}

/// One tick, and what must hold of it whatever was changed before.
fn checked_tick(ramp: &mut Ramp, limits: &Limits) -> Result<(), TestCaseError> {
    let before = ramp.clone();
    ramp.tick(limits);
    let acceleration = i64::from(limits.acceleration_pps2);
    let top = limits.top_speed();
    let stop = (i64::from(limits.start_stop_velocity_pps) * TICKS_PER_SECOND).min(top);
    let (old, new) = (before.velocity, ramp.velocity);
    // The velocity limit, unless it was lowered below the velocity, which then falls by the deceleration.
    prop_assert!(new.abs() <= top.max(old.abs() - acceleration), "{old} -> {new} beyond {top}");
    // The acceleration limit; from and to velocities below the start/stop velocity it does not count.
    let jump = if old.abs().min(new.abs()) <= stop { stop.max(acceleration) } else { acceleration };
    prop_assert!((new - old).abs() <= jump + acceleration, "{old} -> {new}");
    if old.abs() > stop && new.abs() > stop {
        prop_assert!((new - old).abs() <= acceleration, "{old} -> {new}");
    }
    // What was covered is what the velocities say: the position never runs ahead of the limit.
    let moved = i64::from(ramp.position.wrapping_sub(before.position)) * UNITS_PER_STEP + ramp.fraction
        - before.fraction;
    let fastest = old.abs().max(new.abs()).max(stop).max(acceleration / 2 + 2);
    prop_assert!(moved.abs() <= 2 * fastest, "moved {moved} units at {old} -> {new}");
    Ok(())
}

/// Whether braking from now on ends before `target`: then it must not be overshot.
fn can_stop_in_time(ramp: &Ramp, target: i32, limits: &Limits) -> bool {
    let ahead = i128::from(ramp.distance_to(target));
    let speed = i128::from(ramp.velocity);
    let stop = i128::from(limits.start_stop_velocity_pps.min(limits.max_velocity_pps))
        * i128::from(TICKS_PER_SECOND);
    let braking = (speed * speed - stop * stop).max(0) / i128::from(limits.acceleration_pps2);
    speed * ahead >= 0 && braking <= ahead.abs()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 300 } else { 10_000 }))]

    /// Limits hold in every tick, and once nothing changes any more, the ramp approaches monotonously and ends exactly.
    #[test]
    fn every_sequence_keeps_the_invariants(changes in proptest::collection::vec((change(), 0..400_u32), 1..12), last in -1_000_000..1_000_000) {
        let mut ramp = Ramp::default();
        let mut limits = limits(500_000, 5_000_000);
        for (change, ticks) in &changes {
            apply(change, &mut ramp, &mut limits);
            for _ in 0..*ticks {
                checked_tick(&mut ramp, &limits)?;
            }
        }
        ramp.set_goal(Goal::Position(last));
        limits.max_velocity_pps = limits.max_velocity_pps.max(100_000);
        let mut overshoots = 0;
        let allowed = u32::from(!can_stop_in_time(&ramp, last, &limits));
        let mut patience = 3_000_000;
        while !ramp.is_on_target() {
            let before = ramp.distance_to(last);
            let closing = ramp.velocity.signum() == before.signum();
            checked_tick(&mut ramp, &limits)?;
            let after = ramp.distance_to(last);
            let overshot = before.signum() * after.signum() < 0;
            overshoots += u32::from(overshot);
            // Running away is braking; everything else comes closer.
            prop_assert!(after.abs() <= before.abs() || overshot || !closing, "from {before} to {after}");
            patience -= 1;
            prop_assert!(patience > 0, "never arrives: {ramp:?} {limits:?}");
        }
        prop_assert!(overshoots <= allowed, "overshot {overshoots} times, {allowed} allowed");
        prop_assert_eq!(ramp.position(), last);
        // And there it stays, once the last change of speed is behind it.
        ramp.tick(&limits);
        prop_assert!(ramp.is_on_target() && ramp.is_settled(&limits));
        let settled = ramp.clone();
        ramp.tick(&limits);
        prop_assert_eq!(&ramp, &settled);
    }
}
