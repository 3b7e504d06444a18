//! `tmcl exec`: commands of direct mode, written as in a program.

use std::io::BufRead;

use clap::Args;

use crate::connection::{ConnectionOptions, told};
use crate::direct::{self, Answer, Entered, Exchange, Language, Prepared, Spoken};
use crate::exit::{Code, Ending, Failure, Outcome};
use crate::print;
use crate::program::files;

/// `tmcl exec`.
#[derive(Args)]
#[command(
    after_help = "The names of TMCLParam.tmc and Interrupts.inc are defined: 'GAP APActualPosition, Motor0'. `DATA 135, 0, 0, 0` \
    sends the command 135 with type, motor or bank, and value, with no questions asked. All commands are understood before the \
    first is sent; the first that the module refuses ends it, with exit code 4."
)]
pub(crate) struct Exec {
    /// Commands, such as 'GAP 1, 0' 'MVP ABS, 0, 51200'; - takes one from each line of stdin
    #[arg(required = true, value_name = "COMMAND")]
    commands: Vec<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: ConnectionOptions,
}

/// Runs it.
pub(crate) fn run(options: &Exec) -> Outcome {
    let lines = lines(&options.commands)?;
    let (mut client, module) = options.connection.connect()?;
    let commands = understood(&lines, Language::of(module))?;
    let mut exchanges = Vec::new();
    let mut ending = Ok(());
    for Prepared { request, doubts } in commands {
        let answer = match direct::send(&mut client, request) {
            Ok(answer) => answer,
            Err(error) => {
                ending = Err(told(&client, &error).into());
                break;
            }
        };
        exchanges.push(Exchange::new(&client, request, &answer, module));
        if let Answer::Refused(status) = answer {
            let message = direct::refusal(&client, request, status, module);
            let reason = if doubts.is_empty() { String::new() } else { format!("\n\n{}", doubts.trim_end()) };
            ending = Err(Ending::Failure(Failure::new(Code::TmclStatus, message + &reason)));
            break;
        }
    }
    print(&exchanges, options.json)?;
    ending
}

fn print(exchanges: &[Exchange], json: bool) -> std::io::Result<()> {
    if json {
        return print::json(&exchanges);
    }
    if exchanges.is_empty() {
        return Ok(());
    }
    let row = |it: &Exchange| {
        [it.command.clone(), it.sent.clone(), it.status_text(), it.value_text(), it.meaning.clone()]
    };
    print::listing(["command", "sent", "status", "value", "meaning"], exchanges.iter().map(row))
}

/// A line and where it stands.
struct Line {
    name: String,
    number: usize,
    text: String,
}

/// The commands of the command line; for a `-` among them, the lines of stdin.
fn lines(commands: &[String]) -> Result<Vec<Line>, Failure> {
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
fn understood(lines: &[Line], mut language: Language) -> Result<Vec<Prepared>, Failure> {
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
