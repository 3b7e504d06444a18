//! The shell's talk with a module.

use std::time::Duration;

use tmcl_client::ClientError;
use tmcl_config::{Item, Name, parse_value};
use tmcl_link::Link;
use tmcl_tables::{
    CommandSpec, ModuleSpec, MotorField, Operand, ParameterSpec, TypeField, ValueField, ValueSet,
};
use tmcl_wire::Request;

use super::line::{self, Line, WORDS};
use crate::connection::{AnyClient, told};
use crate::direct::{self, Answer, Entered, Exchange, Language, Spoken};
use crate::exit::{Code, Failure};
use crate::{parameters, print};

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
            Ok(Line::Get(names)) => self.get(&names),
            Ok(Line::Set(pairs)) => self.each(&pairs, |session, pair| session.set(*pair)),
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
    fn each<T>(&mut self, items: &[T], one: impl Fn(&mut Self, &T) -> Step) -> Step {
        for item in items {
            match one(self, item)? {
                Flow::On => {}
                other => return Ok(other),
            }
        }
        Ok(Flow::On)
    }

    fn get(&mut self, texts: &[String]) -> Step {
        let is_readable = |item: Item| item.access().read;
        match parameters::named(texts, self.module, is_readable, "can only be written") {
            Ok(names) => self.each(&names, |session, name| session.exchange(direct::reading(name.item), "")),
            Err(failure) => Ok(told_so(&failure)),
        }
    }

    /// Bits are put into what the parameter holds; that is read, and shown, first.
    fn set(&mut self, (name, text): (&str, &str)) -> Step {
        let name = match Name::parse(name, self.module) {
            Ok(name) => name,
            Err(error) => return Ok(wrong(&error.to_string())),
        };
        let items = std::iter::once(name.item);
        let value = parameters::closed_loop(&mut self.client, self.module, items)
            .map(|closed_loop| parse_value(text, &name, closed_loop));
        let value = match value {
            Ok(Ok(value)) => value,
            Ok(Err(error)) => return Ok(wrong(&error.to_string())),
            Err(failure) => return Ok(told_so(&failure)),
        };
        let before = if name.field.is_some() { parameters::read(&mut self.client, name.item) } else { Ok(0) };
        match before.map(|before| name.insert(before, value)) {
            Ok(whole) => match Name::of(name.item).check_whole(whole) {
                Ok(()) => self.exchange(direct::writing(name.item, whole), ""),
                Err(error) => Ok(wrong(&error.to_string())),
            },
            Err(error) => Ok(failed(&self.client, &error)),
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
        match (command, Name::parse(about, self.module)) {
            (Some(entry), _) => print::text(&command_help(entry.spec, entry.modes.direct))?,
            (None, Ok(name)) => print::text(&parameter_help(name.item))?,
            (None, Err(error)) => return Ok(wrong(&format!("no command, and {error}"))),
        }
        Ok(Flow::On)
    }
}

fn wrong(message: &str) -> Flow {
    print::error(message);
    Flow::Failed(Code::Usage)
}

fn told_so(failure: &Failure) -> Flow {
    print::error(failure.message());
    Flow::Failed(failure.code())
}

fn failed(client: &AnyClient, error: &ClientError) -> Flow {
    told_so(&told(client, error))
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
    let operands: Vec<&str> = spec.operands.iter().map(|field| operand(spec, *field)).collect();
    let (mnemonic, operands) = (spec.mnemonic, operands.join(", "));
    format!("{}\n{}.{mode}\n{types}", format!("{mnemonic} {operands}").trim_end(), spec.summary)
}

fn parameter_help(item: Item) -> String {
    let (name, number, title, range, access) =
        (item.name(), item.number(), item.title(), item.range(), item.access());
    let summary = item.spec().map_or_else(String::new, |spec| {
        format!(
            "{}.\n{} {}; {access}; {} from the factory\n",
            spec.summary,
            written(spec),
            spec.unit,
            spec.default
        )
    });
    let summary =
        if summary.is_empty() { format!("{range} {}; {access}\n", item.unit(false)) } else { summary };
    let values =
        item.values().iter().map(|named| format!("  {:>4}  {:20}  {}\n", named.value, named.id, named.name));
    let fields = item.fields().iter().map(|field| format!("  {name}.{}  {}\n", field.id, field.name));
    format!("{name} ({number}): {title}\n{summary}{}", values.chain(fields).collect::<String>())
}

/// What a write may carry, or where there is none, a read.
fn written(spec: &ParameterSpec) -> ValueSet {
    if spec.access.write { spec.write_range } else { spec.range }
}

/// What an operand is, in a word.
fn operand(spec: &CommandSpec, field: Operand) -> &'static str {
    match field {
        Operand::Type => match spec.type_field {
            TypeField::Unused => "TYPE",
            TypeField::Named => "KEYWORD",
            TypeField::AxisParameter | TypeField::GlobalParameter => "PARAMETER",
            TypeField::Port => "PORT",
            TypeField::Coordinate => "COORDINATE",
            TypeField::Interrupt => "INTERRUPT",
        },
        Operand::Motor if spec.motor_field == MotorField::Bank => "BANK",
        Operand::Motor => "MOTOR",
        Operand::Value => match spec.value_field {
            ValueField::Velocity => "VELOCITY",
            ValueField::Position | ValueField::CoordinateValue => "POSITION",
            ValueField::Address => "ADDRESS",
            ValueField::Ticks => "TICKS",
            _ => "VALUE",
        },
    }
}
