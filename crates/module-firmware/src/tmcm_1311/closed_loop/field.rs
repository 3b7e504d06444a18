//! Where the field stands: how far ahead it may be, how fast it makes up for a lag, and AP 112 (TMCM-1311 §8.4, §8.9).

use motion_control::closed_loop::leads::{Correction, LeadLimits};
use motion_control::closed_loop::weakening;

use super::{AxisParameter, Tmcm1311, turned};

impl Tmcm1311 {
    /// How far the field may be ahead now: γ counts on the side the rotor turns to (§8.9).
    pub(super) fn lead_limits(&self) -> LeadLimits {
        let Some(closed) = self.closed() else { return LeadLimits::new(0, 0) };
        let (scale, rate) = (closed.rotor.scale(), self.tachometer.rate());
        let from_pps = self.kept_value(AxisParameter::FieldWeakeningMinVelocity).unsigned_abs();
        // Mostly there is nothing to weaken, which takes no division to see.
        if !scale.is_faster(rate.counts, rate.ticks, from_pps) {
            return LeadLimits::new(0, 0);
        }
        let velocity_pps = scale.velocity_pps(rate.counts, rate.ticks);
        LeadLimits::new(self.gamma_at(velocity_pps), velocity_pps)
    }

    /// AP 230, which reads as its default until there is a field to weaken.
    pub(in super::super) fn gamma(&self) -> i32 {
        if self.closed().is_none() {
            return self.kept_value(AxisParameter::Gamma);
        }
        self.gamma_at(self.measured_velocity_pps())
    }

    fn gamma_at(&self, velocity_pps: i32) -> i32 {
        let velocity = |parameter| self.kept_value(parameter).unsigned_abs();
        weakening::gamma(
            velocity_pps.unsigned_abs(),
            velocity(AxisParameter::FieldWeakeningMinVelocity),
            velocity(AxisParameter::FieldWeakeningMaxVelocity),
        )
    }

    /// AP 124 to 126.
    pub(super) fn correction(&self) -> Correction {
        use AxisParameter as P;
        let value = |parameter| self.kept_value(parameter).unsigned_abs();
        // A move goes on until it arrives (§8.4): what is left alone on the way is made up for at its end.
        let left_alone = if self.is_driven() { value(P::MaxFollowingError) } else { 0 };
        Correction {
            proportional: value(P::CorrectionVelocityP),
            max_following_error: left_alone,
            // The ramp may come from a faster mode, and has to brake.
            max_velocity_pps: self
                .largest_driven_pps()
                .max(value(P::MaxCorrectionVelocity))
                .max(self.ramp.velocity_pps().unsigned_abs()),
        }
    }

    /// Whether ramp or pulses are on their way.
    fn is_driven(&self) -> bool {
        !self.ramp.is_standing() || self.is_pulsed()
    }

    /// The fastest that ramp or pulses may be.
    fn largest_driven_pps(&self) -> u32 {
        let largest_pps = if self.in_step_dir_mode() {
            self.kept_value(AxisParameter::MaxVelocity).max(self.actual_velocity_pps().saturating_abs())
        } else if self.search.is_some() {
            let pace = self.search_pace();
            pace.search_pps.max(pace.switch_pps)
        } else {
            self.kept_value(AxisParameter::MaxVelocity)
        };
        largest_pps.unsigned_abs()
    }

    /// Where the field stands, AP 112 included.
    pub(super) fn field_phase(&self) -> u16 {
        let Some(closed) = self.closed() else { return self.phase };
        let offset = self.kept_value(AxisParameter::EncoderOffset);
        let offset = if offset == 0 { 0 } else { closed.rotor.scale().microsteps(offset.into()) };
        turned(closed.rotor_phase, offset + i64::from(closed.leads.field()))
    }
}
