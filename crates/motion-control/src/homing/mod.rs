//! Reference search: drives until it finds a switch, measures its edges slowly, and ends on the new zero.
//!
//! A search is one leg or two; a leg finds one switch and measures either the edge that it comes to first or its middle:
//!
//! 1. *Seek* at search speed until the switch is active; *stop*, and let the rotor swing out.
//! 2. *Clear* it: slowly back, until it is off for certain.
//! 3. *Enter* it slowly.
//! 4. For the edge, *leave* it slowly the way it came: the edge is midway between entry and release. For the middle, *cross*
//!    it and enter it from the other side: the middle is midway between the two entries.
//! 5. *Return* slowly to what was measured last: the new zero.
//!
//! Both instants that count are seen at constant speed and in opposite directions, so that whatever the rotor lags behind
//! its field by cancels; where the axis is measured, it does not matter in the first place. An instant is the first sample that differs from a steady level; what bounces afterwards does not
//! matter.
//!
//! This module must never know parameter numbers or TMCL, how switches are wired, or what moves the axis.

mod contact;
mod exchange;
mod mode;

use crate::ramp::Goal;
use contact::Run;
pub use exchange::{Order, Pace, Seen, Switches};
pub use mode::Mode;
use mode::{Direction, Leg, Place, Switch};

/// How long the axis stands before it turns round, in control periods: 100 ms, in which the rotor swings out.
const REST_TICKS: u16 = 2000;

/// A switch is cleared by what the axis covers at switch speed in 1/20 s, so that it enters again at speed.
const CLEARANCES_PER_SECOND: i32 = 20;

/// Where a leg has got to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Seek,
    /// Stops where the switch was found, or, with `turn`, at a stop switch.
    Stop {
        turn: bool,
    },
    Clear,
    Enter,
    /// It is on, perhaps still bouncing.
    Onto,
    /// Back off the switch, for its edge; where it was first seen released.
    Leave {
        released: Option<i32>,
    },
    /// Through the switch, for its middle.
    Cross,
    /// Beyond it, on the way back.
    EnterBack,
    Return {
        zero: i32,
    },
}

/// A search that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Search {
    leg: Leg,
    next: Option<Leg>,
    home_inverted: bool,
    phase: Phase,
    /// Which way the leg comes to the switch; not its direction any more once it turned round.
    direction: Direction,
    contact: Run,
    rested: u16,
    /// Where the switch was found at search speed.
    found: i32,
    /// Where it was entered slowly.
    entered: i32,
    /// Where the right stop switch is, once that is known.
    right: Option<i32>,
}

impl Search {
    /// A search that begins wherever the axis is and however it moves.
    #[must_use]
    pub fn new(mode: Mode) -> Self {
        Self {
            leg: mode.first,
            next: mode.second,
            home_inverted: mode.home_inverted,
            phase: Phase::Seek,
            direction: mode.first.direction,
            contact: Run { active: false, ticks: 0 },
            rested: 0,
            found: 0,
            entered: 0,
            right: None,
        }
    }

    /// Where it has got to; never 0.
    ///
    /// 1 seeks a switch, 2 stops there, 3 backs off, 4 enters, 5 leaves it or crosses it, 6 comes back from beyond, 7 goes to
    /// the new zero; 10 more while it is still about the right stop switch of a search for both.
    #[must_use]
    pub fn state(&self) -> i32 {
        let state = match self.phase {
            Phase::Seek => 1,
            Phase::Stop { .. } => 2,
            Phase::Clear => 3,
            Phase::Enter | Phase::Onto => 4,
            Phase::Leave { .. } | Phase::Cross => 5,
            Phase::EnterBack => 6,
            Phase::Return { .. } => 7,
        };
        if self.next.is_some() { state + 10 } else { state }
    }

