//! `[[wire]]`: from one module's output to another's input.

use super::error::ConfigError;
use super::module::ModuleConfig;
use super::pins::{self, Pins};
use super::section::{Section, Table};
use super::step_dir::StepDirConfig;
use super::suggest;
use crate::ModuleKind;

/// A wire, from an output to an input that nothing else drives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wire {
    /// Whose output: the module's place on the bench.
    pub from_module: usize,
    /// Its port number.
    pub output: u8,
    /// Whose input: the module's place on the bench.
    pub to_module: usize,
    /// Which of its inputs.
    pub to: WireEnd,
}

/// Where a wire ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireEnd {
    /// At a digital input: its port number.
    Input(u8),
    /// At STEP of a TMCM-1076.
    Step,
    /// At DIR of a TMCM-1076.
    Dir,
}

impl WireEnd {
    fn name(self) -> String {
        match self {
            Self::Input(number) => format!("input.{number}"),
            Self::Step => "step".to_owned(),
            Self::Dir => "dir".to_owned(),
        }
    }
}

/// A module's pin.
#[derive(Clone, Copy)]
struct Pin {
    module: usize,
    number: u8,
}

/// Reads all wires between `modules`.
pub(super) fn read_all(
    tables: Vec<Table<'_>>,
    modules: &[ModuleConfig],
    errors: &mut Vec<ConfigError>,
) -> Vec<Wire> {
    let mut wires: Vec<Wire> = Vec::new();
    for Table { table, span } in tables {
        let mut section = Section::new(table, "[[wire]]", span, errors);
        let from = read_end(&mut section, "from", "output", |pins| pins.outputs, modules);
        let to = read_to(&mut section, modules);
        if let Some((module, to)) = to {
            check_free(&mut section, module, to, modules, &wires);
        }
        section.finish();
        if let (Some(from), Some((to_module, to))) = (from, to) {
            wires.push(Wire { from_module: from.module, output: from.number, to_module, to });
        }
    }
    wires
}

/// Reads where a wire ends: an input, or STEP or DIR of a module that follows pulses.
fn read_to(section: &mut Section<'_, '_>, modules: &[ModuleConfig]) -> Option<(usize, WireEnd)> {
    let known = section.text("to").and_then(|(text, _)| pulse_end(text, modules));
    known.or_else(|| {
        let pin = read_end(section, "to", "input", |pins| pins.inputs, modules)?;
        Some((pin.module, WireEnd::Input(pin.number)))
    })
}

/// `m1.step`, `m1.dir`; with a single module its name may be left out.
fn pulse_end(text: &str, modules: &[ModuleConfig]) -> Option<(usize, WireEnd)> {
    let (name, pin) = text.split_once('.').unwrap_or(("", text));
    let end = match pin {
        "step" => WireEnd::Step,
        "dir" => WireEnd::Dir,
        _ => return None,
    };
    let index = match modules {
        [_] if name.is_empty() => 0,
        _ => modules.iter().position(|module| module.name == name)?,
    };
    modules.get(index).filter(|module| module.kind == ModuleKind::Tmcm1076).map(|_| (index, end))
}

/// Reads one end, `m1.output.0`; with a single module `output.0` will do.
fn read_end(
    section: &mut Section<'_, '_>,
    key: &'static str,
    word: &str,
    numbers: fn(&Pins) -> &'static [u8],
    modules: &[ModuleConfig],
) -> Option<Pin> {
    if section.key_span(key).is_none() {
        let message = format!("[[wire]] lacks {key}");
        section.complain_here(
            message,
            Some(format!("{key} = \"m1.{word}.{}\"", if key == "to" { 1 } else { 0 })),
        );
    }
    let (text, span) = section.text(key)?;
    find_pin(text, word, numbers, modules)
        .map_err(|(message, help)| section.complain(ConfigError::new(span, message).with_help(help)))
        .ok()
}

fn find_pin(
    text: &str,
    word: &str,
    numbers: fn(&Pins) -> &'static [u8],
    modules: &[ModuleConfig],
) -> Result<Pin, (String, String)> {
    let parts: Vec<&str> = text.split('.').collect();
    let (index, number) = match (parts.as_slice(), modules) {
        ([pin, number], [_]) if *pin == word => (0, *number),
        ([name, pin, number], _) if *pin == word => {
            let names: Vec<&str> = modules.iter().map(|module| module.name.as_str()).collect();
            let index = names.iter().position(|known| known == name);
            let help = suggest::help(name, &names);
            (index.ok_or_else(|| (format!("there is no module \"{name}\""), help))?, *number)
        }
        _ => return Err((format!("\"{text}\" is no {word}"), format!("write \"MODULE.{word}.NUMBER\""))),
    };
    let numbers = modules.get(index).map(|module| (module, numbers(pins::of(module.kind))));
    let (module, numbers) =
        numbers.ok_or_else(|| (format!("\"{text}\" is no {word}"), "there is no module".to_owned()))?;
    let known = numbers.iter().copied().find(|known| known.to_string() == number);
    let help = || format!("allowed here: {}", pins::names(word, numbers));
    let number =
        known.ok_or_else(|| (format!("{} has no {word} {number} for wires", module.name), help()))?;
    Ok(Pin { module: index, number })
}

/// Complains if something else drives an input already.
fn check_free(
    section: &mut Section<'_, '_>,
    index: usize,
    to: WireEnd,
    modules: &[ModuleConfig],
    wires: &[Wire],
) {
    let Some(module) = modules.get(index) else { return };
    let input = match to {
        WireEnd::Input(number) => Some(number),
        WireEnd::Step | WireEnd::Dir => None,
    };
    let other = if wires.iter().any(|wire| (wire.to_module, wire.to) == (index, to)) {
        "another wire"
    } else if input.is_none() && module.step_dir != StepDirConfig::default() {
        "[module.step_dir]"
    } else if input.is_some_and(|input| module.inputs.digital.contains_key(&input)) {
        "a level in [module.inputs]"
    } else if let Some(switch) = input.and_then(|input| pins::switch_at(module.kind, &module.switches, input))
    {
        &format!("the {} switch", switch.word())
    } else {
        return;
    };
    if let Some(span) = section.key_span("to") {
        let message = format!("{}.{} is already driven by {other}", module.name, to.name());
        section.complain(ConfigError::new(span, message));
    }
}
