//! The symbol file, `opentmcl-symbols/1`: from addresses to places in the text, and the names that the text defines.

use std::collections::BTreeMap;

use serde::Serialize;
use tmcl_lang::{Assembly, Span};

#[derive(Serialize)]
struct Symbols<'a> {
    format: &'static str,
    module: &'static str,
    instructions: Vec<InstructionPlace<'a>>,
    labels: BTreeMap<&'a str, LabelPlace<'a>>,
    constants: BTreeMap<&'a str, ConstantPlace<'a>>,
}

#[derive(Serialize)]
struct Place<'a> {
    file: &'a str,
    line: u32,
    column: u32,
}

#[derive(Serialize)]
struct InstructionPlace<'a> {
    address: usize,
    #[serde(flatten)]
    place: Place<'a>,
}

#[derive(Serialize)]
struct LabelPlace<'a> {
    address: u16,
    #[serde(flatten)]
    place: Place<'a>,
}

#[derive(Serialize)]
struct ConstantPlace<'a> {
    value: i64,
    #[serde(flatten)]
    place: Place<'a>,
}

/// The symbol file of a program. Of a constant that is defined several times it holds the last definition.
pub(crate) fn json(assembly: &Assembly) -> serde_json::Result<String> {
    let program = &assembly.program;
    let place = |span: Span| {
        let position = assembly.sources.position(span);
        Place { file: assembly.sources.name(span), line: position.line, column: position.column }
    };
    let instructions = program.origins.iter().enumerate();
    let symbols = Symbols {
        format: "opentmcl-symbols/1",
        module: program.module.id,
        instructions: instructions
            .map(|(address, origin)| InstructionPlace { address, place: place(*origin) })
            .collect(),
        labels: program
            .labels
            .iter()
            .map(|label| {
                (label.name.as_str(), LabelPlace { address: label.address, place: place(label.span) })
            })
            .collect(),
        constants: program
            .constants
            .iter()
            .map(|constant| {
                (constant.name.as_str(), ConstantPlace { value: constant.value, place: place(constant.span) })
            })
            .collect(),
    };
    serde_json::to_string_pretty(&symbols).map(|text| text + "\n")
}
