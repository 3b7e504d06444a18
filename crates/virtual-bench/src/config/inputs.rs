//! `[module.inputs]`: what is connected to a module's inputs from the start.

use std::collections::BTreeMap;

use super::error::ConfigError;
use super::pins::{self, ANALOG_MAX};
use super::section::Section;
use super::switches::SwitchesConfig;
use crate::ModuleKind;

/// Levels of a module's inputs; inputs that are not named are open: they read 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputsConfig {
    /// Digital inputs by number, `true` = high.
    pub digital: BTreeMap<u8, bool>,
    /// Analogue inputs by number: 0 to 4095 for 0 to 10 V.
    pub analog: BTreeMap<u8, u16>,
}

/// Reads the section. Some of the `switches` may already drive inputs.
pub(super) fn read(
    mut section: Section<'_, '_>,
    kind: ModuleKind,
    switches: &SwitchesConfig,
) -> InputsConfig {
    let pins = pins::of(kind);
    let mut inputs = InputsConfig::default();
    for (number, key) in pins.inputs.iter().zip(pins.input_keys) {
        if let Some(level) = section.integer(key, &(0..=1)) {
            inputs.digital.insert(*number, level == 1);
        }
        if let Some(switch) = pins::switch_at(kind, switches, *number)
            && let Some(span) = section.key_span(key)
        {
            let switch = switch.word();
            let help = format!("leave out one of the two; [[event]] can set fault.switch_{switch}");
            let error = ConfigError::new(span, format!("{key} is wired to the {switch} switch"));
            section.complain(error.with_help(help));
        }
    }
    for (number, key) in pins.analog.iter().zip(pins.analog_keys) {
        let reading = section.integer(key, &(0..=i64::from(ANALOG_MAX)));
        if let Some(reading) = reading.and_then(|reading| u16::try_from(reading).ok()) {
            inputs.analog.insert(*number, reading);
        }
    }
    section.finish();
    inputs
}
