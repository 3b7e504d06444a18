//! Reaching the target and staying there: window, standstill mode, and the way back (TMCM-1311 §8.5; AP 8, 134 to 138).

use motion_control::closed_loop::leads::{LeadLimits, QUARTER_PERIOD};

use super::{AxisParameter, RampMode, Tmcm1311};

/// AP 135 counts in tenths of a millisecond.
const TICKS_PER_WINDOW_UNIT: u32 = 2;

/// AP 136 at which the field is ahead by just what the rotor is off by.
const UNIT_GAIN: i64 = 20;

/// What the field is ahead by when standstill begins goes on, less by a µstep each millisecond, which is how fast the current
/// rises by default: a load is handed over gently, and not dropped.
const CARRIED_PER_MICROSTEP: i64 = 20;

/// How many control periods the damping's velocity is measured over.
const DAMPING_TICKS: i64 = 5;

impl Tmcm1311 {
    /// A control period of standstill mode, where that is on: the field is ahead by the position error times AP 136, less what
    /// AP 137 damps. An error beyond AP 138 ends it: the ramp starts from where the rotor is. Returns whether it goes on.
    pub(super) fn holds_position(&mut self) -> bool {
        use AxisParameter as P;
        let Some(closed) = self.closed().filter(|closed| closed.holds) else { return false };
        // The ramp is on the target.
        let error = closed.leads.ramp();
        if error.saturating_abs() > i64::from(self.kept_value(P::StandstillErrorLimit)) {
            self.let_go();
            return false;
        }
        let moved = closed.rotor.scale().microsteps(self.tachometer.recent_counts().into());
        let (gain, damping) = (self.kept_value(P::StandstillGain), self.kept_value(P::StandstillDamping));
        let lead = i64::from(gain) * error / UNIT_GAIN - i64::from(damping) * moved / DAMPING_TICKS;
        let limits = LeadLimits::new(0, 0);
        if let Some(closed) = self.closed_mut() {
            closed.leads.lead_by(lead + closed.carried / CARRIED_PER_MICROSTEP, limits);
            closed.carried -= closed.carried.signum();
        }
        true
    }

    /// The rotor was pushed too far: back to the target by the ramp, from here. Pulses do not come again: where these drive,
    /// the field goes back without a ramp.
    fn let_go(&mut self) {
        let by_ramp = !self.in_step_dir_mode();
        self.ramp.halt();
        if let Some(closed) = self.closed_mut() {
            closed.stop_holding();
            closed.recovers = by_ramp;
            if by_ramp {
                closed.leads.forget_ramp();
            }
        }
    }

    /// As long as the rotor is pushed further away, the way back has not begun: the ramp gives way, and starts from near where
    /// it gets to. The field goes on pulling.
    pub(super) fn begin_return_anew(&mut self) {
        let limit =
            i64::from(self.kept_value(AxisParameter::StandstillErrorLimit)) + i64::from(QUARTER_PERIOD);
        let Some(closed) = self.closed_mut() else { return };
        if closed.recovers && closed.leads.ramp().saturating_abs() > limit {
            closed.leads.give_way(limit);
            self.ramp.halt();
        }
    }

    /// Counts for how long the motor has been at the target, and begins standstill mode when that is long enough and nothing
    /// drives it any more.
    pub(super) fn watch_window(&mut self) {
        use AxisParameter as P;
        let Some(closed) = self.closed() else { return };
        let landed = self.ramp.is_standing() && (self.ramp_distance(closed) == 0 || self.in_step_dir_mode());
        let landed = landed && !self.is_pulsed();
        let positions = self.search.is_none() && self.mode == RampMode::Position;
        let off = self.target_position.wrapping_sub(self.encoder_counter()).unsigned_abs();
        let near = off <= self.kept_value(P::PositionReachedWindow).unsigned_abs()
            && closed.leads.ramp().unsigned_abs()
                <= u64::from(self.kept_value(P::StandstillErrorLimit).unsigned_abs());
        let time = self.kept_value(P::PositionReachedTime).unsigned_abs() * TICKS_PER_WINDOW_UNIT;
        let gain = i64::from(self.kept_value(P::StandstillGain));
        let Some(closed) = self.closed_mut() else { return };
        closed.in_window =
            if positions && near { closed.in_window.saturating_add(1).min(time + 1) } else { 0 };
        closed.holds = landed && closed.in_window > time;
        if closed.holds {
            closed.recovers = false;
            closed.leads.forget_overload();
            let held = gain * closed.leads.ramp() / UNIT_GAIN;
            closed.carried = (i64::from(closed.leads.field()) - held) * CARRIED_PER_MICROSTEP;
        }
    }
}
