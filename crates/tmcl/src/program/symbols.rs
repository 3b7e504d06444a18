//! The symbol file, `opentmcl-symbols/1`: from addresses to places in the text, and the names that the text defines.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use tmcl_lang::{Assembly, Span};

use super::files;
use crate::exit::{Code, Failure};

/// What the file says it is.
const FORMAT: &str = "opentmcl-symbols/1";

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
        format: FORMAT,
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

/// A symbol file that was read.
#[derive(Debug, Deserialize)]
pub(crate) struct SymbolFile {
    format: String,
    instructions: Vec<KnownInstruction>,
    labels: BTreeMap<String, KnownLabel>,
}

#[derive(Debug, Deserialize)]
struct KnownInstruction {
    address: u32,
    file: String,
    line: u32,
}

#[derive(Debug, Deserialize)]
struct KnownLabel {
    address: u32,
}

impl SymbolFile {
    /// Reads it.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let name = files::name(path);
        let usage = |message: String| Failure::new(Code::Usage, message);
        let file: Self = serde_json::from_slice(&files::read(path)?)
            .map_err(|error| usage(format!("{name} is no symbol file of `tmcl asm --symbols`: {error}")))?;
        if file.format != FORMAT {
            return Err(usage(format!("{name} has the format `{}`; `{FORMAT}` is expected", file.format)));
        }
        Ok(file)
    }

    /// File and line of the instruction at an address.
    pub(crate) fn place(&self, address: u32) -> Option<(String, u32)> {
        let known = self.instructions.iter().find(|known| known.address == address)?;
        Some((known.file.clone(), known.line))
    }

    /// The label that is nearest above an address of the program: `Loop + 2`.
    pub(crate) fn label(&self, address: u32) -> Option<String> {
        let known = self.labels.iter().filter(|(_, label)| label.address <= address);
        let (name, label) = known.max_by_key(|(_, label)| label.address)?;
        self.place(address)?;
        Some(match address - label.address {
            0 => name.clone(),
            above => format!("{name} + {above}"),
        })
    }
}
