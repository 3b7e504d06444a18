//! Program text on the command line: files in, diagnostics, listings and symbol files out.

pub(crate) mod diagnostics;
pub(crate) mod files;
pub(crate) mod lints;
pub(crate) mod listing;
pub(crate) mod symbols;

use std::path::Path;

use tmcl_lang::{Assembly, Diagnostic, Severity, SourceFile, lint};
use tmcl_tables::ModuleSpec;

use crate::exit::Failure;
use lints::LintOptions;

/// An assembled file and everything that is to be said of it.
pub(crate) struct Checked {
    pub(crate) assembly: Assembly,
    /// Errors, and the warnings that are asked for.
    pub(crate) diagnostics: Vec<Diagnostic>,
}

impl Checked {
    /// Reads and assembles a file, and lints it where it has no errors.
    pub(crate) fn read(
        file: &Path,
        module: Option<&'static ModuleSpec>,
        lints: &LintOptions,
    ) -> Result<Self, Failure> {
        Ok(Self::of(files::root(file)?, module, lints))
    }

    /// Assembles a text, and lints it where it has no errors.
    pub(crate) fn of(source: SourceFile, module: Option<&'static ModuleSpec>, lints: &LintOptions) -> Self {
        let assembly = tmcl_lang::assemble(source, module, &mut files::BesideIncluder);
        let mut diagnostics = assembly.diagnostics.clone();
        if !assembly.has_errors() {
            diagnostics.extend(lint::lint(&assembly.program, &assembly.sources));
        }
        diagnostics.retain(|diagnostic| lints.reports(diagnostic.code));
        Self { assembly, diagnostics }
    }

    /// How many diagnostics are that bad.
    pub(crate) fn count(&self, severity: Severity) -> usize {
        self.diagnostics.iter().filter(|diagnostic| diagnostic.severity() == severity).count()
    }
}
