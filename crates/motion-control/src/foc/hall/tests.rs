use proptest::prelude::*;

use super::*;

/// What the lines show in sectors 0 to 5.
const PATTERNS: [u8; 6] = [0b001, 0b011, 0b010, 0b110, 0b100, 0b101];

/// The pattern in a sector counted over many turns.
fn lines(sector: i64) -> u8 {
    PATTERNS[sector.rem_euclid(6) as usize]
}

/// An electrical angle over many turns, in parts of 1/65 536, and the lines there.
fn lines_at(angle: i64) -> u8 {
    lines((angle * 6).div_euclid(65_536))
}

fn distance(one: u16, other: u16) -> u16 {
    (one.wrapping_sub(other) as i16).unsigned_abs()
}

fn run(tracker: &mut HallTracker, sector: i64, ticks: u32) {
    (0..ticks).for_each(|_| tracker.tick(lines(sector), false));
}

#[test]
fn six_patterns_are_sectors_and_two_are_none() {
    for (number, bits) in (0..).zip(PATTERNS) {
        assert_eq!(sector(bits, false), Some(number));
        assert_eq!(sector(!bits & 7, true), Some(number));
        assert_eq!(sector(bits | 0xF8, false), Some(number));
    }
    for inverted in [false, true] {
        assert_eq!((sector(0, inverted), sector(7, inverted)), (None, None));
    }
}

#[test]
fn without_interpolation_the_rotor_is_in_the_middle() {
    let degrees = |angle: u16| f64::from(angle) * 360.0 / 65_536.0;
    for (number, bits) in (0_u8..).zip(PATTERNS) {
        let mut tracker = HallTracker::new();
        assert_eq!(tracker.angle(true), 0);
        tracker.tick(bits, false);
        assert_eq!(tracker.sector(), Some(number));
        assert!((degrees(tracker.angle(false)) - f64::from(number) * 60.0 - 30.0).abs() < 0.01);
        assert_eq!(tracker.angle(true), tracker.angle(false), "no edge yet");
        assert_eq!((tracker.edge(), tracker.count()), (None, 0));
    }
}

#[test]
fn an_edge_is_exact_whichever_way_it_is_crossed() {
    for (from, to) in [(5, 0), (0, 5), (2, 3), (3, 2), (0, 1)] {
        let mut tracker = HallTracker::new();
        run(&mut tracker, from, 10);
        run(&mut tracker, to, 1);
        let degrees = match (from, to) {
            (0, 1) => 60,
            (2, 3) | (3, 2) => 180,
            _ => 0,
        };
        assert_eq!(tracker.edge(), Some((degrees * 65_536_u32).div_ceil(360) as u16), "{from} to {to}");
        run(&mut tracker, to, 1);
        assert_eq!(tracker.edge(), None);
    }
}

#[test]
fn a_stop_stays_at_the_far_edge_and_after_500_ms_in_the_middle() {
    for direction in [1, -1] {
        let mut tracker = HallTracker::new();
        run(&mut tracker, 0, 100);
        run(&mut tracker, direction, 100);
        run(&mut tracker, 2 * direction, 101);
        let far = tracker.angle(true);
        assert!(distance(far, edge_angle(if direction > 0 { 3 } else { 4 })) <= 1, "{far}");
        run(&mut tracker, 2 * direction, 9899);
        assert_eq!(tracker.angle(true), far);
        run(&mut tracker, 2 * direction, 1);
        assert_eq!(tracker.angle(true), tracker.angle(false));
        // The first edge after standstill says nothing about the speed.
        run(&mut tracker, 3 * direction, 5);
        assert_eq!(tracker.angle(true), tracker.angle(false));
    }
}

#[test]
fn a_reversal_says_nothing_about_the_speed() {
    let mut tracker = HallTracker::new();
    (0..4).for_each(|sector| run(&mut tracker, sector, 50));
    assert_ne!(tracker.angle(true), tracker.angle(false));
    run(&mut tracker, 2, 50);
    assert_eq!(tracker.angle(true), tracker.angle(false));
    assert_eq!(tracker.count(), 2);
    run(&mut tracker, 1, 26);
    assert!(distance(tracker.angle(true), middle(1)) < 2);
}

