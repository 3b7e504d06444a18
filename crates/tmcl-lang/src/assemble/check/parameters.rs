//! Axis parameters and global parameters.

use tmcl_tables::{Command, ModuleSpec, ParameterSpec, TypeField};

use super::{bits, label_value, modules_with, values};
use crate::assemble::builder::Read;
use crate::assemble::words;
use crate::code::Code;
use crate::diagnostic::Diagnostic;

/// The bank of the module's settings, among the global parameters.
const SETTINGS_BANK: u8 = 0;

/// What a command does with a parameter.
enum Use {
    Write,
    Read,
    Store,
}

fn use_of(command: Command) -> Use {
    match command {
        Command::GetAxisParameter | Command::GetGlobalParameter => Use::Read,
        Command::StoreAxisParameter
        | Command::RestoreAxisParameter
        | Command::StoreGlobalParameter
        | Command::RestoreGlobalParameter => Use::Store,
        _ => Use::Write,
    }
}

/// A parameter and what messages call it.
struct Parameter {
    spec: &'static ParameterSpec,
    title: String,
}

/// The complaint where there is no such parameter, where it cannot be used so, or where it does not take the value.
pub(super) fn check(module: &'static ModuleSpec, read: &Read) -> Option<Diagnostic> {
    let found = match read.spec.type_field {
        TypeField::AxisParameter => axis(module, read),
        _ => global(module, read),
    };
    match found {
        Ok(Some(parameter)) => access(&parameter, read).or_else(|| value(&parameter, read)),
        Ok(None) => values::fits(read),
        Err(complaint) => Some(*complaint),
    }
}

/// None where its number was complained about before.
fn axis(module: &'static ModuleSpec, read: &Read) -> Result<Option<Parameter>, Box<Diagnostic>> {
    let Some(kind) = read.kind else { return Ok(None) };
    let number = kind.value;
    if let Some(spec) = module.axis_parameter(number) {
        let title = format!("axis parameter {number} ({})", spec.name);
        return Ok(Some(Parameter { spec, title }));
    }
    let message = format!("the {} has no axis parameter {number}", module.name);
    let diagnostic = Diagnostic::new(Code::UnknownParameter, kind.span, message);
    let others = modules_with(|other| other.axis_parameter(number).is_some());
    let verb = if others.len() == 1 { "has" } else { "have" };
    Err(Box::new(match words::list(&others, "and").as_str() {
        "" => diagnostic,
        others => diagnostic.note(format!("the {others} {verb} one")),
    }))
}

/// None where its number or bank was complained about before.
fn global(module: &'static ModuleSpec, read: &Read) -> Result<Option<Parameter>, Box<Diagnostic>> {
    let Some(bank) = read.motor else { return Ok(None) };
    let in_bank = || module.global_parameters.iter().filter(|entry| entry.bank == bank.value);
    if in_bank().next().is_none() {
        let message = format!("the {} has no global parameters in bank {}", module.name, bank.value);
        let banks = words::numbers(module.global_parameters.iter().map(|entry| entry.bank));
        let diagnostic = Diagnostic::new(Code::UnknownParameter, bank.span, message);
        return Err(Box::new(diagnostic.note(format!("the banks are {banks}"))));
    }
    let Some(kind) = read.kind else { return Ok(None) };
    let number = kind.value;
    let place = format!("global parameter {number} in bank {}", bank.value);
    if let Some(entry) = module.global_parameter(bank.value, number) {
        let spec = &entry.parameter;
        return Ok(Some(Parameter { spec, title: format!("{place} ({})", spec.name) }));
    }
    let message = format!("the {} has no {place}", module.name);
    let numbers = words::numbers(in_bank().flat_map(|entry| entry.parameter.number..=entry.last));
    let diagnostic = Diagnostic::new(Code::UnknownParameter, kind.span, message);
    Err(Box::new(diagnostic.note(format!("bank {} has {numbers}", bank.value))))
}

fn access(parameter: &Parameter, read: &Read) -> Option<Diagnostic> {
    let span = read.kind?.span;
    let (title, access) = (&parameter.title, parameter.spec.access);
    let diagnostic = match use_of(read.spec.command) {
        Use::Write if !access.write => {
            Diagnostic::new(Code::ReadOnlyParameter, span, format!("{title} can only be read"))
        }
        Use::Read if !access.read => {
            Diagnostic::new(Code::WriteOnlyParameter, span, format!("{title} can only be written"))
        }
        Use::Store if !access.store && !is_stored_by_writing(read) => {
            Diagnostic::new(Code::NotStorable, span, format!("{title} is not kept in the EEPROM"))
        }
        _ => return None,
    };
    Some(diagnostic.note(format!("its access is {access}: {}", spelled_out(access))))
}

/// Global parameters of bank 0, which need no storing: STGP and RSGP take them all, and do nothing (decision).
fn is_stored_by_writing(read: &Read) -> bool {
    let is_global = read.spec.type_field == TypeField::GlobalParameter;
    is_global && read.motor.is_some_and(|bank| bank.value == SETTINGS_BANK)
}

fn spelled_out(access: tmcl_tables::Access) -> String {
    let letters = [(access.read, "read"), (access.write, "written"), (access.store, "stored")];
    let can: Vec<&str> = letters.iter().filter(|(can, _)| *can).map(|(_, what)| *what).collect();
    format!("it can be {}", words::list(&can, "and"))
}

fn value(parameter: &Parameter, read: &Read) -> Option<Diagnostic> {
    let value = read.value?;
    let spec = parameter.spec;
    if bits(value.value, spec.unsigned).is_some_and(|bits| spec.allows_write(bits)) {
        return None;
    }
    let message = format!("{} does not take {}", parameter.title, value.value.value);
    let diagnostic = Diagnostic::new(Code::ParameterRange, value.span, message);
    let note = format!("it takes {} {}", spec.write_range, spec.unit);
    let diagnostic = label_value(diagnostic, value.value).note(note.trim_end());
    Some(match named_values(spec) {
        Some(names) => diagnostic.note(names),
        None => diagnostic,
    })
}

/// What the values mean, where they have names.
fn named_values(spec: &ParameterSpec) -> Option<String> {
    const MOST: usize = 8;
    let takes = |value: i64| spec.write_range.contains(value);
    let named = spec.values.iter().filter(|named| takes(named.value));
    let names: Vec<String> = named.map(|named| format!("{} = {}", named.value, named.name)).collect();
    (!names.is_empty() && names.len() <= MOST).then(|| names.join(", "))
}
