//! What reading and writing each axis parameter means (TMCM-1076 §4).

use super::registers::{self, chopconf_field, coolconf_field};
use super::{AxisParameter, Tmcm1076};

impl Tmcm1076 {
    pub(super) fn parameter(&self, parameter: AxisParameter) -> i32 {
        use AxisParameter as P;
        let sensed = &self.sensed;
        match parameter {
            P::Tstep => sensed.tstep.cast_signed(),
            P::CoolstepActualCurrent => sensed.cs_actual.into(),
            P::LoadValue if sensed.stealth => sensed.pwm_scale_sum.into(),
            P::LoadValue => sensed.sg_result.into(),
            P::Coolconf => self.coolconf.read(),
            P::Chopconf => self.chopconf.read(),
            P::CoolstepMinCurrent
            | P::CoolstepDownStep
            | P::CoolstepHysteresis
            | P::CoolstepUpStep
            | P::CoolstepHysteresisStart
            | P::Stallguard2Filter
            | P::Stallguard2Threshold => {
                coolconf_field(parameter).map_or(0, |field| self.coolconf.read_field(field))
            }
            P::MicrostepInterpolation | P::DoubleEdgeSteps => {
                chopconf_field(parameter).map_or(0, |field| self.chopconf.read_field(field))
            }
            P::MaxCurrent
            | P::StandbyCurrent
            | P::StandbyCurrentDelay
            | P::HighVelocityThreshold
            | P::StealthchopVelocityLimit
            | P::Pwmconf
            | P::MicrostepResolution
            | P::CoolstepThresholdVelocity => self.kept_value(parameter),
        }
    }

    pub(super) fn set_parameter(&mut self, parameter: AxisParameter, value: i32) {
        if let Some(field) = coolconf_field(parameter) {
            self.coolconf.write_field(field, value);
        } else if let Some(field) = chopconf_field(parameter) {
            self.chopconf.write_field(field, value);
        } else {
            match parameter {
                AxisParameter::Coolconf => self.coolconf.write(value),
                AxisParameter::Chopconf => self.chopconf.write(value),
                // Measurements read what the driver says, whatever is written.
                _ => self.kept.set(parameter.index(), value),
            }
        }
    }

    /// What reads the same already is no write, so that storing and restoring a factory-fresh register leaves it fresh; and
    /// where nothing is stored, a register is as the factory made it.
    pub(super) fn restore_parameter(&mut self, parameter: AxisParameter, stored: Option<i32>, default: i32) {
        match (parameter, stored) {
            (AxisParameter::Coolconf, None) => self.coolconf = registers::factory_coolconf(),
            (AxisParameter::Chopconf, None) => self.chopconf = registers::factory_chopconf(),
            _ => {
                let value = stored.unwrap_or(default);
                if self.parameter(parameter) != value {
                    self.set_parameter(parameter, value);
                }
            }
        }
    }
}
