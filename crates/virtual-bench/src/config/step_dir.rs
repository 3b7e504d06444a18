//! `[module.step_dir]`: what is connected to the step/direction connector from the start.

use core::ops::RangeInclusive;

use super::quantity;
use super::section::Section;

/// How many pulses a source may be told to give.
pub(super) const PULSES: RangeInclusive<u32> = 0..=u32::MAX;

/// A pulse source on STEP and DIR, and the level of ENABLE.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepDirConfig {
    /// Pulses a second, -1 000 000 to 1 000 000; positive is to the right, 0 is none.
    pub frequency_hz: f64,
    /// How many pulses it gives before it falls silent; `None`: it never does.
    pub pulses: Option<u32>,
    /// ENABLE is active; it is not while nothing is connected (decision).
    pub enabled: bool,
}

/// Reads the section.
pub(super) fn read(mut section: Section<'_, '_>) -> StepDirConfig {
    let pulses = section.integer("pulses", &(i64::from(*PULSES.start())..=i64::from(*PULSES.end())));
    let step_dir = StepDirConfig {
        frequency_hz: section.number("frequency_hz", &quantity::PULSE_FREQUENCY).unwrap_or(0.0),
        pulses: pulses.and_then(|pulses| u32::try_from(pulses).ok()),
        enabled: section.integer("enable", &(0..=1)) == Some(1),
    };
    section.finish();
    step_dir
}
