//! What can be read of the closed loop (TMCM-1311 §8.10).

use super::{AxisParameter, Operation, RampMode, Tmcm1311};
use motion_control::closed_loop::scale::EncoderScale;

impl Tmcm1311 {
    /// What the encoder's counts are worth: as the closed loop began with, else as AP 202 and AP 210 say now.
    pub(in super::super) fn encoder_scale(&self) -> Option<EncoderScale> {
        match self.closed() {
            Some(closed) => Some(*closed.rotor.scale()),
            None => EncoderScale::new(
                self.kept_value(AxisParameter::MotorFullSteps).unsigned_abs(),
                self.kept_value(AxisParameter::EncoderResolution).unsigned_abs(),
            ),
        }
    }

    /// AP 131, in pps of 256 µsteps a full step, whatever AP 140 is; 0 where the resolutions make no sense.
    pub(in super::super) fn measured_velocity_pps(&self) -> i32 {
        let rate = self.tachometer.rate();
        if rate.counts == 0 {
            return 0;
        }
        self.encoder_scale().map_or(0, |scale| scale.velocity_pps(rate.counts, rate.ticks))
    }

    /// AP 129.
    pub(in super::super) fn is_closing_or_closed(&self) -> bool {
        matches!(self.operation, Operation::Aligning { .. } | Operation::Closed(_))
    }

    /// AP 14: the current in torque mode, else how far the field is ahead, in µsteps.
    pub(in super::super) fn torque_or_advance(&self) -> i32 {
        match self.mode {
            RampMode::Torque => self.kept_value(AxisParameter::TorqueTargetCurrent),
            _ => self.closed().map_or(0, |closed| closed.leads.field()),
        }
    }

    /// AP 16: only at a commanded velocity.
    pub(in super::super) fn is_velocity_reached(&self) -> bool {
        let off = i64::from(self.measured_velocity_pps()) - i64::from(self.target_velocity);
        self.closed().is_some()
            && self.search.is_none()
            && self.mode == RampMode::Velocity
            && off.abs() <= i64::from(self.kept_value(AxisParameter::VelocityReachedWindow))
    }

    /// AP 18 bit 12.
    pub(in super::super) fn is_holding(&self) -> bool {
        self.closed().is_some_and(|closed| closed.holds)
    }

    /// AP 123.
    pub(in super::super) fn current_scale(&self) -> i32 {
        self.closed().map_or(i32::from(u8::MAX), |closed| closed.current.actual().into())
    }

    /// AP 236.
    pub(in super::super) fn target_current_scale(&self) -> i32 {
        self.closed().map_or(i32::from(u8::MAX), |closed| closed.current.target().into())
    }

    /// AP 233: where the ramp is, in µsteps of the user's coordinates.
    pub(in super::super) fn virtual_position(&self) -> i32 {
        match self.closed() {
            None => self.ramp.position(),
            // Counted back from the target, so that the ramp ends on just what the target is worth.
            Some(closed) => {
                let left = self.target_position.wrapping_sub(self.encoder_counter());
                let target = i64::from(self.encoder_counter()) + i64::from(left);
                let target = closed.rotor.scale().microsteps(target);
                target.wrapping_sub(self.ramp_distance(closed)) as i32 // wraps, as every position does
            }
        }
    }

    /// Where the ramp is, in the unit of AP 0 and AP 1.
    pub(in super::super) fn ramp_position(&self) -> i32 {
        match self.closed() {
            None => self.ramp.position(),
            Some(_) => self.encoder_counter().wrapping_add(self.position_error()),
        }
    }

    /// AP 237: how far the ramp is ahead of the rotor, in the unit of AP 0 and AP 1.
    pub(in super::super) fn position_error(&self) -> i32 {
        match self.closed() {
            None => self.ramp.position().wrapping_sub(self.encoder_position()),
            Some(closed) => {
                let counts = closed.rotor.counts_to(closed.leads.ramp());
                counts.clamp(i32::MIN.into(), i32::MAX.into()) as i32
            }
        }
    }
}
