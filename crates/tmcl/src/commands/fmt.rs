//! `tmcl fmt`: lays program text out.

use std::path::Path;

use crate::arguments::Fmt;
use crate::exit::{self, Code, Failure, Outcome};
use crate::print;
use crate::program::files;

/// Runs it.
pub(crate) fn run(options: &Fmt) -> Outcome {
    let mut unformatted = String::new();
    let mut failures = exit::Failures::default();
    for file in &options.files {
        let changes = failures.note(format(file, options.check)).unwrap_or(false);
        if changes && options.check {
            unformatted += &format!("{}\n", files::name(file));
        }
    }
    print::text(&unformatted)?;
    failures.finish()?;
    if unformatted.is_empty() { Ok(()) } else { Err(Code::Findings.into()) }
}

/// Formats one file, in place unless it is only checked. Returns whether that changes it.
fn format(file: &Path, check: bool) -> Result<bool, Failure> {
    let before = files::read(file)?;
    let after = tmcl_lang::format(&before);
    let changes = before != after;
    let is_standard = file.as_os_str() == files::STANDARD;
    if !check && (changes || is_standard) {
        files::write(file, &after)?;
    }
    Ok(changes)
}