#[test]
fn invalid_patterns_are_an_error_while_they_last_and_lose_nothing() {
    let mut tracker = HallTracker::new();
    tracker.tick(0, false);
    assert_eq!((tracker.error(), tracker.sector()), (Some(HallError::InvalidPattern), None));
    run(&mut tracker, 4, 20);
    assert_eq!(tracker.error(), None);
    for bits in [0, 7] {
        tracker.tick(bits, false);
        assert_eq!((tracker.error(), tracker.sector()), (Some(HallError::InvalidPattern), Some(4)));
    }
    run(&mut tracker, 5, 1);
    assert_eq!((tracker.error(), tracker.count()), (None, 1));
}

#[test]
fn a_skip_goes_the_shorter_way_and_is_an_error_once() {
    for (to, count) in [(2, 2), (-2, -2), (3, 3)] {
        let mut tracker = HallTracker::new();
        run(&mut tracker, 0, 5);
        run(&mut tracker, to, 1);
        assert_eq!((tracker.error(), tracker.count()), (Some(HallError::SkippedSector), count));
        run(&mut tracker, to, 1);
        assert_eq!(tracker.error(), None);
    }
    let mut backwards = HallTracker::new();
    run(&mut backwards, 1, 5);
    run(&mut backwards, 0, 5);
    run(&mut backwards, 3, 1);
    assert_eq!(backwards.count(), -4);
}

#[test]
fn the_position_wraps() {
    let mut tracker = HallTracker { count: i32::MAX, ..HallTracker::new() };
    run(&mut tracker, 5, 2);
    run(&mut tracker, 0, 2);
    assert_eq!(tracker.count(), i32::MIN);
}

proptest! {
    /// However the sectors are sampled, whole turns there and back count six each.
    #[test]
    fn turns_are_counted_exactly(
        start in 0_i64..6,
        inverted: bool,
        steps in proptest::collection::vec((-2_i64..=2, 0_u32..300), 0..200),
    ) {
        let mut tracker = HallTracker::new();
        let mut position = start;
        let tick = |tracker: &mut HallTracker, position| {
            tracker.tick(if inverted { !lines(position) } else { lines(position) }, inverted);
        };
        tick(&mut tracker, position);
        for (step, more) in steps {
            position += step;
            tick(&mut tracker, position);
            let skipped = step.abs() > 1;
            prop_assert_eq!(tracker.error(), skipped.then_some(HallError::SkippedSector));
            (0..more).for_each(|_| tick(&mut tracker, position));
            prop_assert_eq!(i64::from(tracker.count()), position - start);
        }
    }

    /// At a constant speed the interpolated angle is the true one but for the uncertainty of three sampled edges.
    #[test]
    fn a_constant_speed_is_interpolated(start in 0_i64..65_536, speed in 4_i64..2500, forward: bool) {
        let speed = if forward { speed } else { -speed };
        let mut tracker = HallTracker::new();
        let mut angle = start;
        let settled = 3 * 10_923 / speed.abs() + 4;
        for tick in 0..settled + 2 * 65_536 / speed.abs() {
            tracker.tick(lines_at(angle), false);
            if tick > settled {
                let error = i64::from(distance(tracker.angle(true), angle as u16));
                prop_assert!(error <= 3 * speed.abs() + 2, "{error} at {angle}");
                prop_assert!(distance(tracker.angle(false), angle as u16) <= 5463);
            }
            angle += speed;
        }
    }

    /// Whatever the lines do, a guess is within the sector they show, and nothing overflows.
    #[test]
    fn a_guess_stays_in_its_sector(steps in proptest::collection::vec((any::<u8>(), any::<bool>(), 1_u32..12_000), 1..30)) {
        let mut tracker = HallTracker::new();
        for (bits, inverted, ticks) in steps {
            for _ in 0..ticks {
                tracker.tick(bits, inverted);
                if let Some(sector) = tracker.sector() {
                    prop_assert!(distance(tracker.angle(true), middle(sector)) <= 5463);
                }
            }
            prop_assert_eq!(tracker.error() == Some(HallError::InvalidPattern), sector(bits, inverted).is_none());
        }
    }
}
