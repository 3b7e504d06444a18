//! The shell's talk with a module.

use std::time::Duration;

use tmcl_client::ClientError;
use tmcl_link::Link;
use tmcl_tables::{Access, Command, CommandSpec, ModuleSpec, ParameterSpec};
use tmcl_wire::Request;

use super::line::{self, Line, WORDS};
use crate::connection::{AnyClient, told};
use crate::direct::{self, Answer, Entered, Exchange, Language, Spoken};
use crate::exit::Code;
use crate::names::{self, Place};
use crate::print;

/// A module, and what was said to it.
pub(super) struct Session {
    client: AnyClient,
    module: &'static ModuleSpec,
    language: Language,
}

/// How a line ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow {
    On,
    Failed(Code),
    Leave,
}

type Step = std::io::Result<Flow>;

impl Session {
    pub(super) fn new(client: AnyClient, module: &'static ModuleSpec) -> Self {
        Self { client, module, language: Language::of(module) }
    }

    pub(super) fn module(&self) -> &'static ModuleSpec {
        self.module
    }

    /// Lets time pass. A link that is broken says so at the next command.
    pub(super) fn wait(&mut self, time: Duration) {
        let _ = self.client.link_mut().wait(time);
    }

    /// Does what a line says. Errors go to stderr, and the shell goes on.
    pub(super) fn enter(&mut self, name: &str, number: usize, text: &str) -> Step {
        match line::parse(text) {
            Err(message) => Ok(wrong(&message)),
            Ok(Line::Empty) => Ok(Flow::On),
            Ok(Line::Leave) => Ok(Flow::Leave),
            Ok(Line::Help(about)) => self.help(about),
            Ok(Line::Wait(time)) => {
                self.wait(time);
                Ok(Flow::On)
            }
            Ok(Line::Get(names)) => self.each(&names, Self::get),
            Ok(Line::Set(pairs)) => self.each(&pairs, |session, (name, value)| session.set(name, value)),
            Ok(Line::Command(text)) => match self.language.understand(Spoken { name, number, text }) {
                Ok(Entered::Command(command)) => self.exchange(command.request, &command.doubts),
                Ok(Entered::Nothing) => Ok(Flow::On),
                Err(errors) => {
                    anstream::eprint!("{errors}");
                    Ok(Flow::Failed(Code::Usage))
                }
            },
        }
    }

    /// Goes through them until one fails.
    fn each<T: Copy>(&mut self, items: &[T], one: impl Fn(&mut Self, T) -> Step) -> Step {
        for item in items {
            match one(self, *item)? {
                Flow::On => {}
                other => return Ok(other),
            }
        }
        Ok(Flow::On)
    }

    fn get(&mut self, name: &str) -> Step {
        match names::find(self.module, name) {
            Ok((place, _)) => {
                let (command, kind, motor) = match place {
                    Place::Axis(number) => (Command::GetAxisParameter, number, 0),
                    Place::Global(bank, number) => (Command::GetGlobalParameter, number, bank),
                };
                self.exchange(Request::new(command, kind, motor, 0), "")
            }
            Err(message) => Ok(wrong(&message)),
        }
    }

    fn set(&mut self, name: &str, value: &str) -> Step {
        let found = names::find(self.module, name)
            .and_then(|(place, parameter)| Ok((place, parameter, names::value(parameter, value)?)));
        match found {
            Ok((place, parameter, value)) => {
                let (command, kind, motor) = match place {
                    Place::Axis(number) => (Command::SetAxisParameter, number, 0),
                    Place::Global(bank, number) => (Command::SetGlobalParameter, number, bank),
                };
                self.exchange(Request::new(command, kind, motor, parameter.to_wire(value)), "")
            }
            Err(message) => Ok(wrong(&message)),
        }
    }

    /// Sends a command and prints a line about it.
    fn exchange(&mut self, request: Request, doubts: &str) -> Step {
        let answer = match direct::send(&mut self.client, request) {
            Ok(answer) => answer,
            Err(error) => return Ok(failed(&self.client, &error)),
        };
        let exchange = Exchange::new(&self.client, request, &answer, self.module);
        print::text(&format!("{}\n", line_of(&exchange)))?;
        let Answer::Refused(status) = answer else { return Ok(Flow::On) };
        print::error(&direct::refusal(&self.client, request, status, self.module));
        anstream::eprint!("{doubts}");
        Ok(Flow::Failed(Code::TmclStatus))
    }

    fn help(&self, about: &str) -> Step {
        if about.is_empty() {
            let words = WORDS.iter().map(|(word, what)| format!("  {word:16}  {what}\n")).collect::<String>();
            let text = format!(
                "{words}\nAnything else is a command, as a program writes it: GAP 1, 0. NAME = VALUE defines a constant.\n\
                 {}\n",
                mnemonics(self.module)
            );
            print::text(&text)?;
            return Ok(Flow::On);
        }
        let command =
            self.module.commands.iter().find(|entry| entry.spec.mnemonic.eq_ignore_ascii_case(about));
        match (command, names::find(self.module, about)) {
            (Some(entry), _) => print::text(&command_help(entry.spec, entry.modes.direct))?,
            (None, Ok((place, parameter))) => print::text(&parameter_help(place, parameter))?,
            (None, Err(message)) => return Ok(wrong(&format!("no command, and {message}"))),
        }
        Ok(Flow::On)
    }
}

fn wrong(message: &str) -> Flow {
    print::error(message);
    Flow::Failed(Code::Usage)
}

fn failed(client: &AnyClient, error: &ClientError) -> Flow {
    let failure = told(client, error);
    print::error(failure.message());
    Flow::Failed(failure.code())
}

/// Command, bytes, status, value and what it is.
fn line_of(it: &Exchange) -> String {
    let (command, sent, status) = (&it.command, &it.sent, it.status_text());
    let (value, meaning) = (it.value_text(), &it.meaning);
    let meaning = if meaning.is_empty() { String::new() } else { format!("  {meaning}") };
    format!("{command:22}  {sent}  {status:8}  {value}{meaning}").trim_end().to_owned()
}

/// Those that a host can send.
fn mnemonics(module: &ModuleSpec) -> String {
    let direct = module.commands.iter().filter(|entry| entry.modes.direct && !entry.spec.mnemonic.is_empty());
    direct.map(|entry| entry.spec.mnemonic).collect::<Vec<_>>().join(" ")
}

fn command_help(spec: &CommandSpec, is_direct: bool) -> String {
    let mode = if is_direct { "" } else { "\nIt works in stand-alone programs only." };
    let types: String = spec
        .types
        .iter()
        .map(|named| {
            format!(
                "  {:12}  {}\n",
                if named.keyword.is_empty() { named.id } else { named.keyword },
                named.name
            )
        })
        .collect();
    let operands: Vec<&str> = spec.operands.iter().map(|operand| names::operand(spec, *operand)).collect();
    let (mnemonic, operands) = (spec.mnemonic, operands.join(", "));
    format!("{}\n{}.{mode}\n{types}", format!("{mnemonic} {operands}").trim_end(), spec.summary)
}

fn parameter_help(place: Place, parameter: &ParameterSpec) -> String {
    let ParameterSpec { id, summary, unit, access, default, .. } = parameter;
    let Access { write, .. } = access;
    let range = if *write { parameter.write_range } else { parameter.range };
    let values: String = parameter
        .values
        .iter()
        .map(|named| format!("  {:>4}  {:20}  {}\n", named.value, named.id, named.name))
        .collect();
    format!("{id}: {place}\n{summary}.\n{range} {unit}; {access}; {default} from the factory\n{values}")
}