    /// The position was called something else, this much more.
    pub fn shift(&mut self, by: i32) {
        let shifted = |position: i32| position.wrapping_add(by);
        self.found = shifted(self.found);
        self.entered = shifted(self.entered);
        self.right = self.right.map(shifted);
        self.phase = match self.phase {
            Phase::Leave { released } => Phase::Leave { released: released.map(shifted) },
            Phase::Return { zero } => Phase::Return { zero: shifted(zero) },
            other => other,
        };
    }

    /// One control period.
    pub fn tick(&mut self, seen: &Seen, pace: &Pace) -> Order {
        let before = self.contact;
        self.contact.see(self.is_active(seen.switches));
        match self.phase {
            Phase::Seek => self.seek(seen),
            Phase::Stop { turn } => self.stop(seen, turn),
            Phase::Clear => self.clear(seen, pace),
            Phase::Enter => self.enter(seen),
            Phase::Onto => self.settle_onto(seen, pace),
            Phase::Leave { released } => self.leave(seen, released, before),
            Phase::Cross => self.cross(seen, pace),
            Phase::EnterBack => self.enter_back(seen),
            Phase::Return { zero } if seen.standing && seen.position == zero => {
                let distance = self.right.map(|right| right.wrapping_sub(zero));
                return Order::Finished { distance };
            }
            Phase::Return { .. } => {}
        }
        let order = self.order(seen, pace);
        if self.is_blocked(order, seen) { Order::Blocked } else { order }
    }

    /// Whether the order leads into a stop switch that this leg neither looks for nor turns round at. Whoever looks for the
    /// home switch regardless of the stop switches is never blocked.
    fn is_blocked(&self, order: Order, seen: &Seen) -> bool {
        let regardless = self.leg.switch == Switch::Home && !self.leg.turns_round;
        let turns_round = self.leg.turns_round && matches!(self.phase, Phase::Seek | Phase::Enter);
        let Order::Drive { goal, .. } = order else { return false };
        let ahead = match goal {
            Goal::Velocity(velocity_pps) => velocity_pps,
            Goal::Position(position) => position.wrapping_sub(seen.position),
        };
        let runs_into = |switch, active, sign| active && self.leg.switch != switch && ahead.signum() == sign;
        !regardless
            && !turns_round
            && (runs_into(Switch::Left, seen.switches.left, -1)
                || runs_into(Switch::Right, seen.switches.right, 1))
    }

    fn is_active(&self, switches: Switches) -> bool {
        match self.leg.switch {
            Switch::Left => switches.left,
            Switch::Right => switches.right,
            Switch::Home => switches.home != self.home_inverted,
        }
    }

    /// Whether it is time to turn round.
    fn meets_stop(&self, switches: Switches) -> bool {
        let ahead = match self.direction {
            Direction::Negative => switches.left,
            Direction::Positive => switches.right,
        };
        self.leg.turns_round && ahead && !self.contact.active
    }

    fn seek(&mut self, seen: &Seen) {
        if self.contact.active {
            self.found = seen.measured;
            self.begin_stop(false);
        } else if self.meets_stop(seen.switches) {
            self.begin_stop(true);
        }
    }

    fn begin_stop(&mut self, turn: bool) {
        self.rested = 0;
        self.phase = Phase::Stop { turn };
    }

    fn stop(&mut self, seen: &Seen, turn: bool) {
        self.rested = if seen.standing { self.rested.saturating_add(1) } else { 0 };
        if self.rested < REST_TICKS {
            return;
        }
        if turn {
            self.direction = self.direction.reversed();
            self.phase = Phase::Seek;
        } else {
            self.contact.ticks = 0;
            self.phase = Phase::Clear;
        }
    }

    /// So far before the place where it was found it is off on the near side, even when it overran a narrow switch.
    fn clear(&mut self, seen: &Seen, pace: &Pace) {
        if self.direction.beyond(seen.measured, self.found) > -clearance(pace) {
            self.contact.ticks = 0;
        } else if self.contact.is_steady(false) {
            self.phase = Phase::Enter;
        }
    }

