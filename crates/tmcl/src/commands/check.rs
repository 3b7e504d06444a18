//! `tmcl check`: what is wrong with programs, or hardly meant.

use std::path::PathBuf;

use tmcl_lang::Severity;

use super::asm::counted;
use crate::arguments::Check;
use crate::exit::{Code, Failures, Outcome};
use crate::print;
use crate::program::{Checked, diagnostics};

/// Runs it.
pub(crate) fn run(options: &Check) -> Outcome {
    let mut failures = Failures::default();
    let read = |file| failures.note(Checked::read(file, options.module, &options.lints));
    let files: Vec<_> = options.files.iter().map(PathBuf::as_path).filter_map(read).collect();
    let total = |severity| files.iter().map(|checked| checked.count(severity)).sum();
    let (errors, warnings) = (total(Severity::Error), total(Severity::Warning));
    if options.json {
        print::json(&diagnostics::report(&files))?;
    } else {
        files.iter().for_each(diagnostics::print);
        if errors + warnings > 0 {
            print::note(&format!("{}, {}", counted(errors, "error"), counted(warnings, "warning")));
        }
    }
    failures.finish()?;
    if errors + warnings > 0 { Err(Code::Findings.into()) } else { Ok(()) }
}
