use proptest::prelude::*;

use super::contact::STEADY_TICKS;
use super::*;
use crate::ramp::{Limits, Ramp};

const ACCELERATION: i32 = 200_000;
const PACE: Pace = Pace { search_pps: 40_000, switch_pps: 4000, soft_stop: true };

/// Where each switch is active, ends included; and for how many ticks contacts bounce.
#[derive(Clone, Copy, Debug)]
struct Travel {
    left: (i32, i32),
    right: (i32, i32),
    home: (i32, i32),
    bounce_ticks: u32,
}

const TRAVEL: Travel =
    Travel { left: (-60_500, -60_000), right: (60_000, i32::MAX), home: (10_000, 12_001), bounce_ticks: 0 };

/// A contact that shows nonsense for a while after each change.
#[derive(Clone, Copy, Debug, Default)]
struct Contact {
    active: bool,
    bouncing: u32,
}

impl Contact {
    fn see(&mut self, (from, to): (i32, i32), position: i32, bounce_ticks: u32, seed: &mut u32) -> bool {
        let active = (from..=to).contains(&position);
        if active != self.active {
            *self = Self { active, bouncing: bounce_ticks };
        }
        if self.bouncing == 0 {
            return active;
        }
        self.bouncing -= 1;
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // The first sample shows the change, or there would be no truth to compare with.
        if self.bouncing + 1 == bounce_ticks { active } else { *seed >> 31 != 0 }
    }
}

/// What a search came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Found {
    zero: i32,
    distance: Option<i32>,
    /// The furthest it went, either way.
    lowest: i32,
    highest: i32,
}

fn search(number: i32, start: i32, travel: &Travel, pace: &Pace) -> Option<Found> {
    let mut search = Search::new(Mode::from_number(number)?);
    let mut ramp = Ramp::default();
    ramp.redefine_position(start);
    let mut seed = start.cast_unsigned();
    let within = |(from, to): (i32, i32)| Contact { active: (from..=to).contains(&start), bouncing: 0 };
    let mut contacts = [within(travel.left), within(travel.right), within(travel.home)];
    let (mut lowest, mut highest) = (start, start);
    for _ in 0..4_000_000 {
        let [left, right, home] = &mut contacts;
        let mut level = |contact: &mut Contact, stretch| {
            contact.see(stretch, ramp.position(), travel.bounce_ticks, &mut seed)
        };
        let switches = Switches {
            left: level(left, travel.left),
            right: level(right, travel.right),
            home: level(home, travel.home) != (number >= 128),
        };
        let position = ramp.position();
        let seen = Seen { switches, position, measured: position, standing: ramp.is_standing() };
        assert_ne!(search.state(), 0);
        match search.tick(&seen, pace) {
            Order::Drive { goal, max_velocity_pps } => {
                assert!(max_velocity_pps == pace.search_pps || max_velocity_pps == pace.switch_pps);
                ramp.set_goal(goal);
                ramp.tick(&Limits {
                    max_velocity_pps,
                    acceleration_pps2: ACCELERATION,
                    start_stop_velocity_pps: 0,
                });
            }
            Order::Halt => ramp.halt(),
            Order::Blocked => return None,
            Order::Finished { distance } => {
                return Some(Found { zero: ramp.position(), distance, lowest, highest });
            }
        }
        lowest = lowest.min(ramp.position());
        highest = highest.max(ramp.position());
    }
    None
}

/// Where the mode's zero is.
fn truth(number: i32, travel: &Travel) -> (i32, Option<i32>) {
    let middle = |(from, to): (i32, i32)| i32::midpoint(from, to);
    let edge = travel.left.1;
    match number & !128 {
        1 => (edge, None),
        2 => (edge, Some(travel.right.0 - edge)),
        3 => (middle(travel.left), Some(travel.right.0 - middle(travel.left))),
        4 => (middle(travel.left), None),
        _ => (middle(travel.home), None),
    }
}

#[track_caller]
fn assert_finds(number: i32, start: i32, travel: &Travel, pace: &Pace) -> Found {
    let found = search(number, start, travel, pace);
    let found = found.unwrap_or_else(|| panic!("mode {number} from {start} never ends"));
    let (zero, distance) = truth(number, travel);
    assert!(found.zero.abs_diff(zero) <= 1, "mode {number} from {start}: {found:?}, not {zero}");
    assert_eq!(found.distance.is_some(), distance.is_some(), "mode {number}");
    if let (Some(found), Some(distance)) = (found.distance, distance) {
        assert!(found.abs_diff(distance) <= 2, "mode {number} from {start}: {found}, not {distance}");
    }
    found
}

#[test]
fn every_mode_finds_its_place_from_everywhere_it_can() {
    for soft_stop in [false, true] {
        let pace = Pace { soft_stop, ..PACE };
        for bounce_ticks in [0, 30] {
            let travel = Travel { bounce_ticks, ..TRAVEL };
            for number in (1..=8).chain(129..=136) {
                for start in [-60_200, -59_000, 0, 9_999, 11_000, 15_000, 59_999, 60_000, 61_000] {
                    // Ignoring stop switches, 7 and 8 never turn round.
                    let behind = match number & !128 {
                        7 => start > travel.home.1,
                        8 => start < travel.home.0,
                        _ => false,
                    };
                    if !behind {
                        assert_finds(number, start, &travel, &pace);
                    }
                }
            }
        }
    }
}

