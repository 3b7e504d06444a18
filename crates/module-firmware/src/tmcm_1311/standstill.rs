//! How long the motor has been standing, and what follows for its current (TMCM-1311 §6, AP 7, 204 and 214).

use super::{AxisParameter, Tmcm1311};
use crate::{TICKS_PER_MS, TICKS_PER_SECOND};

/// The unit of AP 214: 10 ms.
const POWER_DOWN_UNIT: u64 = TICKS_PER_SECOND / 100;

/// Since when the motor stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Standstill {
    /// Whole control periods at rest since it stopped or was last told to move.
    ticks: u64,
    /// AP 204 elapsed: the current is cut until the motor is told to move, or moves.
    freewheels: bool,
}

impl Standstill {
    pub(super) fn freewheels(self) -> bool {
        self.freewheels
    }

    pub(super) fn skip(&mut self, ticks: u64) {
        self.ticks = self.ticks.saturating_add(ticks);
    }
}

impl Tmcm1311 {
    /// Before a control period moves the ramp: cuts the current where it is time to.
    pub(super) fn freewheel_in_time(&mut self) {
        self.standstill.freewheels |=
            self.freewheeling_delay().is_some_and(|delay| self.standstill.ticks >= delay);
    }

    /// After the ramp had its control period, and moved or not: whether the motor was at rest throughout. Where it was not, both delays begin
    /// anew; it may have started without a motion command, where a target stood and AP 4 was 0.
    pub(super) fn rested(&mut self, moved: bool) -> bool {
        // A search turns round and goes on.
        let stands = !moved && self.ramp.is_standing() && !self.ramp.is_changing_speed();
        let rested = stands && self.search.is_none();
        if !rested {
            self.standstill = Standstill::default();
        }
        rested
    }

    /// A motion command gives the motor its current back and begins both delays anew, even where it stands already.
    pub(super) fn end_standstill(&mut self) {
        self.standstill = Standstill::default();
    }

    /// Whether AP 7 flows: AP 214 has elapsed, unless step/direction mode has another reason.
    pub(super) fn is_powered_down(&self) -> bool {
        let rested = self.standstill.ticks >= self.power_down_delay();
        self.enable_selects_standby() || (rested && self.rest_sets_current())
    }

    /// Control periods at rest until one of the delays elapses.
    pub(super) fn quiet_standstill(&self) -> u64 {
        let delays = [Some(self.power_down_delay()), self.freewheeling_delay()];
        let left = delays.into_iter().flatten().filter_map(|delay| delay.checked_sub(self.standstill.ticks));
        left.min().unwrap_or(u64::MAX)
    }

    fn power_down_delay(&self) -> u64 {
        u64::from(self.kept_value(AxisParameter::PowerDownDelay).unsigned_abs()) * POWER_DOWN_UNIT
    }

    /// None = never: AP 204 is 0, or step/direction mode says what flows.
    fn freewheeling_delay(&self) -> Option<u64> {
        let delay_ms = self.kept_value(AxisParameter::FreewheelingDelay).unsigned_abs();
        (delay_ms != 0 && self.rest_sets_current()).then(|| u64::from(delay_ms) * TICKS_PER_MS)
    }
}
