//! The bench file: which modules stand on the bench, what they drive, how they are wired, and what happens to them.
//!
//! [`parse`] takes the text of a `bench.toml` and gives plain values, or everything that is wrong with it, each with its
//! place in the text and what is allowed there. [`parse_setting()`] reads the same names that events use, one at a time.
//! `docs/bench-file.md` is the reference for people.
//!
//! Figures come as the types of `motor-physics` that take them. This module must never know files or firmware.

mod bus;
mod encoder;
mod error;
mod event;
mod halls;
mod inputs;
mod instant;
mod load;
mod module;
mod motor;
mod parse_fault;
mod parse_setting;
mod pins;
mod quantity;
mod section;
mod step_dir;
mod stiffness;
pub(crate) mod suggest;
mod supply;
mod switches;
#[cfg(test)]
mod tests;
mod wire;

pub use bench_hardware::{Coil, Contact, EncoderLine, HallSensor, Phase, Power, Setting, SwitchName};
pub use bus::{BusConfig, Interface};
pub use encoder::EncoderConfig;
pub use error::ConfigError;
pub use event::Event;
pub use halls::HallsConfig;
pub use inputs::InputsConfig;
pub use load::LoadConfig;
pub use module::ModuleConfig;
pub use motor::{BldcConfig, MotorConfig};
pub use parse_setting::{Part, SETTINGS, SettingError, SettingValue, parse_setting};
pub use step_dir::{RecordedLevels, StepDirConfig};
pub use switches::SwitchesConfig;
pub use wire::{Wire, WireEnd};

use toml::de::DeTable;

use crate::ModuleKind;
use module::Common;
use section::Section;
use supply::SupplyFigures;

/// A whole bench.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchConfig {
    /// The modules, by their place, the number in [`ModuleId`](crate::ModuleId).
    pub modules: Vec<ModuleConfig>,
    /// The wires between their pins.
    pub wires: Vec<Wire>,
    /// What happens, sorted by time.
    pub events: Vec<Event>,
    /// What joins the modules.
    pub bus: BusConfig,
}

impl BenchConfig {
    /// The default bench: one module, `m1`, with nothing on its inputs and nothing ever happening (decision: the default
    /// bench).
    #[must_use]
    pub fn default_for(kind: ModuleKind) -> Self {
        Self::default_of(&[kind])
    }

    /// The default bench with these modules, `m1`, `m2` and so on.
    #[must_use]
    pub fn default_of(kinds: &[ModuleKind]) -> Self {
        let module = |(index, kind): (usize, &ModuleKind)| {
            ModuleConfig::default_for(*kind, &module::default_name(index))
        };
        Self {
            modules: kinds.iter().enumerate().map(module).collect(),
            wires: Vec::new(),
            events: Vec::new(),
            bus: BusConfig::default(),
        }
    }
}

/// Reads a bench file.
///
/// # Errors
/// Everything that is wrong with it, in the order of the text. A text that is not TOML yields the errors of form only, the
/// first of each line: what a half-read file means is anybody's guess.
pub fn parse(text: &str) -> Result<BenchConfig, Vec<ConfigError>> {
    let (table, malformed) = DeTable::parse_recoverable(text);
    let mut errors: Vec<ConfigError> = malformed.iter().map(|error| in_form(error, text)).collect();
    if !errors.is_empty() {
        errors.sort_by_key(|error| error.span.start);
        errors.dedup_by_key(|error| error.line_column(text).0);
        return Err(errors);
    }
    let bench = read(table.get_ref(), &mut errors);
    errors.sort_by_key(|error| error.span.start);
    if errors.is_empty() { Ok(bench) } else { Err(errors) }
}

/// An error of form.
fn in_form(error: &toml::de::Error, text: &str) -> ConfigError {
    let span = error.span().unwrap_or(0..0);
    let end = span.end.min(text.len());
    ConfigError::new(span.start.min(end)..end, format!("not TOML: {}", error.message()))
}

fn read<'t>(table: &'t DeTable<'t>, errors: &mut Vec<ConfigError>) -> BenchConfig {
    let mut file = Section::new(table, "a bench file", 0..0, errors);
    let common = Common {
        supply: file.section("supply", "supply").map(SupplyFigures::read).unwrap_or_default(),
        temperature_c: file.number("temperature_c", &quantity::TEMPERATURE),
    };
    let bus = file.section("bus", "bus").map(bus::read).unwrap_or_default();
    let errors_before = file.errors().len();
    let modules = file.sections("module");
    if modules.is_empty() && file.errors().len() == errors_before {
        let kind = ModuleKind::ALL[0].spec().id;
        file.complain_here("a bench needs a module", Some(format!("add [[module]] and kind = \"{kind}\"")));
    }
    let (wires, events) = (file.sections("wire"), file.sections("event"));
    let errors = file.errors();
    let modules = module::read_all(modules, common, errors);
    let wires = wire::read_all(wires, &modules, errors);
    let mut bench = BenchConfig { modules, wires, events: Vec::new(), bus };
    bench.events = event::read_all(events, &bench, errors);
    file.finish();
    bench
}
