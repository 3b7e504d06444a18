//! What a line asks for: mnemonics, operands and keywords as the tables of a module have them.

use tmcl_tables::{
    Command, CommandSpec, Group, ModuleCommand, ModuleSpec, Operand, Status, TypeField, ValueField,
};

use super::number::Number;
use crate::Request;

/// What a command line asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// The same as this request. RUN and STOP, which have no mnemonic elsewhere, are 129 and 128.
    Request(Request),
    /// BIN: the port shall be binary again.
    Binary,
}

/// The words of a line: separated by blanks, with at most one comma among them. Two commas have an empty word between them, and
/// a comma at the end has one behind it.
struct Words<'a> {
    rest: Option<&'a [u8]>,
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?.trim_ascii_start();
        let end = rest.iter().position(|byte| *byte == b',' || byte.is_ascii_whitespace());
        let (word, behind) = rest.split_at(end.unwrap_or(rest.len()));
        self.rest = match behind.trim_ascii_start() {
            [] => None,
            [b',', behind @ ..] => Some(behind),
            behind => Some(behind),
        };
        Some(word)
    }
}

/// What the text behind the address letter asks for.
pub(super) fn input(text: &[u8], module: &ModuleSpec) -> Result<Input, Status> {
    let mut words = Words { rest: Some(text) };
    let mnemonic = words.next().unwrap_or_default();
    let is = |name: &str| mnemonic.eq_ignore_ascii_case(name.as_bytes());
    if is("BIN") {
        return nothing_more(words).map(|()| Input::Binary);
    }
    let request = if is("RUN") {
        run(words)?
    } else if is("STOP") {
        nothing_more(words)?;
        Request::new(Command::ApplicationStop, 0, 0, 0)
    } else {
        let mut commands = module.commands.iter();
        let entry = commands.find(|entry| !entry.spec.mnemonic.is_empty() && is(entry.spec.mnemonic));
        request(entry.ok_or(Status::InvalidCommand)?, module, words)?
    };
    Ok(Input::Request(request))
}

/// RUN, from where the program stands or from an address.
fn run(mut words: Words) -> Result<Request, Status> {
    let Some(address) = words.next() else { return Ok(Request::new(Command::ApplicationRun, 0, 0, 0)) };
    let address = Number::read(address).and_then(|number| number.bits(false)).ok_or(Status::InvalidValue)?;
    nothing_more(words)?;
    Ok(Request::new(Command::ApplicationRun, 1, 0, address))
}

fn nothing_more(mut words: Words) -> Result<(), Status> {
    if words.next().is_none() { Ok(()) } else { Err(Status::InvalidValue) }
}

fn request(entry: &ModuleCommand, module: &ModuleSpec, mut words: Words) -> Result<Request, Status> {
    if !entry.modes.direct {
        return Err(Status::NotAvailable);
    }
    let spec = entry.spec;
    let mut request = Request::new(spec.command, 0, 0, 0);
    for operand in spec.operands {
        match words.next() {
            Some(word) => take(*operand, word, &mut request, entry, module)?,
            None if may_be_left_out(*operand, &request, spec) => break,
            None => return Err(complaint(*operand)),
        }
    }
    // Where the manuals print a value that means nothing, `GAP 1, 0, 0`, it is sent along as in the binary form.
    if spec.operands == [Operand::Type, Operand::Motor]
        && spec.value_field == ValueField::Unused
        && let Some(word) = words.next()
    {
        take(Operand::Value, word, &mut request, entry, module)?;
    }
    nothing_more(words)?;
    Ok(request)
}

/// Takes a word as an operand.
fn take(
    operand: Operand,
    word: &[u8],
    request: &mut Request,
    entry: &ModuleCommand,
    module: &ModuleSpec,
) -> Result<(), Status> {
    let keyword = entry.named_types().find(|named| {
        operand == Operand::Type
            && !named.keyword.is_empty()
            && word.eq_ignore_ascii_case(named.keyword.as_bytes())
    });
    if let Some(named) = keyword {
        request.kind = named.value;
        return Ok(());
    }
    let number = Number::read(word);
    let taken = match operand {
        Operand::Type => number.and_then(Number::byte).map(|kind| request.kind = kind),
        Operand::Motor => number.and_then(Number::byte).map(|motor| request.motor = motor),
        Operand::Value => {
            let unsigned = is_unsigned(request, entry.spec, module);
            number.and_then(|number| number.bits(unsigned)).map(|value| request.value = value)
        }
    };
    taken.ok_or(complaint(operand))
}

/// Whether the value is one of 32 bits without a sign.
fn is_unsigned(request: &Request, spec: &CommandSpec, module: &ModuleSpec) -> bool {
    let parameter = match (spec.value_field, spec.type_field) {
        (ValueField::ParameterValue, TypeField::AxisParameter) => module.axis_parameter(request.kind),
        (ValueField::ParameterValue, TypeField::GlobalParameter) => {
            module.global_parameter(request.motor, request.kind).map(|entry| &entry.parameter)
        }
        _ => None,
    };
    parameter.is_some_and(|parameter| parameter.unsigned)
}

/// A user function takes what it wants, and CALC NOT does not use its number.
fn may_be_left_out(operand: Operand, request: &Request, spec: &CommandSpec) -> bool {
    let is_not = spec.types.iter().any(|named| named.value == request.kind && named.id == "not");
    spec.group == Group::User || (operand == Operand::Value && is_not)
}

/// The status that a wrong or missing operand deserves.
fn complaint(operand: Operand) -> Status {
    match operand {
        Operand::Type => Status::WrongType,
        Operand::Motor | Operand::Value => Status::InvalidValue,
    }
}
