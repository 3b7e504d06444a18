//! Labels and constants. Both are the same in any case; a label and a constant of one name do not meet.

use std::collections::BTreeMap;

use indexmap::IndexMap;

use super::load::Loaded;
use super::words;
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::program::{ConstantDefinition, LabelDefinition};
use crate::source::{Sources, Span};
use crate::syntax::{Name, Statement};

/// A number and how it came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Number {
    pub(super) value: i64,
    /// Whether it is written in hexadecimal, where people mean bits.
    pub(super) is_hexadecimal: bool,
    /// Whether it is a name that stands for it.
    pub(super) is_named: bool,
    /// Whether it is the address of a label.
    pub(super) is_label: bool,
}

struct Constant {
    definition: ConstantDefinition,
    /// None where the definition was complained about.
    number: Option<Number>,
    is_builtin: bool,
}

/// What a name stands for: indices into the definitions.
#[derive(Clone, Copy, Default)]
struct Meaning {
    label: Option<usize>,
    /// The definition of the constant that counts now.
    constant: Option<usize>,
    /// Where the constant is first defined, be it further down.
    anywhere: Option<Span>,
}

/// What the names of a program stand for; constants from their definitions on.
#[derive(Default)]
pub(super) struct Names {
    labels: Vec<LabelDefinition>,
    constants: Vec<Constant>,
    /// Keeps the order of insertion, so that it is the same in every run.
    by_name: IndexMap<Key, Meaning>,
    /// Constants of included files: one that is included twice defines its constants once.
    included: BTreeMap<Span, usize>,
}

/// A name in lower case.
type Key = String;

/// Names up to this length are looked up without allocating.
const SHORT: usize = 64;

/// Looks a name up in any case.
fn meaning(names: &IndexMap<Key, Meaning>, name: &str) -> Option<Meaning> {
    let mut buffer = [0; SHORT];
    let short = buffer.get_mut(..name.len()).and_then(|short| {
        short.copy_from_slice(name.as_bytes());
        short.make_ascii_lowercase();
        core::str::from_utf8(short).ok()
    });
    match short {
        Some(key) => names.get(key),
        None => names.get(name.to_ascii_lowercase().as_str()),
    }
    .copied()
}

impl Names {
    /// The labels, and what is to be complained about; no constant is defined yet.
    pub(super) fn collect(loaded: &Loaded) -> (Self, Vec<Diagnostic>) {
        let mut names = Self::default();
        let mut complaints = Vec::new();
        let mut address = 0_u16;
        for (_, line) in loaded.lines() {
            complaints.extend(line.labels.iter().filter_map(|label| names.define_label(label, address)));
            match &line.statement {
                Some(Statement::Instruction(_)) => address = address.saturating_add(1),
                Some(Statement::Constant(constant)) => {
                    names.meaning_mut(&constant.name.text).anywhere.get_or_insert(constant.name.span);
                }
                _ => {}
            }
        }
        (names, complaints)
    }

    fn meaning_mut(&mut self, name: &str) -> &mut Meaning {
        self.by_name.entry(name.to_ascii_lowercase()).or_default()
    }

    fn define_label(&mut self, label: &Name, address: u16) -> Option<Diagnostic> {
        let next = self.labels.len();
        let index = *self.meaning_mut(&label.text).label.get_or_insert(next);
        let Some(first) = self.labels.get(index) else {
            let name = label.text.clone();
            self.labels.push(LabelDefinition { name, span: label.span, address, uses: 0 });
            return None;
        };
        let message = format!("the label `{}` is defined twice", words::shortened(&label.text));
        let complaint = Diagnostic::new(Code::DuplicateLabel, label.span, message);
        Some(if first.span == label.span {
            complaint.note("the file is included more than once")
        } else {
            complaint.label("defined again").also(first.span, "first defined here")
        })
    }

    /// Defines a constant from here on; without a number its uses are not complained about again.
    pub(super) fn define_constant(&mut self, name: &Name, number: Option<Number>, is_builtin: bool) {
        let next = self.constants.len();
        let index = match name.span.file {
            Sources::ROOT => next,
            _ => *self.included.entry(name.span).or_insert(next),
        };
        self.meaning_mut(&name.text).constant = Some(index);
        let value = number.map_or(0, |number| number.value);
        match self.constants.get_mut(index) {
            Some(known) => {
                known.definition.value = value;
                known.number = number;
            }
            None => {
                let definition =
                    ConstantDefinition { name: name.text.clone(), span: name.span, value, uses: 0 };
                self.constants.push(Constant { definition, number, is_builtin });
            }
        }
    }

    /// What a constant stands for here, if it is defined; the inner None where its definition was complained about.
    pub(super) fn use_constant(&mut self, name: &str) -> Option<Option<Number>> {
        let index = meaning(&self.by_name, name)?.constant?;
        let constant = self.constants.get_mut(index)?;
        constant.definition.uses = constant.definition.uses.saturating_add(1);
        Some(constant.number)
    }

    /// The address of a label.
    pub(super) fn use_label(&mut self, name: &str) -> Option<u16> {
        let index = meaning(&self.by_name, name)?.label?;
        let label = self.labels.get_mut(index)?;
        label.uses = label.uses.saturating_add(1);
        Some(label.address)
    }

    /// Where a label is defined.
    pub(super) fn label(&self, name: &str) -> Option<Span> {
        self.labels.get(meaning(&self.by_name, name)?.label?).map(|label| label.span)
    }

    /// Where a constant is defined, now or further down.
    pub(super) fn constant_anywhere(&self, name: &str) -> Option<Span> {
        meaning(&self.by_name, name)?.anywhere
    }

    /// The constants that are defined here.
    pub(super) fn constant_names(&self) -> impl Iterator<Item = &str> {
        let defined = self.by_name.values().filter_map(|meaning| self.constants.get(meaning.constant?));
        defined.map(|constant| constant.definition.name.as_str())
    }

    /// All labels.
    pub(super) fn label_names(&self) -> impl Iterator<Item = &str> {
        self.labels.iter().map(|label| label.name.as_str())
    }

    /// What the program tells of its names: built-in constants only where they are used.
    pub(super) fn into_definitions(self) -> (Vec<LabelDefinition>, Vec<ConstantDefinition>) {
        let told = |constant: &Constant| !constant.is_builtin || constant.definition.uses > 0;
        let constants = self.constants.into_iter().filter(told).map(|constant| constant.definition).collect();
        (self.labels, constants)
    }
}
