//! `tmcl commands`: a module's commands.

use serde::Serialize;
use tmcl_tables::{CommandsMarkdown, ModuleCommand};

use crate::arguments::Commands;
use crate::exit::Outcome;
use crate::print;

/// A command, as JSON has it. `mnemonic` is empty for commands that only a host sends.
#[derive(Serialize)]
struct Row {
    number: u8,
    mnemonic: &'static str,
    id: &'static str,
    name: &'static str,
    summary: &'static str,
    types: Vec<Type>,
    direct: bool,
    program: bool,
    starts_motion: bool,
    repeat_safe: bool,
    section: &'static str,
    beyond_manual: &'static str,
    note: &'static str,
}

#[derive(Serialize)]
struct Type {
    value: u8,
    keyword: &'static str,
    id: &'static str,
    name: &'static str,
}

/// Prints them.
pub(crate) fn run(options: &Commands) -> Outcome {
    let module = options.module;
    if options.format.markdown {
        return Ok(print::text(&CommandsMarkdown(module).to_string())?);
    }
    if options.format.json {
        let rows: Vec<Row> = module.commands.iter().map(row).collect();
        return Ok(print::json(&rows)?);
    }
    let header = ["number", "mnemonic", "types", "where", "section", "meaning"];
    Ok(print::table(header, module.commands.iter().map(cells))?)
}

fn cells(entry: &ModuleCommand) -> [String; 6] {
    let spec = entry.spec;
    let keywords: Vec<_> = entry
        .named_types()
        .map(|named| if named.keyword.is_empty() { named.id } else { named.keyword })
        .collect();
    let place = match (entry.modes.direct, entry.modes.program) {
        (true, true) => "both",
        (true, false) => "direct",
        (false, true) => "program",
        (false, false) => "",
    };
    [
        spec.number.to_string(),
        spec.mnemonic.to_owned(),
        keywords.join(" "),
        place.to_owned(),
        entry.section.to_owned(),
        spec.summary.to_owned(),
    ]
}

fn row(entry: &ModuleCommand) -> Row {
    let spec = entry.spec;
    Row {
        number: spec.number,
        mnemonic: spec.mnemonic,
        id: spec.id,
        name: spec.name,
        summary: spec.summary,
        types: entry
            .named_types()
            .map(|named| Type { value: named.value, keyword: named.keyword, id: named.id, name: named.name })
            .collect(),
        direct: entry.modes.direct,
        program: entry.modes.program,
        starts_motion: spec.starts_motion,
        repeat_safe: spec.repeat_safe,
        section: entry.section,
        beyond_manual: entry.beyond_manual,
        note: spec.note,
    }
}
