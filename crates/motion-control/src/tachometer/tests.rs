extern crate std;

use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::closed_loop::tachometer::Tachometer;

/// Speeds and phases of the ideal encoder are in parts of a count.
const COUNT: i64 = 1 << 20;

/// An ideal shaft and encoder: the counter is the whole part of the position.
struct Shaft {
    position: i64,
    tachometer: Tachometer,
}

impl Shaft {
    /// Standing there.
    fn new(position: i64) -> Self {
        Self { position, tachometer: Tachometer::new(count(position)) }
    }

    fn turn(&mut self, speed: i64) {
        self.position += speed;
        self.tachometer.tick(count(self.position));
    }

    fn turn_for(&mut self, ticks: u32, speed: i64) {
        (0..ticks).for_each(|_| self.turn(speed));
    }

    /// Whether the reading is the true speed within 1/`part` of it and `counts` counts in the window of 320 periods.
    fn reads(&self, speed: i64, part: i64, counts: i64) -> bool {
        let CountRate { counts: distance, ticks } = self.tachometer.rate();
        let ticks = i64::from(ticks);
        let error = (i64::from(distance) * COUNT - speed * ticks).abs();
        error <= speed.abs() * ticks / part + counts * COUNT * ticks / 320
    }
}

/// What the counter reads: it wraps.
fn count(position: i64) -> i32 {
    position.div_euclid(COUNT) as i32
}

/// Speeds of 0.02 to 60 counts in a control period, as many slow ones as fast, in both directions.
fn speed() -> impl Strategy<Value = i64> {
    let magnitude = prop_oneof![COUNT / 50..COUNT / 5, COUNT / 5..2 * COUNT, 2 * COUNT..60 * COUNT];
    (magnitude, any::<bool>()).prop_map(|(speed, forward)| if forward { speed } else { -speed })
}

fn position() -> impl Strategy<Value = i64> {
    let around_the_wrap = (i64::from(i32::MAX) - 5) * COUNT..(i64::from(i32::MAX) + 5) * COUNT;
    prop_oneof![-1000 * COUNT..1000 * COUNT, around_the_wrap]
}

#[test]
fn standing_reads_nothing() {
    let mut tachometer = Tachometer::new(i32::MIN);
    assert!(tachometer.is_at_rest());
    (0..5000).for_each(|_| tachometer.tick(i32::MIN));
    assert_eq!(tachometer, Tachometer::new(i32::MIN));
    assert_eq!(tachometer.rate(), CountRate::STANDING);
}

#[test]
fn a_start_reads_the_full_speed_after_2_ms() {
    let mut shaft = Shaft::new(0);
    shaft.turn_for(41, 10 * COUNT);
    assert_eq!(shaft.tachometer.rate(), CountRate { counts: 400, ticks: 40 });
}

#[test]
fn a_stop_is_seen_in_the_next_period_and_over_after_100_ms() {
    let mut shaft = Shaft::new(0);
    shaft.turn_for(400, 10 * COUNT);
    for idle_ticks in 1..2000 {
        shaft.turn(0);
        assert_eq!(shaft.tachometer.rate(), CountRate { counts: 1, ticks: idle_ticks });
        assert!(!shaft.tachometer.is_at_rest());
    }
    shaft.turn(0);
    assert_eq!(shaft.tachometer, Tachometer::new(4000));
}

#[test]
fn two_edges_the_same_way_are_slow_motion_and_there_and_back_is_none() {
    for (next, counts) in [(1, 1), (-1, 0)] {
        let mut tachometer = Tachometer::new(7);
        tachometer.tick(8);
        (0..999).for_each(|_| tachometer.tick(8));
        assert_eq!(tachometer.rate().counts, 0, "one edge is no speed");
        tachometer.tick(8 + next);
        assert_eq!(tachometer.rate(), CountRate { counts, ticks: 1000 });
    }
}

#[test]
fn recent_counts_are_those_of_five_periods() {
    let mut tachometer = Tachometer::new(i32::MAX);
    let mut recent = Vec::new();
    for moved in [1, 2, -4, 8, 16, 32, 0, 0, 0, 0, 0] {
        tachometer.tick(tachometer.count.wrapping_add(moved));
        recent.push(tachometer.recent_counts());
    }
    assert_eq!(recent, [1, 3, -1, 7, 23, 54, 52, 56, 48, 32, 0]);
}

#[test]
fn time_wraps_unseen() {
    let mut shaft = Shaft::new(0);
    shaft.tachometer.tick = u32::MAX - 500;
    shaft.turn_for(340, COUNT / 20);
    for _ in 0..1000 {
        shaft.turn(COUNT / 20);
        assert!(shaft.reads(COUNT / 20, 100, 0), "{:?}", shaft.tachometer.rate());
    }
    shaft.turn_for(2000, 0);
    assert!(shaft.tachometer.is_at_rest());
}

