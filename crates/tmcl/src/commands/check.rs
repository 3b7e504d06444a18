//! `tmcl check`: what is wrong with programs, or hardly meant.

use serde::Serialize;
use tmcl_lang::Severity;

use super::asm::counted;
use crate::arguments::Check;
use crate::exit::{Code, Outcome};
use crate::print;
use crate::program::diagnostics::DiagnosticJson;
use crate::program::{Checked, diagnostics};

#[derive(Serialize)]
struct Report<'a> {
    errors: usize,
    warnings: usize,
    diagnostics: Vec<DiagnosticJson<'a>>,
}

/// Runs it.
pub(crate) fn run(options: &Check) -> Outcome {
    let mut files = Vec::new();
    let mut unreadable = None;
    for file in &options.files {
        match Checked::read(file, options.module, &options.lints) {
            Ok(checked) => files.push(checked),
            // The others are checked all the same.
            Err(failure) => unreadable = unreadable.or(Some(failure)),
        }
    }
    let total = |severity| files.iter().map(|checked| checked.count(severity)).sum();
    let (errors, warnings) = (total(Severity::Error), total(Severity::Warning));
    if options.json {
        let diagnostics = files.iter().flat_map(diagnostics::json).collect();
        print::json(&Report { errors, warnings, diagnostics })?;
    } else {
        files.iter().for_each(diagnostics::print);
        if errors + warnings > 0 {
            print::note(&format!("{}, {}", counted(errors, "error"), counted(warnings, "warning")));
        }
    }
    match unreadable {
        Some(failure) => Err(failure.into()),
        None if errors + warnings > 0 => Err(Code::Findings.into()),
        None => Ok(()),
    }
}
