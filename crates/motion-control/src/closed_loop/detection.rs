//! Encoder detection: turns the motor once and counts (TMCM-1311 §6, AP 132; decision).
//!
//! A pre-turn of an electrical period comes first, so that the rotor is in step with the field and whatever it lags behind
//! by is the same at both ends of the turn that counts.

use crate::TICKS_PER_SECOND;
use crate::ramp::{Goal, Limits};

/// Full steps in an electrical period.
const ELECTRICAL_PERIOD: i32 = 4;

/// How long the rotor gets to come to rest: 200 ms.
const REST_TICKS: u32 = (TICKS_PER_SECOND / 5) as u32;

/// Quarters of a line: any encoder has a multiple of it in a turn.
const COUNTS_PER_LINE: i32 = 4;

/// The largest resolution that can be set.
const LARGEST_RESOLUTION: i32 = 65_535;

/// What the motor is like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motor {
    /// Full steps in a turn; at least 1.
    pub full_steps: i32,
    /// Steps of the ramp in a full step; at least 1.
    pub steps_per_full_step: i32,
}

/// What the axis is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// The encoder's raw counter.
    pub count: i32,
    /// The ramp's position in steps.
    pub position: i32,
    /// Whether the ramp stands.
    pub standing: bool,
}

/// What the axis shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Drive at a position within these limits.
    Drive(Goal, Limits),
    /// The encoder has so many counts in a turn.
    Found(i32),
    /// It has too few, too many, or counts the wrong way.
    Failed,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    PreTurn,
    Turn { count: i32 },
}

/// A detection that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detection {
    motor: Motor,
    stage: Stage,
    goal: i32,
    rested: u32,
}

impl Detection {
    /// One that begins at `position`, where the ramp stands.
    #[must_use]
    pub fn new(motor: Motor, position: i32) -> Self {
        let pre_turn = ELECTRICAL_PERIOD * motor.steps_per_full_step;
        Self { motor, stage: Stage::PreTurn, goal: position.wrapping_add(pre_turn), rested: 0 }
    }

    /// A control period.
    pub fn tick(&mut self, seen: &Seen) -> Order {
        let there = seen.standing && seen.position == self.goal;
        self.rested = if there { self.rested + 1 } else { 0 };
        if self.rested >= REST_TICKS {
            match self.stage {
                Stage::PreTurn => self.begin_turn(seen.count),
                Stage::Turn { count } => return self.verdict(seen.count.wrapping_sub(count)),
            }
        }
        Order::Drive(Goal::Position(self.goal), self.limits())
    }

    fn begin_turn(&mut self, count: i32) {
        self.rested = 0;
        self.stage = Stage::Turn { count };
        self.goal = self.goal.wrapping_add(self.steps_per_turn());
    }

    fn verdict(&self, counts: i32) -> Order {
        let resolution =
            counts.saturating_add(COUNTS_PER_LINE / 2).div_euclid(COUNTS_PER_LINE) * COUNTS_PER_LINE;
        let fits = (2 * self.motor.full_steps..=LARGEST_RESOLUTION).contains(&resolution);
        if fits { Order::Found(resolution) } else { Order::Failed }
    }

    /// A turn a second, reached in a quarter of a second.
    fn limits(&self) -> Limits {
        let turn = self.steps_per_turn();
        Limits {
            max_velocity_pps: turn,
            acceleration_pps2: turn.saturating_mul(4),
            start_stop_velocity_pps: 0,
        }
    }

    fn steps_per_turn(&self) -> i32 {
        self.motor.full_steps.saturating_mul(self.motor.steps_per_full_step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ramp::Ramp;

    const MOTOR: Motor = Motor { full_steps: 200, steps_per_full_step: 256 };

    /// Runs one with an encoder that shows `count` where the ramp is; returns the end, and how far the motor turned.
    fn run(motor: Motor, count: impl Fn(i32) -> i32) -> (Order, i32) {
        let mut ramp = Ramp::default();
        let mut detection = Detection::new(motor, 0);
        for _ in 0..100_000 {
            let (position, standing) = (ramp.position(), ramp.is_standing());
            match detection.tick(&Seen { count: count(position), position, standing }) {
                Order::Drive(goal, limits) => {
                    ramp.set_goal(goal);
                    ramp.tick(&limits);
                }
                end => return (end, position),
            }
        }
        panic!("never ends: {detection:?}");
    }

    #[test]
    fn it_finds_the_resolution_whatever_count_it_begins_at() {
        for counts in [400_i32, 1000, 4000, 10_000, 16_384, 40_000, 65_532] {
            let count = |position: i32| (i64::from(position) * i64::from(counts) / 51_200) as i32 + 77;
            assert_eq!(run(MOTOR, count), (Order::Found(counts), 51_200 + 1024));
        }
    }

    #[test]
    fn a_coarse_microstep_is_none_the_worse() {
        let motor = Motor { full_steps: 200, steps_per_full_step: 1 };
        assert_eq!(run(motor, |position| position * 20), (Order::Found(4000), 204));
    }

    #[test]
    fn what_cannot_be_fails() {
        assert_eq!(run(MOTOR, |_| 5).0, Order::Failed, "dead");
        assert_eq!(run(MOTOR, |position| -position).0, Order::Failed, "the wrong way");
        assert_eq!(run(MOTOR, |position| position / 129).0, Order::Failed, "396 counts");
        assert_eq!(run(MOTOR, |position| position * 2).0, Order::Failed, "102 400 counts");
    }
}