proptest! {
    /// From rest or from another speed, the reading is settled after 17 ms and stays so.
    #[test]
    fn a_constant_speed_is_read_within_a_percent(position in position(), before in speed(), rests: bool, speed in speed()) {
        let mut shaft = Shaft::new(position);
        shaft.turn_for(500, if rests { 0 } else { before });
        shaft.turn_for(340, speed);
        for _ in 0..700 {
            prop_assert!(shaft.reads(speed, 100, 0), "{speed}: {:?}", shaft.tachometer.rate());
            shaft.turn(speed);
        }
    }

    /// A count in each 10 to 90 ms, in each period from the second edge on.
    #[test]
    fn slow_motion_is_read_within_a_percent(position in position(), interval_ticks in 200_i64..1800, forward: bool) {
        let speed = if forward { COUNT / interval_ticks } else { -COUNT / interval_ticks };
        let mut shaft = Shaft::new(position);
        shaft.turn_for(3700, speed);
        for _ in 0..6000 {
            prop_assert!(shaft.reads(speed, 100, 0), "{speed}: {:?}", shaft.tachometer.rate());
            shaft.turn(speed);
        }
    }

    /// A reversal is seen for what it is within the window.
    #[test]
    fn a_reversal_settles(position in position(), speed in speed()) {
        let mut shaft = Shaft::new(position);
        shaft.turn_for(1000, speed);
        shaft.turn_for(340, -speed);
        prop_assert!(shaft.reads(-speed, 100, 0), "{speed}: {:?}", shaft.tachometer.rate());
    }

    #[test]
    fn dither_is_no_speed(start: i32, dwells in proptest::collection::vec(1_u32..400, 1..100)) {
        let mut tachometer = Tachometer::new(start);
        for (index, ticks) in dwells.into_iter().enumerate() {
            for _ in 0..ticks {
                tachometer.tick(start.wrapping_add((index % 2) as i32));
                prop_assert_eq!(tachometer.rate().counts, 0);
            }
        }
    }

    /// Around a count, one to either side: at most one count in 2 ms.
    #[test]
    fn wide_dither_is_little_speed(
        start: i32,
        dwells in proptest::collection::vec((-1_i32..=1, prop_oneof![1_u32..4, 1_u32..100]), 1..200),
    ) {
        let mut tachometer = Tachometer::new(start);
        for (offset, ticks) in dwells {
            for _ in 0..ticks {
                tachometer.tick(start.wrapping_add(offset));
                let CountRate { counts, ticks } = tachometer.rate();
                prop_assert!(counts.unsigned_abs() * 40 <= ticks, "{counts} in {ticks}");
            }
        }
    }

    /// Whatever the counter does: both directions and all counts are alike, and no reading is faster than the motion was.
    #[test]
    fn directions_and_counts_are_alike(
        start: i32,
        other: i32,
        steps in proptest::collection::vec((-70_i32..=70, prop_oneof![1_u32..4, 1_u32..400]), 1..200),
    ) {
        let mut count = start;
        let mut tachometer = Tachometer::new(start);
        let mut mirrored = Tachometer::new(start.wrapping_neg());
        let mut moved_away = Tachometer::new(start.wrapping_add(other));
        let mut idle_ticks = 0;
        for (moved, ticks) in steps {
            for tick in 0..ticks {
                let moved = if tick == 0 { moved } else { 0 };
                count = count.wrapping_add(moved);
                idle_ticks = if moved == 0 { idle_ticks + 1 } else { 0 };
                tachometer.tick(count);
                mirrored.tick(count.wrapping_neg());
                moved_away.tick(count.wrapping_add(other));
                let rate = tachometer.rate();
                prop_assert_eq!(CountRate { counts: -rate.counts, ..rate }, mirrored.rate());
                prop_assert_eq!(tachometer.recent_counts(), -mirrored.recent_counts());
                prop_assert_eq!(rate, moved_away.rate());
                prop_assert!(rate.ticks > 0);
                prop_assert!(rate.counts.unsigned_abs() <= 70 * rate.ticks);
                prop_assert!(rate.counts.unsigned_abs() * idle_ticks <= 2 * rate.ticks + 1 || rate.ticks == idle_ticks);
            }
        }
    }

    /// At rest and before, skipping is ticking, whatever follows.
    #[test]
    fn skipping_is_ticking(position in position(), speed in speed(), idle in 0_u32..2100, ticks in 1_u32..9000, next in speed()) {
        let mut shaft = Shaft::new(position);
        shaft.turn_for(50, speed);
        shaft.turn_for(idle, 0);
        prop_assert!(shaft.tachometer.is_at_rest() || idle < 2000);
        let mut skipped = Shaft { position: shaft.position, tachometer: shaft.tachometer.clone() };
        skipped.tachometer.skip(u64::from(ticks));
        shaft.turn_for(ticks, 0);
        prop_assert_eq!(&shaft.tachometer, &skipped.tachometer);
        for _ in 0..100 {
            shaft.turn(next);
            skipped.turn(next);
            prop_assert_eq!(&shaft.tachometer, &skipped.tachometer);
        }
    }
}
