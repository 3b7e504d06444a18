//! A configuration as a text.

use std::fmt::Write as _;

use tmcl_tables::{ModuleSpec, Role};

use super::{SECTIONS, key, section};
use crate::item::Item;
use crate::name::Name;
use crate::value::{described, range_in_words};

/// What a file says about itself.
#[derive(Clone, Copy, Debug)]
pub struct Header<'a> {
    /// The module.
    pub module: &'static ModuleSpec,
    /// Major and minor version of its firmware.
    pub firmware: (u8, u8),
    /// Who writes it: name and version of the program.
    pub writer: &'a str,
}

/// The text of a configuration. It depends on nothing but the arguments. Values of what is no part of a configuration, but
/// would be if writing it could not set the motor moving, stand in comments at its end; those of everything else that is
/// none are left out.
#[must_use]
pub fn write(header: Header<'_>, values: &[(Item, i64)]) -> String {
    let (major, minor) = header.firmware;
    let mut text = format!(
        "# Configuration of a {}, written by {}. `tmcl diff` compares a module with it, `tmcl apply` brings it into one.\n\n\
         module = \"{}\"\nfirmware = \"{major}.{minor:02}\"\n",
        header.module.name, header.writer, header.module.id
    );
    for name in SECTIONS {
        let mut entries =
            values.iter().filter(|(item, _)| item.is_configuration() && section(*item) == name).peekable();
        if entries.peek().is_some() {
            // Writing to a string cannot fail.
            let _ = write!(text, "\n[{name}]\n");
        }
        for &(item, value) in entries {
            text += &line(item, value);
        }
    }
    let moving: Vec<_> =
        values.iter().filter(|(item, _)| item.role() == Role::Setting && item.starts_motion()).collect();
    if !moving.is_empty() {
        text +=
            "\n# Writing these can set the motor moving, so that `tmcl apply` does not; `tmcl set` does:\n";
    }
    for (item, value) in moving {
        let _ = writeln!(text, "# {} = {}", item.name(), spelled(*item, *value));
    }
    text
}

/// A parameter. What cannot be written stands in a comment.
fn line(item: Item, value: i64) -> String {
    let assignment = format!("{} = {}", key(item), spelled(item, value));
    let comment = comment(item, value);
    match Name::of(item).check_whole(value) {
        Ok(()) if comment.is_empty() => format!("{assignment}\n"),
        Ok(()) => format!("{assignment}  # {comment}\n"),
        Err(error) => format!("# {assignment}  # {error}\n"),
    }
}

fn spelled(item: Item, value: i64) -> String {
    match item.values().iter().find(|named| named.value == value) {
        Some(named) => format!("\"{}\"", named.id),
        None => value.to_string(),
    }
}

/// Name, unit, and what is allowed or what the bits mean. User variables and coordinates are numbers, all alike.
fn comment(item: Item, value: i64) -> String {
    let Some(spec) = item.spec().filter(|_| !item.is_variable()) else { return String::new() };
    let mut text = spec.name.to_owned();
    match (spec.unit.is_empty(), item.has_two_units()) {
        (true, _) => {}
        (false, false) => text += &format!(" [{}]", spec.unit),
        (false, true) => text += &format!(" [{}, in closed loop {}]", spec.unit, spec.closed_loop_unit),
    }
    let named: Vec<_> = spec.values.iter().map(|named| named.id).collect();
    let what = match (named.is_empty(), spec.fields.is_empty()) {
        (false, _) => named.join(", "),
        (true, false) => described(&Name::of(item), value),
        (true, true) => range_in_words(spec.write_range),
    };
    if what.is_empty() { text } else { format!("{text}: {what}") }
}