#[test]
fn numbers_without_a_mode_are_none() {
    for number in [-1, 0, 9, 127, 128, 137, 255, 256 + 1, i32::MIN] {
        assert_eq!(Mode::from_number(number), None, "{number}");
    }
}

/// A stop switch that is hit at search speed is overrun by no more than the ramp needs, or not at all.
#[test]
fn what_is_hit_is_overrun_by_the_braking_distance_at_most() {
    let braking = PACE.search_pps / 2 * (PACE.search_pps / 1000) / (ACCELERATION / 1000);
    let soft = assert_finds(1, 0, &TRAVEL, &PACE);
    assert!((TRAVEL.left.1 - soft.lowest).abs_diff(braking) <= 4, "{soft:?}, {braking}");
    let hard = assert_finds(1, 0, &TRAVEL, &Pace { soft_stop: false, ..PACE });
    // What remains is entered slowly, until the contact is steady.
    let slow = PACE.switch_pps / 2 * (PACE.switch_pps / 1000) / (ACCELERATION / 1000);
    let steady = PACE.switch_pps * i32::from(STEADY_TICKS) / 20_000;
    assert!(TRAVEL.left.1 - hard.lowest <= slow + steady + 4, "{hard:?}");
}

/// It runs to and fro between the stop switches, and ends as soon as the home switch works.
#[test]
fn without_a_home_switch_it_stays_between_the_stop_switches() {
    let travel = Travel { home: (200_000, 200_000), ..TRAVEL };
    for number in [5, 6] {
        assert_eq!(search(number, 0, &travel, &PACE), None, "mode {number}");
    }
}

#[test]
fn a_position_that_is_called_otherwise_does_not_matter() {
    let mode = Mode::from_number(3).expect("a mode");
    let (mut plain, mut shifted) = (Search::new(mode), Search::new(mode));
    let (mut ramp, mut by) = (Ramp::default(), 0_i32);
    for tick in 0..4_000_000 {
        let inside = |(from, to): (i32, i32)| (from..=to).contains(&ramp.position());
        let switches = Switches { left: inside(TRAVEL.left), right: inside(TRAVEL.right), home: false };
        let position = ramp.position();
        let seen = Seen { switches, position, measured: position, standing: ramp.is_standing() };
        if tick % 1000 == 0 {
            shifted.shift(1_000_000_007);
            by = by.wrapping_add(1_000_000_007);
        }
        let order = plain.tick(&seen, &PACE);
        let position = position.wrapping_add(by);
        let other = shifted.tick(&Seen { position, measured: position, ..seen }, &PACE);
        match (order, other) {
            (
                Order::Drive { goal: Goal::Position(goal), max_velocity_pps },
                Order::Drive { goal: moved, .. },
            ) => {
                assert_eq!(moved, Goal::Position(goal.wrapping_add(by)));
                ramp.set_goal(Goal::Position(goal));
                ramp.tick(&Limits {
                    max_velocity_pps,
                    acceleration_pps2: ACCELERATION,
                    start_stop_velocity_pps: 0,
                });
            }
            (Order::Drive { goal, max_velocity_pps }, other) => {
                assert_eq!(order, other);
                ramp.set_goal(goal);
                ramp.tick(&Limits {
                    max_velocity_pps,
                    acceleration_pps2: ACCELERATION,
                    start_stop_velocity_pps: 0,
                });
            }
            (order, other) => {
                assert_eq!(order, other);
                assert!(matches!(order, Order::Finished { distance: Some(_) }));
                return;
            }
        }
    }
    panic!("never ends");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 60 } else { 2000 }))]

    /// Wherever it starts, however the contacts bounce: it ends on its zero, and never leaves the travel between the outermost
    /// switches by more than it takes to stop.
    #[test]
    fn no_search_runs_away(
        number in 1..=6_i32,
        inverted in any::<bool>(),
        start in -60_500..80_000_i32,
        home in -50_000..50_000_i32,
        width in 200..5000_i32,
        bounce_ticks in 0..200_u32,
        soft_stop in any::<bool>(),
        search_pps in 10_000..100_000_i32,
        switch_pps in 1000..8000_i32,
    ) {
        let travel = Travel { home: (home, home + width), bounce_ticks, ..TRAVEL };
        let pace = Pace { search_pps, switch_pps, soft_stop };
        let number = if inverted { number + 128 } else { number };
        let found = search(number, start, &travel, &pace);
        prop_assert!(found.is_some(), "never ends");
        let Some(found) = found else { return Ok(()) };
        let (zero, _) = truth(number, &travel);
        prop_assert!(found.zero.abs_diff(zero) <= 1, "{:?}, not {}", found, zero);
        let stopping = |velocity_pps: i32| i64::from(velocity_pps).pow(2) / i64::from(2 * ACCELERATION);
        let bounce = i64::from(bounce_ticks + 100) * i64::from(switch_pps) / 20_000;
        let beyond = stopping(search_pps) + stopping(switch_pps) + bounce + 100;
        prop_assert!(i64::from(found.lowest) >= i64::from(travel.left.0) - beyond, "{:?}", found);
        prop_assert!(i64::from(found.highest) <= i64::from(travel.right.0.max(start)) + beyond, "{:?}", found);
    }
}
