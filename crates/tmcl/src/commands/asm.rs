//! `tmcl asm`: text to the compiled file that the vendor's IDE writes too.

use std::path::{Path, PathBuf};

use tmcl_lang::{Severity, image};

use crate::arguments::Asm;
use crate::exit::{Code, Failure, Outcome};
use crate::print;
use crate::program::{Checked, diagnostics, files, listing, symbols};

/// Runs it.
pub(crate) fn run(options: &Asm) -> Outcome {
    let out = out(options)?;
    let checked = Checked::read(&options.file, options.module, &options.lints)?;
    if !options.json {
        diagnostics::print(&checked);
    }
    let errors = checked.count(Severity::Error);
    if errors > 0 {
        if options.json {
            print::json(&diagnostics::report(std::slice::from_ref(&checked)))?;
            return Err(Code::Findings.into());
        }
        return Err(
            Failure::new(Code::Findings, format!("not assembled, {}", counted(errors, "error"))).into()
        );
    }
    let assembly = &checked.assembly;
    files::write(&out, &image::encode(&assembly.program.instructions))?;
    if let Some(path) = &options.symbols {
        files::write(path, symbols::json(assembly).map_err(std::io::Error::from)?.as_bytes())?;
    }
    if let Some(path) = &options.listing {
        files::write(path, listing::listing(assembly).as_bytes())?;
    }
    if options.json {
        return Ok(print::json(&diagnostics::report(std::slice::from_ref(&checked)))?);
    }
    if out.as_os_str() != files::STANDARD {
        let (length, memory) = (assembly.program.instructions.len(), assembly.program.module.program_memory);
        let message = format!("{} of {memory} written to {}", counted(length, "instruction"), out.display());
        print::note(&message);
    }
    Ok(())
}

/// Where the compiled file goes. No output may be the program itself, nor may two go to stdout.
fn out(options: &Asm) -> Result<PathBuf, Failure> {
    let usage = |message: String| Err(Failure::new(Code::Usage, message));
    let is_standard = |path: &Path| path.as_os_str() == files::STANDARD;
    let out = match &options.out {
        Some(out) => out.clone(),
        None if is_standard(&options.file) => PathBuf::from(files::STANDARD),
        None => options.file.with_extension("bin"),
    };
    let outputs = [Some(&out), options.symbols.as_ref(), options.listing.as_ref()];
    let outputs: Vec<&PathBuf> = outputs.into_iter().flatten().collect();
    if let Some(same) = outputs.iter().find(|path| !is_standard(path) && **path == &options.file) {
        return usage(format!("{} would be overwritten; name the output with -o", same.display()));
    }
    let standard = outputs.iter().filter(|path| is_standard(path)).count() + usize::from(options.json);
    if standard > 1 {
        return usage("only one of -o, --symbols, --listing and --json can go to stdout".to_owned());
    }
    Ok(out)
}

/// `1 error`, `2 errors`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}
