//! `tmcl fmt`: lays program text out.

use std::path::Path;

use crate::arguments::Fmt;
use crate::exit::{Code, Failure, Outcome};
use crate::print;
use crate::program::files;

/// Runs it.
pub(crate) fn run(options: &Fmt) -> Outcome {
    let mut unformatted = String::new();
    for file in &options.files {
        if format(file, options.check)? && options.check {
            unformatted += &format!("{}\n", file.display());
        }
    }
    print::text(&unformatted)?;
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
