//! `tmcl disasm`: a compiled file to text that assembles to the same bytes.

use tmcl_lang::{disassemble, image};

use crate::arguments::Disasm;
use crate::exit::{Code, Failure, Outcome};
use crate::print;
use crate::program::files;

/// Runs it.
pub(crate) fn run(options: &Disasm) -> Outcome {
    let instructions = image::decode(&files::read(&options.file)?).map_err(|error| {
        Failure::new(Code::Usage, format!("{} is no compiled program: {error}", files::name(&options.file)))
    })?;
    Ok(print::text(&disassemble(&instructions, options.module))?)
}
