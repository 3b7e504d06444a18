//! A configuration from a text.

use core::ops::Range;

use tmcl_tables::{MODULES, ModuleSpec, Role, module_by_id};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{SECTIONS, key, section};
use crate::finding::Finding;
use crate::item::{Item, items};
use crate::name::Name;
use crate::suggest;
use crate::value::parse_value;

/// What a file says.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The module it is for.
    pub module: &'static ModuleSpec,
    /// Where that is said.
    pub module_span: Range<usize>,
    /// The firmware that it was read from, as in `1.11`, where that is said.
    pub firmware: Option<String>,
    /// What parameters are to hold, in the order of the tables; each parameter once.
    pub entries: Vec<Entry>,
}

/// A parameter in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The parameter.
    pub item: Item,
    /// What it is to hold.
    pub value: i64,
    /// Where that is said.
    pub span: Range<usize>,
}

type Value<'t> = Spanned<DeValue<'t>>;

/// Reads a configuration file.
///
/// # Errors
/// Everything that is wrong with it, in the order of the text: no TOML, no module or none that the tables know, sections and
/// keys that nobody knows, values that the parameter does not take, and parameters that are no part of a configuration,
/// because they can only be read, say what happens, or set the motor moving.
pub fn parse(text: &str) -> Result<Config, Vec<Finding>> {
    let (table, malformed) = DeTable::parse_recoverable(text);
    let mut findings: Vec<Finding> = malformed.iter().map(|error| in_form(error, text)).collect();
    let config = if findings.is_empty() { read(table.get_ref(), &mut findings) } else { None };
    findings.sort_by_key(|finding| finding.span.start);
    // What one slip breaks, the parser reports several times.
    findings.dedup_by_key(|finding| finding.span.start);
    config.filter(|_| findings.is_empty()).ok_or(findings)
}

fn in_form(error: &toml::de::Error, text: &str) -> Finding {
    let span = error.span().unwrap_or(0..0);
    let end = span.end.min(text.len());
    Finding::new(span.start.min(end)..end, format!("not TOML: {}", error.message()))
}

fn read(table: &DeTable<'_>, findings: &mut Vec<Finding>) -> Option<Config> {
    let (module, module_span) = read_module(table, findings)?;
    let mut config = Config { module, module_span, firmware: None, entries: Vec::new() };
    for (key, value) in table {
        let name: &str = key.get_ref();
        match (name, value.get_ref()) {
            ("module", _) => {}
            ("firmware", DeValue::String(version)) => config.firmware = Some(version.to_string()),
            ("firmware", _) => {
                findings.push(Finding::new(value.span(), "firmware is a text such as \"1.11\""));
            }
            (_, DeValue::Table(entries)) if SECTIONS.contains(&name) => {
                read_section(name, entries, &mut config, findings);
            }
            _ if SECTIONS.contains(&name) => {
                findings.push(Finding::new(key.span(), format!("{name} is a section, [{name}]")));
            }
            _ => findings.push(unknown_key(name, key.span(), module)),
        }
    }
    let place = |item: Item| items(module).position(|other| other == item);
    config.entries.sort_by_key(|entry| place(entry.item));
    Some(config)
}

fn read_module(
    table: &DeTable<'_>,
    findings: &mut Vec<Finding>,
) -> Option<(&'static ModuleSpec, Range<usize>)> {
    let known = MODULES.map(|module| module.id).join(", ");
    let Some(value) = table.get("module") else {
        let missing = Finding::new(0..0, "the file does not say which module it is for");
        findings.push(missing.with_help(format!("begin with module = \"…\"; there are {known}")));
        return None;
    };
    let name = value.get_ref().as_str();
    let found = name.and_then(|name| module_by_id(name).ok());
    if found.is_none() {
        let unknown = Finding::new(value.span(), "no such module");
        findings.push(unknown.with_help(format!("there are {known}")));
    }
    found.map(|module| (module, value.span()))
}

