//! The TMC262 as the firmware sees it: what it is told, what it reports, and what follows from that (TMCM-1311 §6, §7).

use super::{AxisParameter, Tmcm1311};

/// The coolStep settings of the driver chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoolStep {
    /// SEMIN: below 32 times this reading the current rises; 0 switches coolStep off.
    pub semin: u8,
    /// SEMAX: from 32 times (SEMIN + SEMAX + 1) on the current falls.
    pub semax: u8,
    /// SEUP: how far it rises at a time.
    pub seup: u8,
    /// SEDN: how many readings it takes to fall.
    pub sedn: u8,
    /// SEIMIN: a quarter instead of half of the current scale is the lower limit.
    pub quarter_minimum: bool,
}

/// What the driver chip is told besides the coil currents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChipSettings {
    /// CS: 0 to 31 for 1/32 to 32/32 of the full-scale current.
    pub current_scale: u8,
    /// VSENSE: half the full-scale current.
    pub half_scale: bool,
    /// TOFF; 0 switches the bridges off.
    pub off_time: u8,
    /// SGT: −64 to 63.
    pub stallguard_threshold: i8,
    /// SFILT: a reading every four full steps.
    pub stallguard_filter: bool,
    /// coolStep.
    pub cool_step: CoolStep,
    /// DISS2G: no protection against shorts to ground.
    pub short_protection_disabled: bool,
}

/// What the driver chip reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriverStatus {
    /// The stallGuard2 reading, 0 to 1023; less means more load.
    pub stallguard: u16,
    /// SE: the current scale in use, which coolStep may have lowered.
    pub current_scale: u8,
    /// Status bits in the order of AP 208: stall, over-temperature, pre-warning, short A and B, open A and B, standstill.
    pub flags: u8,
}

impl Tmcm1311 {
    pub(super) fn chip_settings(&self) -> ChipSettings {
        let mut chip = self.prepared.chip;
        if self.switched_off || self.standstill.freewheels() || self.is_disabled() {
            chip.off_time = 0;
        }
        let fast = self.speed_pps() > self.kept_value(AxisParameter::CoolstepThresholdVelocity);
        if !(fast && self.is_open_loop()) {
            chip.cool_step.semin = 0;
        }
        chip.current_scale = self.motor_current(fast) / 8;
        chip
    }

    /// What flows now, scaled like AP 6: in closed loop and on the way there AP 6, in open loop AP 7 once the motor has stood for AP 214, AP 200 while the ramp changes its velocity,
    /// the run current otherwise. AP 6 is the absolute maximum (§6) of all but AP 200.
    fn motor_current(&self, fast: bool) -> u8 {
        use AxisParameter as P;
        let maximum = self.kept_value(P::MaxCurrent);
        let boost = self.kept_value(P::BoostCurrent);
        let current = if !self.is_open_loop() {
            maximum
        } else if self.is_powered_down() {
            self.kept_value(P::StandbyCurrent).min(maximum)
        } else if boost != 0 && self.ramp.is_changing_speed() {
            boost
        } else {
            self.run_current(fast).min(maximum)
        };
        u8::try_from(current).unwrap_or(0)
    }

    /// AP 6; below the coolStep threshold AP 183, once SEMIN, AP 182 and AP 183 are all set.
    fn run_current(&self, fast: bool) -> i32 {
        use AxisParameter as P;
        let slow_run = self.kept_value(P::CoolstepSlowRunCurrent);
        let applies = self.kept_value(P::CoolstepHysteresisStart) != 0
            && self.kept_value(P::CoolstepThresholdVelocity) != 0
            && slow_run != 0
            && !fast;
        if applies { slow_run } else { self.kept_value(P::MaxCurrent) }
    }

    /// Stops at once when stallGuard2 reads 0 above the velocity of AP 181; 0 there switches it off. The target becomes
    /// where the motor is, so that it does not start again. Returns whether it stopped.
    pub(super) fn stop_on_stall(&mut self) -> bool {
        let threshold_pps = self.kept_value(AxisParameter::StopOnStallVelocity);
        let stalls = self.closed().is_none()
            && threshold_pps > 0
            && self.speed_pps() > threshold_pps
            && self.sensed.driver.stallguard == 0;
        if stalls {
            self.stop_at_once();
        }
        stalls
    }

    fn speed_pps(&self) -> i32 {
        self.actual_velocity_pps().saturating_abs()
    }
}
