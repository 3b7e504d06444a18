//! The configuration of a module as a text (TOML), and back.
//!
//! The text says which module it is for, then what each parameter holds: `[axis]`, `[global]`, `[connection]`, `[variable]`
//! and `[coordinate]`. `docs/parameters.md` describes it for people.

mod parse;
mod write;

pub use crate::finding::Finding;
pub use parse::{Config, Entry, parse};
pub use write::{Header, write};

use tmcl_tables::Role;

use crate::item::Item;

/// The sections of a file, in their order.
const SECTIONS: [&str; 5] = ["axis", "global", "connection", "variable", "coordinate"];

/// The section that holds an item.
fn section(item: Item) -> &'static str {
    match item {
        Item::Coordinate(_) => "coordinate",
        Item::Axis(_) => "axis",
        Item::Port(_) => "port",
        Item::Global(..) if item.is_variable() => "variable",
        Item::Global(..) if item.role() == Role::Connection => "connection",
        Item::Global(..) => "global",
    }
}

/// What an item is called within its section.
fn key(item: Item) -> String {
    match item {
        Item::Coordinate(number) => number.to_string(),
        Item::Global(_, number) if item.is_variable() => number.to_string(),
        _ => item.name(),
    }
}

#[cfg(test)]
mod tests;
