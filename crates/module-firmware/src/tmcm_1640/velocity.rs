//! How fast the motor turns (AP 3).

use motion_control::foc::speed;

use super::Tmcm1640;

impl Tmcm1640 {
    /// AP 3 in rpm, by the sensor that commutates.
    pub(super) fn velocity_rpm(&self) -> i32 {
        let rate = if self.is_encoder_mode() { self.encoder_speed.rate() } else { self.hall_speed.rate() };
        speed::rpm(rate, u32::try_from(self.counts_per_turn()).unwrap_or(u32::MAX))
    }
}
