//! What messages call an instruction, and where it was written.

use tmcl_tables::ModuleSpec;

use crate::program::Program;
use crate::source::{Sources, Span};

/// Names and spans of a program's instructions.
pub(super) struct Places<'p> {
    program: &'p Program,
    /// The first label of each instruction.
    names: Vec<Option<&'p str>>,
}

impl<'p> Places<'p> {
    /// Those of `program`.
    pub(super) fn new(program: &'p Program) -> Self {
        let mut names = vec![None; program.instructions.len()];
        for label in &program.labels {
            if let Some(name @ None) = names.get_mut(usize::from(label.address)) {
                *name = Some(label.name.as_str());
            }
        }
        Self { program, names }
    }

    /// Where an instruction was written.
    pub(super) fn span(&self, address: usize) -> Span {
        self.program.origins.get(address).copied().unwrap_or(Span { file: Sources::ROOT, start: 0, end: 0 })
    }

    /// Its label in back quotes, or its address.
    pub(super) fn name(&self, address: usize) -> String {
        match self.names.get(address).copied().flatten() {
            Some(name) => format!("`{name}`"),
            None => format!("address {address}"),
        }
    }
}

/// An interrupt, by number and name.
pub(super) fn interrupt_name(module: &ModuleSpec, number: u8) -> String {
    match module.interrupt(number) {
        Some(interrupt) => format!("interrupt {number} ({})", interrupt.name),
        None => format!("interrupt {number}"),
    }
}
