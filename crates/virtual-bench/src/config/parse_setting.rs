//! Changes to a running bench by name: `m1.load.torque_nm`, `supply.voltage_v`, `m2.fault.coil_open`.

use core::ops::{Range, RangeInclusive};

use super::BenchConfig;
use super::module::ModuleConfig;
use super::parse_fault::parse_fault;
use super::pins::{self, ANALOG_MAX};
use super::quantity::{self, Quantity};
use super::step_dir::{ENABLE_HELP, PULSES};
use super::suggest;
use super::wire::WireEnd;
use crate::ModuleKind;
use bench_hardware::MotorFamily;
use bench_hardware::{Power, Setting};

/// Words that names of settings begin with.
const SETTING_ROOTS: [&str; 8] =
    ["ain", "fault", "input", "load", "power", "step_dir", "supply", "temperature_c"];

/// Words that other names in the same namespace begin with.
const SIGNAL_ROOTS: [&str; 4] = ["eeprom", "output", "physical", "sensed"];

/// Whether names of signals or settings begin with a word, so that no module can be called so.
pub(super) fn is_reserved(word: &str) -> bool {
    SETTING_ROOTS.contains(&word) || SIGNAL_ROOTS.contains(&word)
}

/// What may be set; `N` stands for a number.
pub const SETTINGS: [&str; 26] = [
    "load.torque_nm",
    "load.inertia_kgm2",
    "load.friction_nm",
    "input.N",
    "ain.N",
    "step_dir.frequency_hz",
    "step_dir.acceleration_hz_per_s",
    "step_dir.pulses",
    "step_dir.enable",
    "supply.voltage_v",
    "temperature_c",
    "fault.encoder_line",
    "fault.coil_open",
    "fault.coil_short",
    "fault.phase_open",
    "fault.phase_short",
    "fault.hall_1",
    "fault.hall_2",
    "fault.hall_3",
    "fault.switch_left",
    "fault.switch_right",
    "fault.switch_home",
    "fault.board_temperature_c",
    "fault.dropped_steps",
    "fault.eeprom_cut",
    "power",
];

/// Settings that without a module's name hold for every module.
const COMMON: [&str; 2] = ["supply.voltage_v", "temperature_c"];

/// A value for a setting, before it is known what it must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingValue<'a> {
    /// A number.
    Number(f64),
    /// A word.
    Text(&'a str),
}

impl<'a> From<&'a str> for SettingValue<'a> {
    /// What somebody typed: a number if it reads as one.
    fn from(text: &'a str) -> Self {
        text.trim().parse().map_or(Self::Text(text.trim()), Self::Number)
    }
}

/// Why a setting was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct SettingError {
    /// Whether the name is wrong, or the value for it.
    pub part: Part,
    /// What is wrong and what is allowed.
    pub message: String,
    /// What might have been meant, or what there is to choose from.
    pub help: Option<String>,
}

/// A part of a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Its name.
    Name,
    /// Its value.
    Value,
}

impl SettingError {
    pub(super) fn name(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { part: Part::Name, message: message.into(), help: Some(help.into()) }
    }

    pub(super) fn value(message: impl Into<String>) -> Self {
        Self { part: Part::Value, message: message.into(), help: None }
    }
}

/// What `name = value` means on this bench: settings, each with the place of its module.
///
/// A name begins with a module's, `m1.load.torque_nm`. With a single module that may be left out; with several,
/// `supply.voltage_v` and `temperature_c` without it mean all of them. In all other cases it is one setting.
///
/// # Errors
/// [`SettingError`]: there is no such module, setting or pin, something else drives the pin, or the value is not allowed.
pub fn parse_setting(
    bench: &BenchConfig,
    name: &str,
    value: SettingValue<'_>,
) -> Result<Vec<(usize, Setting)>, SettingError> {
    let (indices, rest) = find_modules(&bench.modules, name)?;
    let settings = indices.map(|index| parse_for(bench, index, rest, value).map(|setting| (index, setting)));
    settings.collect()
}

