//! `tmcl exec`: commands of direct mode, written as in a program.

use clap::Args;

use crate::connection::{ConnectionOptions, told};
use crate::direct::{self, Answer, Exchange, Prepared};
use crate::exit::{Code, Ending, Failure, Outcome};
use crate::print;

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
    let lines = direct::lines(&options.commands)?;
    let (mut client, module) = options.connection.connect()?;
    let commands = direct::understood(&lines, module)?;
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
            ending = Err(Ending::Failure(Failure::new(Code::TmclStatus, message + &direct::reason(&doubts))));
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
