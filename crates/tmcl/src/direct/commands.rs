//! Commands of a command line: all of them are understood before the first is sent.

use std::io::BufRead;

use tmcl_tables::ModuleSpec;

use super::{Entered, Language, Prepared, Spoken};
use crate::exit::{Code, Failure};
use crate::program::files;

/// A line and where it stands.
pub(crate) struct Line {
    name: String,
    number: usize,
    text: String,
}

/// The commands of the command line; for a `-` among them, the lines of stdin.
pub(crate) fn lines(commands: &[String]) -> Result<Vec<Line>, Failure> {
    let mut lines = Vec::new();
    for (index, command) in commands.iter().enumerate() {
        if command == files::STANDARD {
            for (index, text) in std::io::stdin().lock().lines().enumerate() {
                let text =
                    text.map_err(|error| Failure::new(Code::Usage, format!("cannot read <stdin>: {error}")))?;
                lines.push(Line { name: "<stdin>".to_owned(), number: index + 1, text });
            }
        } else {
            lines.push(Line { name: format!("<command {}>", index + 1), number: 1, text: command.clone() });
        }
    }
    Ok(lines)
}

/// Every command, or everything that is wrong with them.
pub(crate) fn understood(lines: &[Line], module: &'static ModuleSpec) -> Result<Vec<Prepared>, Failure> {
    let mut language = Language::of(module);
    let mut commands = Vec::new();
    let mut errors = String::new();
    for Line { name, number, text } in lines {
        match language.understand(Spoken { name, number: *number, text }) {
            Ok(Entered::Command(command)) => commands.push(command),
            Ok(Entered::Nothing) => {}
            Err(text) => errors += &text,
        }
    }
    if errors.is_empty() {
        return Ok(commands);
    }
    anstream::eprint!("{errors}");
    Err(Failure::new(Code::Usage, "nothing was sent"))
}

/// What stands below a refusal: what the tables have against the command.
pub(crate) fn reason(doubts: &str) -> String {
    if doubts.is_empty() { String::new() } else { format!("\n\n{}", doubts.trim_end()) }
}