/// Splits a name into the modules it is about and the rest.
fn find_modules<'n>(
    modules: &[ModuleConfig],
    name: &'n str,
) -> Result<(Range<usize>, &'n str), SettingError> {
    let (first, rest) = name.split_once('.').unwrap_or((name, ""));
    if let Some(index) = modules.iter().position(|module| module.name == first) {
        return Ok((index..index + 1, rest));
    }
    let names: Vec<&str> = modules.iter().map(|module| module.name.as_str()).collect();
    let begins_setting = |word: &str| SETTING_ROOTS.contains(&word);
    if begins_setting(rest.split('.').next().unwrap_or_default()) && !begins_setting(first) {
        return Err(SettingError::name(
            format!("there is no module \"{first}\""),
            suggest::help(first, &names),
        ));
    }
    match names.as_slice() {
        [] | [_] => Ok((0..1, name)),
        _ if COMMON.contains(&name) => Ok((0..modules.len(), name)),
        [one, ..] if begins_setting(first) => {
            let help = format!("for example {one}.{name}; modules: {}", names.join(", "));
            Err(SettingError::name(format!("{name} must say of which module"), help))
        }
        _ => Err(unknown(name, None)),
    }
}

fn parse_for(
    bench: &BenchConfig,
    index: usize,
    name: &str,
    value: SettingValue<'_>,
) -> Result<Setting, SettingError> {
    let Some(module) = bench.modules.get(index) else {
        return Err(SettingError::name("there is no module on the bench", "add a [[module]]"));
    };
    match name.split_once('.') {
        Some(("input", number)) => input(bench, index, module, number, value),
        Some(("ain", number)) => analog_input(module, number, value),
        Some(("step_dir", signal)) => parse_step_dir(module, signal, name, value),
        Some(("fault", fault)) => parse_fault(module, fault, name, value),
        _ => parse_plain(module, name, value),
    }
}

/// A complaint about a name of nothing that can be set: on a module for motors of one family, or on any.
pub(super) fn unknown(name: &str, family: Option<MotorFamily>) -> SettingError {
    let known = SETTINGS.into_iter().filter(|setting| is_of(setting, family));
    let known: Vec<&str> = known.collect();
    SettingError::name(format!("nothing called \"{name}\" can be set"), suggest::help(name, &known))
}

/// Whether a setting is one of a module for motors of this family.
fn is_of(setting: &str, family: Option<MotorFamily>) -> bool {
    const STEPPER_ONLY: [&str; 3] = ["step_dir.", "fault.coil_", "fault.dropped_steps"];
    const BRUSHLESS_ONLY: [&str; 2] = ["fault.phase_", "fault.hall_"];
    let others: &[&str] = match family {
        None => &[],
        Some(MotorFamily::Stepper) => &BRUSHLESS_ONLY,
        Some(MotorFamily::Brushless) => &STEPPER_ONLY,
    };
    !others.iter().any(|prefix| setting.starts_with(prefix))
}

fn parse_plain(module: &ModuleConfig, name: &str, value: SettingValue<'_>) -> Result<Setting, SettingError> {
    let number = |quantity: &Quantity| quantity_of(name, value, quantity);
    match name {
        "load.torque_nm" => number(&quantity::TORQUE).map(Setting::LoadTorqueNm),
        "load.inertia_kgm2" => number(&quantity::LOAD_INERTIA).map(Setting::LoadInertiaKgm2),
        "load.friction_nm" => number(&quantity::FRICTION).map(Setting::LoadFrictionNm),
        "supply.voltage_v" => number(&quantity::VOLTAGE).map(Setting::SupplyVoltageV),
        "temperature_c" => number(&quantity::TEMPERATURE).map(Setting::AmbientC),
        "power" => {
            let choices = [("off", Power::Off), ("on", Power::On), ("cycle", Power::Cycle)];
            choice(name, value, &choices).map(Setting::Power)
        }
        _ => Err(unknown(name, Some(module.kind.motor()))),
    }
}

fn parse_step_dir(
    module: &ModuleConfig,
    signal: &str,
    name: &str,
    value: SettingValue<'_>,
) -> Result<Setting, SettingError> {
    if module.kind.motor() != MotorFamily::Stepper {
        let message = format!("{} has no step/direction connector", module.name);
        return Err(SettingError::name(message, format!("it is a {}", module.kind.spec().id)));
    }
    match signal {
        "frequency_hz" => quantity_of(name, value, &quantity::PULSE_FREQUENCY).map(Setting::StepFrequencyHz),
        "acceleration_hz_per_s" => {
            quantity_of(name, value, &quantity::PULSE_ACCELERATION).map(Setting::StepAccelerationHzPerS)
        }
        "pulses" if value == SettingValue::Text("endless") => Ok(Setting::StepPulses(None)),
        "pulses" => whole(name, value, PULSES)
            .map(|pulses| Setting::StepPulses(Some(pulses)))
            .map_err(|error| SettingError { help: Some("or \"endless\"".to_owned()), ..error }),
        "enable" if module.kind == ModuleKind::Tmcm1076 => {
            let message = format!("{} has ENABLE among its inputs", module.name);
            Err(SettingError::name(message, ENABLE_HELP))
        }
        "enable" => whole(name, value, 0..=1).map(|level| Setting::StepEnable(level == 1)),
        _ => Err(unknown(name, Some(module.kind.motor()))),
    }
}

