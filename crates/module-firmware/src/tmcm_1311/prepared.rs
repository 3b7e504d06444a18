//! What follows from the parameters alone, worked out when one is written and not in every control period.

use motion_control::closed_loop::current_scale::CurrentScaleSettings;

use super::{AxisParameter, ChipSettings, CoolStep};
use crate::values::Values;

/// Control periods in the unit of AP 120 and AP 121, 1 ms.
const TICKS_PER_MS: u32 = crate::TICKS_PER_MS as u32;

type Kept = Values<{ AxisParameter::COUNT }>;

/// Settings in the form in which they are used.
#[derive(Clone, Debug)]
pub(super) struct Prepared {
    /// For a driver chip whose bridges are on and whose motor is fast enough for coolStep; without the current.
    pub(super) chip: ChipSettings,
    /// Of the current regulation.
    pub(super) current: CurrentScaleSettings,
}

impl Prepared {
    pub(super) fn new(kept: &Kept) -> Self {
        Self { chip: chip_settings(kept), current: current_settings(kept) }
    }
}

fn chip_settings(kept: &Kept) -> ChipSettings {
    use AxisParameter as P;
    let value = |parameter: P| kept.get(parameter.index());
    let byte = |parameter| u8::try_from(value(parameter)).unwrap_or(0);
    let flag = |parameter| value(parameter) != 0;
    ChipSettings {
        current_scale: 0,
        half_scale: flag(P::Vsense),
        off_time: byte(P::ChopperOffTime),
        stallguard_threshold: i8::try_from(value(P::Stallguard2Threshold)).unwrap_or(0),
        stallguard_filter: flag(P::Stallguard2Filter),
        cool_step: CoolStep {
            semin: byte(P::CoolstepHysteresisStart),
            semax: byte(P::CoolstepHysteresis),
            seup: byte(P::CoolstepUpStep),
            sedn: byte(P::CoolstepDownStep),
            quarter_minimum: flag(P::CoolstepMinCurrent),
        },
        short_protection_disabled: flag(P::ShortProtectionDisable),
    }
}

/// AP 113, 114 and 116 to 121.
fn current_settings(kept: &Kept) -> CurrentScaleSettings {
    use AxisParameter as P;
    let value = |parameter: P| kept.get(parameter.index());
    let byte = |parameter| u8::try_from(value(parameter)).unwrap_or(u8::MAX);
    let magnitude = |parameter| value(parameter).unsigned_abs();
    CurrentScaleSettings {
        minimum: byte(P::CurrentScaleMin),
        maximum: byte(P::CurrentScaleMax),
        lower_error: magnitude(P::CurrentScaleLowerErrorLimit),
        upper_error: magnitude(P::CurrentScaleUpperErrorLimit),
        increment: byte(P::CurrentScaleIncrement),
        decrement: byte(P::CurrentScaleDecrement),
        increment_ticks: magnitude(P::CurrentScaleIncrementDelay).saturating_mul(TICKS_PER_MS),
        decrement_ticks: magnitude(P::CurrentScaleDecrementDelay).saturating_mul(TICKS_PER_MS),
    }
}
