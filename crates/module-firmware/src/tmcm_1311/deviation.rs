//! Motor stop on deviation: the rotor is too far from where the ramp says it should be (TMCM-1311 §6, AP 207 and AP 212).

use super::{AxisParameter, MICROSTEPS, Operation, RampMode, Tmcm1311};
use crate::axis::Axis;

impl Tmcm1311 {
    /// Stops at once when ramp and encoder (AP 1 and AP 209) are further apart than |AP 212|, in 1/256 full steps; a
    /// negative AP 212 switches the current off too. Both last until the next motion command. Returns whether it stopped.
    pub(super) fn stop_on_deviation(&mut self) -> bool {
        // Before the encoder is known to be right, it cannot tell a deviation.
        if matches!(self.operation, Operation::Detecting(_) | Operation::Aligning { .. }) {
            return false;
        }
        let limit = self.kept_value(AxisParameter::MaxEncoderDeviation);
        let flag = AxisParameter::EncoderDeviationFlag.index();
        if limit == 0 || self.kept.get(flag) != 0 || self.deviation() <= limit.unsigned_abs() {
            return false;
        }
        self.stop_at_once();
        self.kept.set(flag, 1);
        self.switched_off = limit < 0;
        true
    }

    /// A motion command ends what a deviation began.
    pub(super) fn forget_deviation(&mut self) {
        self.kept.set(AxisParameter::EncoderDeviationFlag.index(), 0);
        self.switched_off = false;
    }

    /// Stands still, where it is, whatever it was about to do.
    pub(super) fn stop_at_once(&mut self) {
        self.search = None;
        self.step_dir.stop();
        self.ramp.halt();
        self.stay_with_rotor();
        self.target_position = self.actual_position();
        if self.mode == RampMode::Velocity {
            self.target_velocity = 0;
            self.ramp.set_goal(motion_control::ramp::Goal::Velocity(0));
        }
    }

    /// How far ramp and encoder are apart, in 1/256 full steps; 0 where the resolutions make no sense.
    fn deviation(&self) -> u32 {
        if let Some(closed) = self.closed() {
            return u32::try_from(closed.shortfall().unsigned_abs()).unwrap_or(u32::MAX);
        }
        let full_steps = i64::from(self.kept_value(AxisParameter::MotorFullSteps));
        let resolution = i64::from(self.kept_value(AxisParameter::EncoderResolution));
        let counter = i64::from(self.encoder_counter());
        let Some(measured) = (counter * full_steps * i64::from(MICROSTEPS)).checked_div(resolution) else {
            return 0;
        };
        let commanded = i64::from(self.ramp.position()) * i64::from(self.microstep_size());
        u32::try_from((commanded - measured).unsigned_abs()).unwrap_or(u32::MAX)
    }
}