/// A key outside the sections that nobody knows; perhaps a parameter.
fn unknown_key(name: &str, span: Range<usize>, module: &'static ModuleSpec) -> Finding {
    let unknown = Finding::new(span, format!("unknown key \"{name}\""));
    if let Some(item) = Item::by_id(module, name) {
        return unknown.with_help(format!("`{name}` belongs into the section [{}]", section(item)));
    }
    let choices = ["module", "firmware"].into_iter().chain(SECTIONS);
    match suggest::nearest(name, choices.clone()) {
        Some(nearest) => unknown.with_help(format!("did you mean \"{nearest}\"?")),
        None => {
            let choices: Vec<_> = choices.collect();
            unknown.with_help(format!("allowed here: {}", choices.join(", ")))
        }
    }
}

fn read_section(name: &str, table: &DeTable<'_>, config: &mut Config, findings: &mut Vec<Finding>) {
    for (key, value) in table {
        let entry = read_item(name, key, config.module).and_then(|item| {
            if let Some(first) = config.entries.iter().find(|entry| entry.item == item) {
                let twice = Finding::new(key.span(), format!("`{}` is set twice", item.name()));
                debug_assert!(first.span != value.span(), "an entry is read once");
                return Err(twice);
            }
            Ok(Entry { item, value: read_value(item, value)?, span: value.span() })
        });
        match entry {
            Ok(entry) => config.entries.push(entry),
            Err(finding) => findings.push(finding),
        }
    }
}

/// What a key stands for in a section.
fn read_item(
    name: &str,
    written: &Spanned<std::borrow::Cow<'_, str>>,
    module: &'static ModuleSpec,
) -> Result<Item, Finding> {
    let text: &str = written.get_ref();
    let full = match name {
        "variable" | "coordinate" => format!("{name}.{text}"),
        _ => text.to_owned(),
    };
    let found =
        Name::parse(&full, module).map_err(|error| Finding::new(written.span(), error.to_string()))?;
    let item = found.item;
    if found.field.is_some() {
        let whole = Finding::new(
            written.span(),
            format!("`{found}` is some bits of a parameter; a file has the whole"),
        );
        return Err(whole.with_help(format!("write {} = …", key(item))));
    }
    check_role(item).map_err(|message| {
        let finding = Finding::new(written.span(), message);
        if item.starts_motion() {
            finding.with_help(format!("`tmcl set {}=…` writes it", item.name()))
        } else {
            finding.with_help("take it out of the file")
        }
    })?;
    let right = section(item);
    if right != name {
        let wrong = Finding::new(written.span(), format!("`{}` does not belong into [{name}]", item.name()));
        return Err(wrong.with_help(format!("it belongs into [{right}] as {}", key(item))));
    }
    Ok(item)
}

/// Why something is no part of a configuration.
fn check_role(item: Item) -> Result<(), String> {
    let name = item.name();
    let access = item.access();
    if !access.write {
        return Err(format!("`{name}` can only be read"));
    }
    if item.starts_motion() {
        return Err(format!("writing `{name}` can set the motor moving; a configuration does not"));
    }
    if item.role() == Role::State {
        return Err(format!("`{name}` is no setting: it says, counts or commands what happens"));
    }
    Ok(())
}

fn read_value(item: Item, value: &Value<'_>) -> Result<i64, Finding> {
    let text = match value.get_ref() {
        DeValue::String(text) => text.to_string(),
        DeValue::Integer(whole) => {
            let number = i64::from_str_radix(whole.as_str(), whole.radix());
            number.map_or_else(|_| whole.to_string(), |number| number.to_string())
        }
        DeValue::Float(float) => float.to_string(),
        _ => {
            let message =
                format!("`{}` must be a whole number or the name of a value in quotes", item.name());
            return Err(Finding::new(value.span(), message));
        }
    };
    parse_value(&text, &Name::of(item), false).map_err(|error| Finding::new(value.span(), error.to_string()))
}
