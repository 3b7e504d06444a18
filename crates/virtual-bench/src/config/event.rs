//! `[[event]]`: what happens on the bench at a given instant.

use core::ops::Range;

use toml::de::{DeTable, DeValue};

use super::BenchConfig;
use super::error::ConfigError;
use super::instant;
use super::parse_setting::{Part, SettingError, SettingValue, parse_setting};
use super::section::{self, Entry, Section, Table};
use bench_hardware::Setting;

/// What happens at an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When, in nanoseconds since the bench was switched on.
    pub at_ns: u64,
    /// What, each with the place of the module it happens to, in this order.
    pub settings: Vec<(usize, Setting)>,
}

/// Reads all events of a bench that is complete but for them. They come sorted by time, and at the same instant in the
/// order of the file.
pub(super) fn read_all(
    tables: Vec<Table<'_>>,
    bench: &BenchConfig,
    errors: &mut Vec<ConfigError>,
) -> Vec<Event> {
    let mut events = Vec::new();
    for Table { table, span } in tables {
        let mut section = Section::new(table, "[[event]]", span, errors);
        let at_ns = read_instant(&mut section);
        let settings = read_settings(&mut section, bench);
        section.finish();
        if let Some(at_ns) = at_ns {
            events.push(Event { at_ns, settings });
        }
    }
    events.sort_by_key(|event| event.at_ns);
    events
}

fn read_instant(section: &mut Section<'_, '_>) -> Option<u64> {
    let Some(entry) = section.entry("at") else {
        section.complain_here("[[event]] lacks at", Some("at = \"1.5s\"".to_owned()));
        return None;
    };
    let instant = match entry.get_ref() {
        DeValue::String(text) => instant::parse(text),
        DeValue::Integer(_) | DeValue::Float(_) => {
            section::number("at", entry).map_or_else(|error| Err(error.message), instant::from_seconds)
        }
        _ => Err("at must be an instant: \"1.5s\", \"200ms\", \"50us\" or a number of seconds".to_owned()),
    };
    instant.map_err(|message| section.complain(ConfigError::new(entry.span(), message))).ok()
}

fn read_settings(section: &mut Section<'_, '_>, bench: &BenchConfig) -> Vec<(usize, Setting)> {
    const EXAMPLE: &str = "set = { \"m1.load.torque_nm\" = 0.4 }";
    let Some(entry) = section.entry("set") else {
        section.complain_here("[[event]] lacks set", Some(EXAMPLE.to_owned()));
        return Vec::new();
    };
    let mut leaves = Vec::new();
    match entry.get_ref() {
        DeValue::Table(table) => flatten(table, "", &mut leaves),
        _ => section.complain(section::wrong_type("set", "a table of settings", entry).with_help(EXAMPLE)),
    }
    leaves.sort_by_key(|leaf| leaf.name_span.start);
    let mut settings = Vec::new();
    for leaf in leaves {
        match leaf.read(bench) {
            Ok(setting) => settings.extend(setting),
            Err(error) => section.complain(error),
        }
    }
    settings
}

/// A setting as it stands in the file.
struct Leaf<'t> {
    name: String,
    name_span: Range<usize>,
    entry: Entry<'t>,
}

impl Leaf<'_> {
    fn read(&self, bench: &BenchConfig) -> Result<Vec<(usize, Setting)>, ConfigError> {
        let value = match self.entry.get_ref() {
            DeValue::String(text) => SettingValue::Text(text),
            DeValue::Integer(_) | DeValue::Float(_) => {
                SettingValue::Number(section::number(&self.name, self.entry)?)
            }
            _ => return Err(section::wrong_type(&self.name, "a number or text in quotes", self.entry)),
        };
        parse_setting(bench, &self.name, value).map_err(|error| self.locate(error))
    }

    fn locate(&self, error: SettingError) -> ConfigError {
        let span = match error.part {
            Part::Name => self.name_span.clone(),
            Part::Value => self.entry.span(),
        };
        ConfigError { message: error.message, span, help: error.help }
    }
}

/// Collects the settings of a table. `"m1.load.torque_nm" = 0.4` and `m1.load.torque_nm = 0.4` mean the same, though the
/// latter are three tables to TOML.
fn flatten<'t>(table: &'t DeTable<'t>, prefix: &str, leaves: &mut Vec<Leaf<'t>>) {
    for (key, entry) in table {
        let name = format!("{prefix}{}", key.get_ref());
        match entry.get_ref() {
            // No name has more than four parts; what is deeper is reported as one.
            DeValue::Table(inner) if prefix.matches('.').count() < 4 => {
                flatten(inner, &format!("{name}."), leaves);
            }
            _ => leaves.push(Leaf { name, name_span: key.span(), entry }),
        }
    }
}
