//! `tmcl completions`: a shell's completion script.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::arguments::Arguments;
use crate::exit::Outcome;
use crate::print;

/// Prints it.
pub(crate) fn run(shell: Shell) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "tmcl", &mut script);
    Ok(print::text(&String::from_utf8_lossy(&script))?)
}
