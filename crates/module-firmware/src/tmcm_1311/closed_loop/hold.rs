//! Reaching the target and staying there: window, standstill mode, and the way back (TMCM-1311 §8.5; AP 8, 134 to 138).

use super::{AxisParameter, RampMode, Tmcm1311};

/// AP 135 counts in tenths of a millisecond.
const TICKS_PER_WINDOW_UNIT: u32 = 2;

/// AP 136 at which the field is ahead by just what the rotor is off by.
const UNIT_GAIN: i64 = 20;

/// How many control periods the damping's velocity is measured over.
const DAMPING_TICKS: i64 = 5;

impl Tmcm1311 {
    /// A control period of standstill mode, where that is on: the field is ahead by the position error times AP 136, less what
    /// AP 137 damps. An error beyond AP 138 ends it: the ramp starts from where the rotor is. Returns whether it goes on.
    pub(super) fn holds_position(&mut self) -> bool {
        use AxisParameter as P;
        let Some(closed) = self.closed().filter(|closed| closed.holds) else { return false };
        let error = self.target_distance(closed);
        if error.saturating_abs() > i64::from(self.kept_value(P::StandstillErrorLimit)) {
            self.let_go();
            return false;
        }
        let moved = closed.rotor.scale().microsteps(self.tachometer.recent_counts().into());
        let (gain, damping) = (self.kept_value(P::StandstillGain), self.kept_value(P::StandstillDamping));
        let lead = i64::from(gain) * error / UNIT_GAIN - i64::from(damping) * moved / DAMPING_TICKS;
        let limits = motion_control::closed_loop::leads::LeadLimits::new(0, 0);
        if let Some(closed) = self.closed_mut() {
            closed.leads.lead_by(lead, limits);
        }
        true
    }

    /// The rotor was pushed too far: back to the target by the ramp, from here.
    fn let_go(&mut self) {
        self.ramp.halt();
        if let Some(closed) = self.closed_mut() {
            closed.stop_holding();
            closed.forget_leads();
        }
    }

    /// Counts for how long the motor has been at the target, and begins standstill mode when that is long enough.
    pub(super) fn watch_window(&mut self) {
        use AxisParameter as P;
        let Some(closed) = self.closed() else { return };
        let landed = self.search.is_none()
            && self.mode == RampMode::Position
            && self.ramp.is_standing()
            && self.ramp_distance(closed) == 0;
        let off = self.target_position.wrapping_sub(self.encoder_counter()).unsigned_abs();
        let near = off <= self.kept_value(P::PositionReachedWindow).unsigned_abs()
            && closed.leads.ramp().unsigned_abs()
                <= u64::from(self.kept_value(P::StandstillErrorLimit).unsigned_abs());
        let time = self.kept_value(P::PositionReachedTime).unsigned_abs() * TICKS_PER_WINDOW_UNIT;
        let Some(closed) = self.closed_mut() else { return };
        if landed && near {
            closed.in_window = closed.in_window.saturating_add(1);
            closed.holds = closed.in_window > time;
        } else {
            closed.in_window = 0;
        }
    }
}
