//! Torque mode: a current that is always 90° ahead (TMCM-1311 §8.7; AP 14, 19, 20 and 141).

use motion_control::ramp::Goal;

use super::{AxisParameter, RampMode, Tmcm1311};
use crate::axis::Refused;

impl Tmcm1311 {
    /// SAP 14, and AP 128 = 2: turns with this current from now on. Only in closed loop.
    pub(in super::super) fn apply_torque(&mut self, current_ma: i32) -> Result<(), Refused> {
        if self.closed().is_none() {
            return Err(Refused::NotAvailable);
        }
        self.search = None;
        self.forget_deviation();
        self.kept.set(AxisParameter::TorqueTargetCurrent.index(), current_ma);
        if self.mode != RampMode::Torque {
            self.begin_motion();
            self.mode = RampMode::Torque;
        }
        Ok(())
    }

    /// AP 19 in mA; in open loop what was written there.
    pub(in super::super) fn torque_current_ma(&self) -> i32 {
        let written_ma = self.kept_value(AxisParameter::TorqueActualCurrent);
        self.closed().map_or(written_ma, |closed| closed.torque.actual_ma())
    }

    /// SAP 19: torque mode goes on from this current.
    pub(in super::super) fn set_torque_current(&mut self, current_ma: i32) {
        self.kept.set(AxisParameter::TorqueActualCurrent.index(), current_ma);
        if let Some(closed) = self.closed_mut() {
            closed.torque.set_actual(current_ma);
        }
    }

    /// The ramp takes over where the rotor is, at the speed it has.
    pub(super) fn leave_torque(&mut self) {
        if self.mode != RampMode::Torque {
            return;
        }
        self.mode = RampMode::Velocity;
        self.take_over_from_rotor();
        if let Some(closed) = self.closed_mut() {
            closed.torque_is_held = false;
        }
    }

    fn take_over_from_rotor(&mut self) {
        let velocity_pps = self.measured_velocity_pps();
        self.ramp.halt();
        self.ramp.set_velocity_pps(velocity_pps);
        if let Some(closed) = self.closed_mut() {
            closed.forget_leads();
            closed.torque.set_actual(0);
        }
    }

    /// A control period of torque mode.
    pub(super) fn drive_torque(&mut self) {
        use AxisParameter as P;
        let largest_ma = self.max_possible_current_ma();
        let target_ma = self.kept_value(P::TorqueTargetCurrent).min(largest_ma).max(-largest_ma);
        if self.is_blocked(target_ma) || self.is_blocked(self.torque_current_ma()) {
            return self.hold_before_switch();
        }
        let slope = self.kept_value(P::TorqueCurrentSlope).unsigned_abs();
        let start_stop_ma = self.kept_value(P::TorqueStartStopCurrent).unsigned_abs();
        let limits = self.lead_limits();
        self.ramp.halt();
        let Some(closed) = self.closed_mut() else { return };
        closed.torque_is_held = false;
        closed.torque.tick(target_ma, slope, start_stop_ma);
        closed.leads.forget_ramp();
        let lead = limits.towards(closed.torque.actual_ma());
        closed.leads.lead_by(lead.into(), limits);
    }

    /// A stop switch forbids this direction: brakes, at once or with AP 149 by the ramp, and stays until it is released.
    fn hold_before_switch(&mut self) {
        if self.closed().is_some_and(|closed| !closed.torque_is_held) {
            self.take_over_from_rotor();
        }
        if !self.stops_softly() {
            self.ramp.halt();
        }
        self.ramp.set_goal(Goal::Velocity(0));
        let before = self.ramp.position();
        self.ramp.tick(&self.limits());
        let steps = self.ramp.position().wrapping_sub(before);
        let limits = self.lead_limits();
        // A ramp that stands would throw a fast rotor back as hard as it braked it.
        let runs_on = self.tachometer.recent_counts();
        let brakes = self.is_blocked(runs_on) && !self.stops_softly();
        if let Some(closed) = self.closed_mut() {
            closed.torque_is_held = true;
            if brakes {
                closed.leads.forget_ramp();
                closed.leads.lead_by(limits.towards(runs_on.saturating_neg()).into(), limits);
            } else {
                closed.leads.ramp_moved(steps.into());
                closed.leads.follow_closely(limits);
            }
        }
    }
}
