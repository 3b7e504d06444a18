//! I²t monitoring: counts and flags, and leaves the current alone (TMCM-1311 §6, AP 25 to 29; TMCM-1640 §9; decision).

use super::{AxisParameter, Tmcm1311};
use crate::{TICKS_PER_MS, values::Values};

/// A² · ms in mA² · ticks, and twice that: half the sum of two phase currents squared is the square of their RMS value.
const SQUARES_PER_A2_MS: u64 = 2 * 1_000_000 * TICKS_PER_MS;

/// AP 25 in ticks.
pub(super) fn window_ticks(kept: &Values<{ AxisParameter::COUNT }>) -> u64 {
    let window_ms = kept.get(AxisParameter::ThermalWindingTimeConstant.index());
    u64::from(window_ms.cast_unsigned()) * TICKS_PER_MS
}

impl Tmcm1311 {
    /// One control period with the coil currents as they are.
    pub(super) fn watch_i2t(&mut self) {
        if self.i2t.tick(self.current_square(), self.i2t_limit()) {
            let counter = AxisParameter::I2tExceedCounter.index();
            self.kept.set(counter, self.kept.get(counter).wrapping_add(1));
        }
    }

    /// Control periods until something can be read that cannot be read now.
    pub(super) fn quiet_i2t(&self) -> u64 {
        self.i2t.quiet_ticks(self.current_square(), self.i2t_limit())
    }

    pub(super) fn skip_i2t(&mut self, ticks: u64) {
        self.i2t.skip(ticks, self.current_square(), self.i2t_limit());
    }

    /// AP 27 in A² · ms, unsigned.
    pub(super) fn i2t_sum(&self) -> i32 {
        u32::try_from(self.i2t.sum() / SQUARES_PER_A2_MS).unwrap_or(u32::MAX).cast_signed()
    }

    /// The largest sum that reads no more than AP 26.
    fn i2t_limit(&self) -> u64 {
        let limit = u64::from(self.kept_value(AxisParameter::I2tLimit).cast_unsigned());
        (limit + 1) * SQUARES_PER_A2_MS - 1
    }

    /// The square of AP 150, unrounded: twice that of the RMS current.
    fn current_square(&self) -> u32 {
        let [a, b] = self.sensed.coil_currents_ma.map(|current_ma| u32::from(current_ma.unsigned_abs()));
        a * a + b * b
    }
}
