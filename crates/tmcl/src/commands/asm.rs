//! `tmcl asm`: text to the compiled file that the vendor's IDE writes too.

use std::path::{Path, PathBuf};

use tmcl_lang::{Severity, image};

use crate::arguments::Asm;
use crate::exit::{Code, Failure, Outcome};
use crate::print;
use crate::program::{Checked, diagnostics, files, listing, symbols};

/// Runs it.
pub(crate) fn run(options: &Asm) -> Outcome {
    let checked = Checked::read(&options.file, options.module, &options.lints)?;
    if !options.json {
        diagnostics::print(&checked);
    }
    let errors = checked.count(Severity::Error);
    if errors > 0 {
        if options.json {
            print::json(&diagnostics::json(&checked))?;
            return Err(Code::Findings.into());
        }
        return Err(
            Failure::new(Code::Findings, format!("not assembled, {}", counted(errors, "error"))).into()
        );
    }
    let assembly = &checked.assembly;
    let out = options.out.clone().unwrap_or_else(|| default_out(&options.file));
    files::write(&out, &image::encode(&assembly.program.instructions))?;
    if let Some(path) = &options.symbols {
        files::write(path, symbols::json(assembly).map_err(std::io::Error::from)?.as_bytes())?;
    }
    if let Some(path) = &options.listing {
        files::write(path, listing::listing(assembly).as_bytes())?;
    }
    if options.json {
        return Ok(print::json(&diagnostics::json(&checked))?);
    }
    if out.as_os_str() != files::STANDARD {
        let (length, memory) = (assembly.program.instructions.len(), assembly.program.module.program_memory);
        let message = format!("{} of {memory} written to {}", counted(length, "instruction"), out.display());
        print::note(&message);
    }
    Ok(())
}

/// Beside the program; what comes from stdin goes to stdout.
fn default_out(file: &Path) -> PathBuf {
    if file.as_os_str() == files::STANDARD { file.to_owned() } else { file.with_extension("bin") }
}

/// `1 error`, `2 errors`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}
