//! `tmcl set`: giving parameters other values.

use clap::Args;
use serde::Serialize;
use tmcl_config::{Item, Name, parse_value};
use tmcl_tables::ModuleSpec;

use crate::connection::{AnyClient, ConnectionOptions, failure};
use crate::exit::{Code, Failure, Failures, Outcome};
use crate::parameters::{self, Row, Storage};
use crate::print;

/// `tmcl set`.
#[derive(Args)]
#[command(
    after_help = "A value is a whole number (51200, 51_200, 0xC800, 0b101), with the unit of the parameter behind it or not \
    ('51200 pps'), or the name of a value (on). A bit field is changed within what the parameter holds. Everything is checked \
    first and then written in order. A write can set the motor moving, as one of target_position does."
)]
pub(crate) struct Set {
    /// What to write, such as max_velocity=51200, auto_start=on or encoder_mode.null_active_high=1
    #[arg(required = true, value_name = "NAME=VALUE")]
    pub(crate) assignments: Vec<String>,
    /// Store it in the EEPROM too
    #[arg(long)]
    pub(crate) store: bool,
    /// Print what was written as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) connection: ConnectionOptions,
}

/// What was written, as JSON has it.
#[derive(Serialize)]
struct Written {
    #[serde(flatten)]
    row: Row,
    stored: bool,
}

/// Checks all, then writes all.
pub(crate) fn run(options: &Set) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    let mut failures = Failures::default();
    let texts = options.assignments.iter();
    let parts: Vec<_> = texts.filter_map(|text| failures.note(split(text, module, options.store))).collect();
    let items = parts.iter().map(|(name, _)| name.item);
    let closed_loop = parameters::closed_loop(&mut client, module, items)?;
    let mut wanted = Vec::new();
    for (name, text) in parts {
        let value = parse_value(text, &name, closed_loop);
        let value = value.map_err(|error| Failure::new(Code::Usage, error.to_string()));
        wanted.extend(failures.note(value).map(|value| (name, value)));
    }
    let whole = failures.note(whole_values(&mut client, &wanted));
    failures.finish()?;
    let mut written = Vec::new();
    let outcome = write_all(&mut client, &whole.unwrap_or_default(), options.store, &mut written);
    if options.json {
        let rows = written.into_iter().map(|(item, value, stored)| Written {
            row: Row::new(&Name::of(item), value, closed_loop),
            stored,
        });
        print::json(&rows.collect::<Vec<_>>())?;
    }
    Ok(outcome?)
}

/// Writes until the module refuses one. Says what was written, and whether it is stored.
fn write_all(
    client: &mut AnyClient,
    writes: &[(Item, i64)],
    to_store: bool,
    written: &mut Vec<(Item, i64, bool)>,
) -> Result<(), Failure> {
    for &(item, value) in writes {
        let refused = |error| parameters::refused(&item.name(), &error);
        parameters::write(client, item, value).map_err(refused)?;
        let storage = parameters::storage(item);
        let stored = match storage {
            Storage::Command if to_store => parameters::store(client, item).map_err(refused),
            Storage::Command | Storage::Itself | Storage::None => Ok(()),
        };
        let is_stored = match storage {
            Storage::Itself => true,
            Storage::Command => to_store && stored.is_ok(),
            Storage::None => false,
        };
        written.push((item, value, is_stored));
        stored?;
    }
    Ok(())
}

/// The parameter and the text of its value.
fn split<'t>(text: &'t str, module: &'static ModuleSpec, to_store: bool) -> Result<(Name, &'t str), Failure> {
    let Some((name, value)) = text.split_once('=') else {
        let message = format!("`{text}` is no assignment; write NAME=VALUE, such as max_current=100");
        return Err(Failure::new(Code::Usage, message));
    };
    let name = Name::parse(name.trim(), module).map_err(|error| parameters::wrong_name(&error))?;
    if to_store && parameters::storage(name.item) == Storage::None {
        return Err(Failure::new(Code::Usage, format!("`{name}` cannot be stored")));
    }
    Ok((name, value))
}

/// What whole parameters are to hold. Bit fields are put into what the parameter holds, or will hold by then.
fn whole_values(client: &mut AnyClient, wanted: &[(Name, i64)]) -> Result<Vec<(Item, i64)>, Failure> {
    let mut whole: Vec<(Item, i64)> = Vec::new();
    for (name, value) in wanted {
        let before = match whole.iter().rev().find(|(item, _)| *item == name.item) {
            Some((_, before)) => *before,
            None if name.field.is_none() => 0,
            None => parameters::read(client, name.item).map_err(|error| failure(&error))?,
        };
        whole.push((name.item, name.insert(before, *value)));
    }
    // Several fields of a parameter are one write, and only what comes of all of them has to be allowed.
    let last = |index: usize, item: Item| whole[index + 1..].iter().all(|(later, _)| *later != item);
    let fields = |item: Item| {
        wanted.iter().filter(|(name, _)| name.item == item).all(|(name, _)| name.field.is_some())
    };
    let kept = whole.iter().enumerate().filter(|(index, (item, _))| !fields(*item) || last(*index, *item));
    let kept: Vec<_> = kept.map(|(_, write)| *write).collect();
    for (item, value) in &kept {
        Name::of(*item).check_whole(*value).map_err(|error| Failure::new(Code::Usage, error.to_string()))?;
    }
    Ok(kept)
}