    fn enter(&mut self, seen: &Seen) {
        if self.contact.active {
            self.entered = seen.measured;
            self.phase = match self.leg.place {
                Place::Edge => Phase::Onto,
                Place::Middle => Phase::Cross,
            };
        } else if self.meets_stop(seen.switches) {
            // What was found before was no switch.
            self.begin_stop(true);
        }
    }

    /// On it for certain; or through it, when it is very narrow, and then its middle has to do.
    fn settle_onto(&mut self, seen: &Seen, pace: &Pace) {
        if self.contact.is_steady(true) {
            self.phase = Phase::Leave { released: None };
        } else if self.is_across(seen, pace) {
            self.phase = Phase::EnterBack;
        }
    }

    fn leave(&mut self, seen: &Seen, released: Option<i32>, before: Run) {
        // Pressed for good, or once more after it was released for good: what was noted was not the edge on this side.
        let entered_again = self.contact.active && before.is_steady(false);
        let released = match released {
            _ if self.contact.is_steady(true) || entered_again => None,
            None if !self.contact.active => Some(seen.measured),
            noted => noted,
        };
        self.phase = Phase::Leave { released };
        let off = self.direction.beyond(seen.measured, self.entered) < 0;
        if let Some(released) = released.filter(|_| off && self.contact.is_steady(false)) {
            self.conclude(midway(self.entered, released));
        }
    }

    fn cross(&mut self, seen: &Seen, pace: &Pace) {
        if self.is_across(seen, pace) {
            self.phase = Phase::EnterBack;
        }
    }

    /// Whether the switch was left on the far side. Off where it was entered is not across: the rotor swings.
    fn is_across(&mut self, seen: &Seen, pace: &Pace) -> bool {
        let beyond = self.direction.beyond(seen.measured, self.entered);
        if !self.contact.active && beyond <= clearance(pace) {
            self.contact.ticks = 0;
        }
        self.contact.is_steady(false)
    }

    fn enter_back(&mut self, seen: &Seen) {
        if self.contact.active {
            self.conclude(midway(self.entered, seen.measured));
        }
    }

    /// A switch is measured.
    fn conclude(&mut self, place: i32) {
        match self.next.take() {
            None => self.phase = Phase::Return { zero: place },
            Some(leg) => {
                self.right = Some(place);
                self.leg = leg;
                self.direction = leg.direction;
                self.contact = Run { active: false, ticks: 0 };
                self.phase = Phase::Seek;
            }
        }
    }

    fn order(&self, seen: &Seen, pace: &Pace) -> Order {
        let turn = |direction: Direction, velocity_pps: i32| Order::Drive {
            goal: Goal::Velocity(velocity_pps.saturating_mul(direction.sign())),
            max_velocity_pps: velocity_pps,
        };
        match self.phase {
            Phase::Seek => turn(self.direction, pace.search_pps),
            Phase::Stop { .. } if !pace.soft_stop && !seen.standing => Order::Halt,
            Phase::Stop { .. } => Order::Drive { goal: Goal::Velocity(0), max_velocity_pps: pace.search_pps },
            Phase::Enter | Phase::Onto | Phase::Cross => turn(self.direction, pace.switch_pps),
            Phase::Clear | Phase::Leave { .. } | Phase::EnterBack => {
                turn(self.direction.reversed(), pace.switch_pps)
            }
            Phase::Return { zero } => {
                Order::Drive { goal: Goal::Position(zero), max_velocity_pps: pace.switch_pps }
            }
        }
    }
}

/// How far from a place the axis is well clear of it, in steps.
fn clearance(pace: &Pace) -> i64 {
    i64::from(pace.switch_pps / CLEARANCES_PER_SECOND)
}

/// Half-way from `a` to `b`, the shorter way round, rounded towards `a`.
fn midway(a: i32, b: i32) -> i32 {
    a.wrapping_add(b.wrapping_sub(a) / 2)
}

#[cfg(test)]
mod tests;
