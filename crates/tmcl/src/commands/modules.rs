//! `tmcl modules`: what modules there are.

use serde::Serialize;
use tmcl_tables::{MODULES, ModuleSpec};
use virtual_bench::ModuleKind;

use crate::arguments::Modules;
use crate::exit::Outcome;
use crate::print;

/// A module, as JSON has it.
#[derive(Serialize)]
struct Row {
    id: &'static str,
    name: &'static str,
    number: u16,
    firmware: String,
    version_string: &'static str,
    summary: &'static str,
    interfaces: &'static [&'static str],
    program_memory: u16,
    coordinates: u8,
    axis_parameters: usize,
    global_parameters: usize,
    commands: usize,
    is_virtual: bool,
}

/// Prints them.
pub(crate) fn run(options: &Modules) -> Outcome {
    let rows: Vec<Row> = MODULES.iter().map(|spec| row(spec)).collect();
    if options.json {
        return Ok(print::json(&rows)?);
    }
    let cells = rows.iter().map(|row| {
        [
            row.id.to_owned(),
            row.firmware.clone(),
            row.axis_parameters.to_string(),
            row.global_parameters.to_string(),
            row.commands.to_string(),
            if row.is_virtual { "yes" } else { "not yet" }.to_owned(),
            row.summary.to_owned(),
        ]
    });
    let header = ["module", "firmware", "axis", "globals", "commands", "virtual", "what it is"];
    Ok(print::table(header, cells)?)
}

fn row(spec: &'static ModuleSpec) -> Row {
    let (major, minor) = spec.firmware;
    let globals = spec.global_parameters.iter();
    Row {
        id: spec.id,
        name: spec.name,
        number: spec.number,
        firmware: format!("{major}.{minor:02}"),
        version_string: spec.version_string,
        summary: spec.summary,
        interfaces: spec.interfaces,
        program_memory: spec.program_memory,
        coordinates: spec.coordinates,
        axis_parameters: spec.axis_parameters.len(),
        global_parameters: globals.map(|entry| usize::from(entry.last - entry.parameter.number) + 1).sum(),
        commands: spec.commands.len(),
        is_virtual: ModuleKind::try_from(spec).is_ok(),
    }
}
