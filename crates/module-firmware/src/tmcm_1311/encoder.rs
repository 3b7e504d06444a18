//! The encoder's counter and its null channel (TMCM-1311 §6, AP 198, 201 and 209).

use super::{AxisParameter, MICROSTEPS, Tmcm1311};

/// Bits of AP 201.
pub(super) const CLEAR_ON_NEXT_NULL: i32 = 4;
const CLEAR_ON_EVERY_NULL: i32 = 8;

impl Tmcm1311 {
    /// AP 209.
    pub(super) fn encoder_counter(&self) -> i32 {
        self.sensed.encoder_counts.wrapping_add(self.encoder_offset)
    }

    /// Calls the place where the encoder is something else. In closed loop that is the position: the target goes along, and
    /// nothing moves.
    pub(super) fn redefine_encoder(&mut self, value: i32) {
        if self.closed().is_some() {
            let shift = value.wrapping_sub(self.encoder_counter());
            self.target_position = self.target_position.wrapping_add(shift);
        }
        self.set_encoder_counter(value);
    }

    pub(super) fn set_encoder_counter(&mut self, value: i32) {
        self.encoder_offset = value.wrapping_sub(self.sensed.encoder_counts);
    }

    /// Makes AP 209 zero in the control period in which the index passed, where AP 201 says so; the bit for the next event
    /// clears with it. The polarity (bit 4) is that of the line, which the sensors have taken into account.
    pub(super) fn clear_encoder_on_null(&mut self) {
        let mode = self.kept_value(AxisParameter::EncoderMode);
        if self.sensed.encoder_index && mode & (CLEAR_ON_NEXT_NULL | CLEAR_ON_EVERY_NULL) != 0 {
            self.redefine_encoder(0);
            self.kept.set(AxisParameter::EncoderMode.index(), mode & !CLEAR_ON_NEXT_NULL);
        }
    }

    /// The encoder counter in microsteps; where the resolutions make no sense, the ramp's position.
    pub(super) fn encoder_position(&self) -> i32 {
        let microsteps = i64::from(self.kept_value(AxisParameter::MotorFullSteps)) * i64::from(MICROSTEPS)
            / i64::from(self.microstep_size());
        let counter = i64::from(self.encoder_counter());
        let resolution = i64::from(self.kept_value(AxisParameter::EncoderResolution));
        (counter * microsteps)
            .checked_div(resolution)
            .and_then(|position| i32::try_from(position).ok())
            .unwrap_or_else(|| self.ramp.position())
    }
}
