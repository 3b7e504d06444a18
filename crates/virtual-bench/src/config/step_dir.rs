//! `[module.step_dir]`: what is connected to the step/direction connector from the start.

use core::ops::RangeInclusive;

use super::error::ConfigError;
use super::quantity;
use super::section::Section;
use crate::ModuleKind;

/// How many pulses a source may be told to give.
pub(super) const PULSES: RangeInclusive<u32> = 0..=u32::MAX;

/// A pulse source on STEP and DIR, and the level of ENABLE.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepDirConfig {
    /// Pulses a second, -1 000 000 to 1 000 000; positive is to the right, 0 is none.
    pub frequency_hz: f64,
    /// How fast the frequency changes, from 0 at the start and in time for the last pulse, 0 to 1 000 000 000 Hz/s; 0 = at
    /// once.
    pub acceleration_hz_per_s: f64,
    /// How many pulses it gives before it falls silent; `None`: it never does.
    pub pulses: Option<u32>,
    /// ENABLE of a TMCM-1311 is active; it is not while nothing is connected (decision). A TMCM-1076's is an input.
    pub enabled: bool,
}

/// Reads the section.
pub(super) fn read(mut section: Section<'_, '_>, kind: ModuleKind) -> StepDirConfig {
    let pulses = section.integer("pulses", &(i64::from(*PULSES.start())..=i64::from(*PULSES.end())));
    let step_dir = StepDirConfig {
        frequency_hz: section.number("frequency_hz", &quantity::PULSE_FREQUENCY).unwrap_or(0.0),
        acceleration_hz_per_s: section
            .number("acceleration_hz_per_s", &quantity::PULSE_ACCELERATION)
            .unwrap_or(0.0),
        pulses: pulses.and_then(|pulses| u32::try_from(pulses).ok()),
        enabled: read_enable(&mut section, kind),
    };
    section.finish();
    step_dir
}

/// ENABLE is an input of a TMCM-1076, with the polarity of a pin.
fn read_enable(section: &mut Section<'_, '_>, kind: ModuleKind) -> bool {
    if kind == ModuleKind::Tmcm1076
        && let Some(span) = section.key_span("enable")
    {
        section.entry("enable");
        let message = format!("the {} has ENABLE among its inputs", kind.spec().id);
        section.complain(ConfigError::new(span, message).with_help(ENABLE_HELP));
        return false;
    }
    section.integer("enable", &(0..=1)) == Some(1)
}

/// Where ENABLE is, and what it does.
pub(super) const ENABLE_HELP: &str = "it is in_1 of [module.inputs], input.1 elsewhere; 0 powers the motor";