fn input(
    bench: &BenchConfig,
    index: usize,
    module: &ModuleConfig,
    number: &str,
    value: SettingValue<'_>,
) -> Result<Setting, SettingError> {
    let pins = pins::of(module.kind);
    let name = format!("input.{number}");
    let number = find_number(pins.inputs, number).ok_or_else(|| {
        let known = [pins::names("input", pins.inputs), pins::names("ain", pins.analog)];
        let known =
            known.iter().filter(|names| !names.is_empty()).map(String::as_str).collect::<Vec<_>>().join(", ");
        SettingError::name(format!("{} has no {name} to set", module.name), format!("allowed here: {known}"))
    })?;
    if bench.wires.iter().any(|wire| wire.to_module == index && wire.to == WireEnd::Input(number)) {
        let message = format!("{name} of {} is driven by a wire", module.name);
        return Err(SettingError::name(message, "set what drives the wire, or leave the [[wire]] out"));
    }
    if let Some(switch) = pins::switch_at(module.kind, &module.switches, number) {
        let switch = switch.word();
        let message = format!("{name} of {} is driven by its {switch} switch", module.name);
        let help = format!("fault.switch_{switch} = \"open\" or \"closed\" overrides the switch");
        return Err(SettingError::name(message, help));
    }
    whole(&name, value, 0..=1).map(|level| Setting::Input { number, high: level == 1 })
}

fn analog_input(
    module: &ModuleConfig,
    number: &str,
    value: SettingValue<'_>,
) -> Result<Setting, SettingError> {
    let pins = pins::of(module.kind);
    let name = format!("ain.{number}");
    if pins.analog.is_empty() {
        let message = format!("{} has no analogue inputs", module.name);
        return Err(SettingError::name(message, format!("it is a {}", module.kind.spec().id)));
    }
    let number = find_number(pins.analog, number).ok_or_else(|| {
        let known = pins::names("ain", pins.analog);
        SettingError::name(format!("{} has no {name} to set", module.name), format!("allowed here: {known}"))
    })?;
    whole(&name, value, 0..=ANALOG_MAX).map(|reading| Setting::AnalogInput { number, reading })
}

fn find_number(numbers: &[u8], text: &str) -> Option<u8> {
    numbers.iter().copied().find(|number| number.to_string() == text)
}

pub(super) fn quantity_of(
    name: &str,
    value: SettingValue<'_>,
    quantity: &Quantity,
) -> Result<f64, SettingError> {
    match value {
        SettingValue::Number(number) => quantity.check(name, number).map_err(SettingError::value),
        SettingValue::Text(text) => {
            Err(SettingError::value(format!("{name} must be a number, not \"{text}\"")))
        }
    }
}

/// A whole number of some type within bounds.
pub(super) fn whole<T>(
    name: &str,
    value: SettingValue<'_>,
    allowed: RangeInclusive<T>,
) -> Result<T, SettingError>
where
    T: Copy + PartialOrd + TryFrom<i64> + core::fmt::Display,
{
    let (low, high) = (allowed.start(), allowed.end());
    let wanted = format!("{name} must be a whole number from {low} to {high}");
    let number = match value {
        SettingValue::Number(number) => number,
        SettingValue::Text(text) => return Err(SettingError::value(format!("{wanted}, not \"{text}\""))),
    };
    // The cast saturates; NaN has no fraction that is 0.
    let exact = (libm::modf(number).0 == 0.0).then_some(number as i64);
    let found = exact.and_then(|exact| T::try_from(exact).ok()).filter(|found| allowed.contains(found));
    found.ok_or_else(|| SettingError::value(format!("{wanted}, not {number}")))
}

pub(super) fn choice<T: Copy>(
    name: &str,
    value: SettingValue<'_>,
    choices: &[(&str, T)],
) -> Result<T, SettingError> {
    let words: Vec<&str> = choices.iter().map(|(word, _)| *word).collect();
    let (found, help) = match value {
        SettingValue::Text(text) => (format!("\"{text}\""), suggest::help(text, &words)),
        SettingValue::Number(number) => (number.to_string(), suggest::help("", &words)),
    };
    let known = choices.iter().find(|(word, _)| value == SettingValue::Text(word));
    known.map(|(_, meaning)| *meaning).ok_or_else(|| SettingError {
        part: Part::Value,
        message: format!("{name} cannot be {found}"),
        help: Some(help),
    })
}
