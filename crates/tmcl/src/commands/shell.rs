//! `tmcl shell`: commands one after the other, with completion and history on a terminal.

mod completion;
mod history;
mod line;
mod session;

use std::io::{BufRead, IsTerminal};
use std::time::Instant;

use clap::Args;
use rustyline::error::ReadlineError;
use rustyline::{CompletionType, Config, Editor, history::FileHistory};

use crate::connection::ConnectionOptions;
use crate::exit::{Code, Failure, Outcome};
use crate::print;
use completion::Helper;
use session::{Flow, Session};

/// `tmcl shell`.
#[derive(Args)]
#[command(
    after_help = "Commands are written as in a program; `help` says what else there is. On a terminal, Tab completes commands, \
    keywords, parameters and values, and what was typed is remembered. Without a terminal it reads commands from stdin, and ends \
    with 2, 3 or 4 if something was wrong."
)]
pub(crate) struct Shell {
    #[command(flatten)]
    connection: ConnectionOptions,
}

/// Runs it until its input ends.
pub(crate) fn run(options: &Shell) -> Outcome {
    let connection = options.connection.resolve()?;
    let (client, module) = connection.connect()?;
    let mut session = Session::new(client, module);
    if std::io::stdin().is_terminal() && std::io::stdout().is_terminal() {
        print::note(&format!("{} at {}; `help` helps, Ctrl-D leaves", module.name, connection.port()));
        interactive(&mut session, connection.is_virtual())
    } else {
        piped(&mut session)
    }
}

/// Reads lines and tells the worst that happened.
fn piped(session: &mut Session) -> Outcome {
    let mut worst = None;
    for (index, text) in std::io::stdin().lock().lines().enumerate() {
        let text =
            text.map_err(|error| Failure::new(Code::Usage, format!("cannot read <stdin>: {error}")))?;
        match session.enter("<stdin>", index + 1, &text)? {
            Flow::Leave => break,
            Flow::On => {}
            Flow::Failed(code) => worst = worst.max(Some(code as u8)),
        }
    }
    match worst {
        None => Ok(()),
        Some(worst) if worst == Code::TmclStatus as u8 => Err(Code::TmclStatus.into()),
        Some(worst) if worst == Code::Connection as u8 => Err(Code::Connection.into()),
        Some(_) => Err(Code::Usage.into()),
    }
}

fn interactive(session: &mut Session, is_virtual: bool) -> Outcome {
    let broken =
        |error: ReadlineError| Failure::new(Code::Usage, format!("the terminal does not work: {error}"));
    let config = Config::builder()
        .completion_type(CompletionType::List)
        .auto_add_history(true)
        .history_ignore_space(true)
        .max_history_size(1000)
        .map_err(broken)?
        .build();
    let mut editor: Editor<Helper, FileHistory> = Editor::with_config(config).map_err(broken)?;
    editor.set_helper(Some(Helper::of(session.module())));
    let history = history::file();
    if let Some(file) = &history {
        // There is none the first time.
        let _ = editor.load_history(file);
    }
    let prompt = format!("{}> ", session.module().id);
    let mut number = 0;
    let mut since = Instant::now();
    loop {
        match editor.readline(&prompt) {
            Ok(text) => {
                number += 1;
                if is_virtual {
                    session.wait(since.elapsed());
                    since = Instant::now();
                }
                if matches!(session.enter("<shell>", number, &text)?, Flow::Leave) {
                    break;
                }
            }
            // Ctrl-C throws the line away.
            Err(ReadlineError::Interrupted) => {}
            Err(ReadlineError::Eof) => break,
            Err(error) => return Err(broken(error).into()),
        }
    }
    if let Some(file) = &history {
        history::prepare(file)
            .and_then(|()| editor.append_history(file).map_err(|error| error.to_string()))
            .unwrap_or_else(|error| print::note(&format!("the history is not kept: {error}")));
    }
    Ok(())
}
