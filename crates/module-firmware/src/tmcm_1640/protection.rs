//! What switches the power stage off, and what AP 156 says about it (§5, §8, §9).

use super::{AxisParameter, RegulationMode, Tmcm1640};
use crate::{TICKS_PER_MS, values::Values};

/// Below this the supply is too low for the motor (decision).
const UNDERVOLTAGE_DV: u16 = 100;

/// With AP 245 set the stage is off above the first, until the second (decision).
const OVERVOLTAGE_DV: u16 = 300;
const OVERVOLTAGE_OVER_DV: u16 = 290;

/// The converter's readings at 100 °C, where the stage goes off, and at 95 °C, where it comes on again (decision; chapter 8).
const HOT_ADC: u16 = 2827;
const HOT_OVER_ADC: u16 = 2715;

/// A² · ms in mA² · ticks: the motor's current counts as it is (§9).
const SQUARES_PER_A2_MS: u64 = 1_000_000 * TICKS_PER_MS;

/// An eighth more than AP 6 is too much; a regulator overshoots a little (decision).
const OVERCURRENT_MARGIN: i32 = 8;

/// AP 25 in ticks.
pub(super) fn window_ticks(kept: &Values<{ AxisParameter::COUNT }>) -> u64 {
    let window_ms = kept.get(AxisParameter::ThermalWindingTimeConstant.index());
    u64::from(window_ms.cast_unsigned()) * TICKS_PER_MS
}

/// A driver that reported an error stays off for so long, which clears what it latched, and is tried again: 100 ms (decision).
const RETRY_TICKS: u32 = 100 * TICKS_PER_MS as u32;

/// What lasts until its cause has passed by a margin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Protection {
    overvoltage: bool,
    overtemperature: bool,
    /// Control periods until the driver is tried again.
    retry_ticks: u32,
}

impl Tmcm1640 {
    /// A control period of watching.
    pub(super) fn watch(&mut self) {
        let voltage_dv = self.sensed.supply_voltage_dv;
        let limit_dv = if self.protection.overvoltage { OVERVOLTAGE_OVER_DV } else { OVERVOLTAGE_DV };
        let protects = self.kept_value(AxisParameter::OvervoltageProtection) != 0;
        self.protection.overvoltage = protects && voltage_dv > limit_dv;
        let limit = if self.protection.overtemperature { HOT_OVER_ADC } else { HOT_ADC };
        self.protection.overtemperature = self.sensed.driver_temperature_adc >= limit;
        let left = self.protection.retry_ticks.saturating_sub(1);
        self.protection.retry_ticks = if self.sensed.driver_error { RETRY_TICKS } else { left };
        if self.i2t.tick(self.current_square(), self.i2t_limit()) {
            let counter = AxisParameter::I2tExceedCounter.index();
            self.kept.set(counter, self.kept.get(counter).wrapping_add(1));
        }
    }

    /// Whether the power stage may be on.
    pub(super) fn may_drive(&self) -> bool {
        self.kept_value(AxisParameter::EnableDriver) != 0
            && self.sensed.supply_voltage_dv >= UNDERVOLTAGE_DV
            && !self.protection.overvoltage
            && !self.protection.overtemperature
            && self.protection.retry_ticks == 0
            && !self.i2t.is_flagged()
    }

    /// AP 156.
    pub(super) fn status_flags(&self) -> i32 {
        let halted =
            self.velocity_rpm().saturating_abs() < self.kept_value(AxisParameter::MotorHaltedVelocity);
        let bits = [
            (0, self.is_overcurrent()),
            (1, self.sensed.supply_voltage_dv < UNDERVOLTAGE_DV),
            (2, self.protection.overvoltage),
            (3, self.protection.overtemperature),
            (4, halted),
            (5, self.halls.error().is_some()),
            (6, self.protection.retry_ticks > 0),
            (9, self.mode == RegulationMode::Velocity),
            (10, self.mode == RegulationMode::Position),
            (11, self.mode == RegulationMode::Torque),
            (14, self.regulation.position_reached),
            (17, self.i2t.is_flagged()),
        ];
        bits.into_iter().fold(0, |word, (bit, set)| word | (i32::from(set) << bit))
    }

    fn is_overcurrent(&self) -> bool {
        let largest_ma = self.max_current_ma();
        self.current_amplitude_ma() > largest_ma.saturating_add(largest_ma / OVERCURRENT_MARGIN)
    }

    /// AP 27 in A² · ms, unsigned.
    pub(super) fn i2t_sum(&self) -> i32 {
        u32::try_from(self.i2t.sum() / SQUARES_PER_A2_MS).unwrap_or(u32::MAX).cast_signed()
    }

    /// The largest sum that reads no more than AP 26.
    pub(super) fn i2t_limit(&self) -> u64 {
        let limit = u64::from(self.kept_value(AxisParameter::I2tLimit).cast_unsigned());
        (limit + 1) * SQUARES_PER_A2_MS - 1
    }

    /// The square of the motor's current.
    pub(super) fn current_square(&self) -> u32 {
        self.current_amplitude_ma().unsigned_abs().saturating_pow(2)
    }
}
