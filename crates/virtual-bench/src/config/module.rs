//! `[[module]]`: a module with everything connected to it.

use core::ops::Range;

use motor_physics::supply::SupplyParameters;

use super::encoder::{self, EncoderConfig};
use super::error::ConfigError;
use super::halls::{self, HallsConfig};
use super::inputs::{self, InputsConfig};
use super::load::{self, LoadConfig};
use super::motor::{self, MotorConfig};
use super::parse_setting::is_reserved;
use super::quantity;
use super::section::{Section, Table};
use super::step_dir::{self, StepDirConfig};
use super::stiffness;
use super::suggest;
use super::supply::{self, SupplyFigures};
use super::switches::{self, SwitchesConfig};
use crate::ModuleKind;
use bench_hardware::MotorFamily;

/// Temperature of a room (chosen).
const ROOM_C: f64 = 25.0;

/// A module and what is connected to it.
#[derive(Clone, Debug, PartialEq)]
pub struct ModuleConfig {
    /// What it is.
    pub kind: ModuleKind,
    /// What the bench calls it: letters, digits, `_` and `-`, a letter first; different from every other.
    pub name: String,
    /// Its address: the serial one (GP 66) and, where it has CAN, its CAN identifier (GP 71). Beats what the EEPROM says, and
    /// is beaten by the command line. `None`: the EEPROM's.
    pub address: Option<u8>,
    /// Instructions of a stand-alone program that a control period of 50 µs executes, 1 to 1000 (decision: 1).
    pub instructions_per_tick: u16,
    /// Ambient temperature, -55 to 150 °C.
    pub temperature_c: f64,
    /// What it runs on.
    pub supply: SupplyParameters,
    /// What it drives.
    pub motor: MotorConfig,
    /// What the motor turns.
    pub load: LoadConfig,
    /// What it sees of the shaft.
    pub encoder: EncoderConfig,
    /// Switches along the travel.
    pub switches: SwitchesConfig,
    /// What is connected to its inputs.
    pub inputs: InputsConfig,
    /// What is connected to its step/direction connector. A TMCM-1640 has none.
    pub step_dir: StepDirConfig,
    /// The hall sensors in its motor. A TMCM-1311 does not look at them.
    pub halls: HallsConfig,
}

impl ModuleConfig {
    /// A module as it stands on the default bench.
    #[must_use]
    pub fn default_for(kind: ModuleKind, name: &str) -> Self {
        Self {
            kind,
            name: name.to_owned(),
            address: None,
            instructions_per_tick: 1,
            temperature_c: ROOM_C,
            supply: supply::default_for(kind),
            motor: MotorConfig::default_for(kind),
            load: LoadConfig::default_for(kind),
            encoder: EncoderConfig::default_for(kind),
            switches: SwitchesConfig::default(),
            inputs: InputsConfig::default(),
            step_dir: StepDirConfig::default(),
            halls: HallsConfig::default(),
        }
    }
}

/// What a module without a name is called, by its place.
pub(super) fn default_name(index: usize) -> String {
    format!("m{}", index + 1)
}

/// What the file says for all modules.
#[derive(Clone, Copy, Default)]
pub(super) struct Common {
    pub(super) supply: SupplyFigures,
    pub(super) temperature_c: Option<f64>,
}

/// Reads all modules.
pub(super) fn read_all(
    tables: Vec<Table<'_>>,
    common: Common,
    errors: &mut Vec<ConfigError>,
) -> Vec<ModuleConfig> {
    let mut modules: Vec<ModuleConfig> = Vec::new();
    for (index, Table { table, span }) in tables.into_iter().enumerate() {
        let section = Section::new(table, "[[module]]", span.clone(), errors);
        let (module, name_span) = read(section, &default_name(index), common);
        if modules.iter().any(|other| other.name == module.name) {
            let message = format!("two modules are called \"{}\"", module.name);
            errors.push(
                ConfigError::new(name_span.unwrap_or(span), message)
                    .with_help("a module without a name is m1, m2 and so on by its place in the file"),
            );
        }
        modules.push(module);
    }
    modules
}

fn read(
    mut section: Section<'_, '_>,
    default_name: &str,
    common: Common,
) -> (ModuleConfig, Option<Range<usize>>) {
    // What else is wrong can be found best by going on with some kind.
    let kind = read_kind(&mut section).unwrap_or(ModuleKind::Tmcm1311);
    let name = section.text("name");
    let name_span = name.as_ref().map(|(_, span)| span.clone());
    let name = name.and_then(|(name, span)| check_name(name, span, &mut section)).unwrap_or(default_name);
    let mut module = ModuleConfig::default_for(kind, name);
    module.address = read_address(&mut section, kind);
    let instructions = section.integer("instructions_per_tick", &(1..=1000));
    module.instructions_per_tick = instructions.and_then(|count| u16::try_from(count).ok()).unwrap_or(1);
    let temperature_c = section.number("temperature_c", &quantity::TEMPERATURE).or(common.temperature_c);
    module.temperature_c = temperature_c.unwrap_or(ROOM_C);
    let supply = section.section("supply", "module.supply").map(SupplyFigures::read).unwrap_or_default();
    module.supply = supply.over(common.supply.over(module.supply));
    read_parts(&mut section, &mut module);
    if let Some((message, help)) = stiffness::too_fast(&module) {
        section.complain_here(message, Some(help));
    }
    section.finish();
    (module, name_span)
}

