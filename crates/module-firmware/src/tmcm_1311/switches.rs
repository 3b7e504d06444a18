//! Stop switches and home switch: which are active, and what they stop (TMCM-1311 §6, AP 9 to 13, 149; §10.1, GP 79).
//!
//! Contacts are normally closed, so that a broken wire stops the motor: an open one is active (decision, from §9).
//!
//! A stop switch holds back motion towards it and nothing else: the target stays, motion away is free, and once the switch is
//! released or disabled the motor goes on to its target (decision).

use motion_control::ramp::Goal;

use super::{AxisParameter, RampMode, Tmcm1311};

/// IN_1, which is the home switch too.
const HOME_INPUT: u8 = 1 << 1;

impl Tmcm1311 {
    pub(super) fn is_left_switch_active(&self) -> bool {
        self.sensed.left_switch_open != self.reversed_switches
    }

    pub(super) fn is_right_switch_active(&self) -> bool {
        self.sensed.right_switch_open != self.reversed_switches
    }

    /// Its contact pulls IN_1 down while it is closed.
    pub(super) fn is_home_switch_active(&self) -> bool {
        let open = self.sensed.inputs & HOME_INPUT != 0;
        open != self.reversed_switches
    }

    /// Whether a stop switch forbids motion in the direction of this sign.
    pub(super) fn is_blocked(&self, direction: i32) -> bool {
        let (active, disabled) = match direction.signum() {
            -1 => (self.is_left_switch_active(), AxisParameter::LeftLimitSwitchDisable),
            1 => (self.is_right_switch_active(), AxisParameter::RightLimitSwitchDisable),
            _ => return false,
        };
        active && self.kept_value(disabled) == 0
    }

    /// What the ramp may drive at: the target, or a stop while a switch lies in the way to it.
    pub(super) fn allowed_goal(&self) -> Goal {
        let (goal, direction) = match self.mode {
            RampMode::Velocity => (Goal::Velocity(self.target_velocity), self.target_velocity),
            RampMode::Torque => (Goal::Velocity(0), 0),
            // The shorter way round, as the ramp goes.
            RampMode::Position => {
                let target = self.ramp_target();
                (Goal::Position(target), target.wrapping_sub(self.ramp.position()))
            }
        };
        if self.is_blocked(direction) { Goal::Velocity(0) } else { goal }
    }

    /// Stops what runs into a stop switch: at once, or with AP 149 set with the ramp.
    pub(super) fn heed_switches(&mut self) {
        let runs_into_it = self.is_blocked(self.ramp.velocity_pps());
        if runs_into_it && !self.stops_softly() {
            self.ramp.halt();
        }
        self.ramp.set_goal(self.allowed_goal());
    }

    /// AP 149.
    pub(super) fn stops_softly(&self) -> bool {
        self.kept_value(AxisParameter::SoftStop) != 0
    }
}
