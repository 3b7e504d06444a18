//! `[module.step_dir]`: what is connected to the step/direction connector from the start.

use core::ops::RangeInclusive;

use toml::de::DeValue;

use super::error::ConfigError;
use super::quantity;
use super::section::{self, Entry, Section};
use crate::ModuleKind;

/// How many pulses a source may be told to give.
pub(super) const PULSES: RangeInclusive<u32> = 0..=u32::MAX;

/// A pulse source on STEP and DIR, and the level of ENABLE.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// What was recorded on STEP and DIR, in the order of time; instead of pulses at a frequency. A TMCM-1076 only.
    pub edges: Vec<RecordedLevels>,
}

/// The levels of STEP and DIR from an instant on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordedLevels {
    /// When, since the bench was switched on.
    pub at_ns: u64,
    /// STEP is high.
    pub step: bool,
    /// DIR is high.
    pub dir: bool,
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
        edges: read_edges(&mut section, kind),
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

/// What was recorded, `[[s, step, dir], ...]`.
fn read_edges(section: &mut Section<'_, '_>, kind: ModuleKind) -> Vec<RecordedLevels> {
    let Some(entry) = section.entry("edges") else { return Vec::new() };
    let span = section.key_span("edges").unwrap_or_else(|| entry.span());
    if kind != ModuleKind::Tmcm1076 {
        let message = format!("a {} counts whole pulses and takes no edges", kind.spec().id);
        section.complain(ConfigError::new(span, message).with_help("give it frequency_hz"));
        return Vec::new();
    }
    if section.key_span("frequency_hz").is_some() {
        section.complain(ConfigError::new(span, "edges and frequency_hz exclude each other"));
        return Vec::new();
    }
    let DeValue::Array(list) = entry.get_ref() else {
        section.complain(section::wrong_type("edges", "a list of levels, [[s, step, dir], ...]", entry));
        return Vec::new();
    };
    let mut edges: Vec<RecordedLevels> = Vec::new();
    for entry in list {
        match read_levels(entry, edges.last().map_or(0, |edge| edge.at_ns)) {
            Ok(levels) => edges.push(levels),
            Err(error) => section.complain(error),
        }
    }
    edges
}

fn read_levels(entry: Entry<'_>, before_ns: u64) -> Result<RecordedLevels, ConfigError> {
    let triple = entry.get_ref().as_array().filter(|triple| triple.len() == 3);
    let triple = triple.and_then(|triple| Some((triple.first()?, triple.get(1)?, triple.get(2)?)));
    let Some((at, step, dir)) = triple else {
        return Err(ConfigError::new(entry.span(), "levels must be three values, [s, step, dir]"));
    };
    let at_s = section::number("s", at)?;
    quantity::INSTANT.check("s", at_s).map_err(|message| ConfigError::new(at.span(), message))?;
    let at_ns = libm::round(at_s * 1e9) as u64;
    if at_ns < before_ns {
        return Err(ConfigError::new(at.span(), "the times of edges must ascend"));
    }
    let level = |name, entry| section::integer(name, entry, &(0..=1)).map(|level| level == 1);
    Ok(RecordedLevels { at_ns, step: level("step", step)?, dir: level("dir", dir)? })
}

/// Where ENABLE is, and what it does.
pub(super) const ENABLE_HELP: &str = "it is in_1 of [module.inputs], input.1 elsewhere; 0 powers the motor";