/// A TMCM-1076 is always module 1: it has no global parameters.
fn read_address(section: &mut Section<'_, '_>, kind: ModuleKind) -> Option<u8> {
    let span = section.key_span("address");
    let address = section.integer("address", &(0..=255)).and_then(|address| u8::try_from(address).ok())?;
    if let Some(span) = span.filter(|_| address != 1 && !kind.has_settable_address()) {
        let message = format!("the address of a {} is 1 and cannot be changed", kind.spec().id);
        section.complain(ConfigError::new(span, message).with_help("leave out address"));
        return None;
    }
    Some(address)
}

fn read_parts(section: &mut Section<'_, '_>, module: &mut ModuleConfig) {
    let kind = module.kind;
    if let Some(motor) = section.section("motor", "module.motor").and_then(|motor| motor::read(motor, kind)) {
        module.motor = motor;
    }
    if let Some(load) = section.section("load", "module.load") {
        module.load = load::read(load, kind);
    }
    if !kind.has_sensors() {
        refuse(section, "encoder", kind, "encoder");
        refuse(section, "switches", kind, "switches");
    }
    if let Some(encoder) = section.section("encoder", "module.encoder").filter(|_| kind.has_sensors()) {
        module.encoder = encoder::read(encoder, kind);
    }
    if let Some(switches) = section.section("switches", "module.switches").filter(|_| kind.has_sensors()) {
        module.switches = switches::read(switches, kind);
    }
    if let Some(inputs) = section.section("inputs", "module.inputs") {
        module.inputs = inputs::read(inputs, kind, &module.switches);
    }
    read_family_parts(section, module);
}

/// What only modules for one family of motors have.
fn read_family_parts(section: &mut Section<'_, '_>, module: &mut ModuleConfig) {
    let kind = module.kind;
    match kind.motor() {
        MotorFamily::Stepper => {
            if let Some(step_dir) = section.section("step_dir", "module.step_dir") {
                module.step_dir = step_dir::read(step_dir, kind);
            }
            refuse(section, "halls", kind, "hall sensors");
        }
        MotorFamily::Brushless => {
            if let Some(halls) = section.section("halls", "module.halls") {
                module.halls = halls::read(halls);
            }
            refuse(section, "step_dir", kind, "step/direction connector");
        }
    }
}

/// Complains about a section for something that a module does not have.
fn refuse(section: &mut Section<'_, '_>, key: &'static str, kind: ModuleKind, what: &str) {
    if let Some(span) = section.key_span(key) {
        section.entry(key);
        let message = format!("the {} has no {what}", kind.spec().id);
        section.complain(ConfigError::new(span, message).with_help(format!("leave out [module.{key}]")));
    }
}

fn read_kind(section: &mut Section<'_, '_>) -> Option<ModuleKind> {
    let kinds: Vec<&str> = ModuleKind::ALL.iter().map(|kind| kind.spec().id).collect();
    if section.key_span("kind").is_none() {
        section
            .complain_here("[[module]] lacks kind", Some(format!("kind = \"{}\"", kinds.join("\" or \""))));
    }
    let (name, span) = section.text("kind")?;
    let message = match tmcl_tables::module_by_id(name).map(ModuleKind::try_from) {
        Ok(Ok(kind)) => return Some(kind),
        Ok(Err(unknown)) => unknown.to_string(),
        Err(_) => format!("unknown module \"{name}\""),
    };
    section.complain(ConfigError::new(span, message).with_help(suggest::help(name, &kinds)));
    None
}

fn check_name<'t>(name: &'t str, span: Range<usize>, section: &mut Section<'_, '_>) -> Option<&'t str> {
    let letters = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
    let well_formed =
        name.starts_with(|letter: char| letter.is_ascii_alphabetic()) && name.chars().all(letters);
    if !well_formed {
        let error = ConfigError::new(span, format!("\"{name}\" is no name for a module"));
        section.complain(error.with_help("a letter first, then letters, digits, _ and -"));
        return None;
    }
    if is_reserved(name) {
        let error = ConfigError::new(span, format!("a module cannot be called \"{name}\""));
        section.complain(error.with_help("names of signals and settings begin with this word"));
        return None;
    }
    Some(name)
}
