//! Inputs and outputs.

use tmcl_tables::{Command, Direction, ModuleSpec, PortSpec, ValueSet};

use super::{bits, label_value, values};
use crate::assemble::builder::Read;
use crate::assemble::words;
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::instruction::ALL;

/// The bank whose inputs GIO 255 reads all at once.
const INPUT_BANK: u8 = 0;
/// The bank whose outputs SIO 255 sets all at once.
const OUTPUT_BANK: u8 = 2;

/// What SIO 255 takes: a bit for each output, or -1 for the low byte of the accumulator.
const ALL_OUTPUTS: ValueSet = ValueSet { intervals: &[(-1, 255)], step: 1 };

/// The complaint where there is no such port, where it is an input and shall be set, or where it does not take the value.
pub(super) fn check(module: &'static ModuleSpec, read: &Read) -> Option<Diagnostic> {
    let sets = read.spec.command == Command::SetOutput;
    let Some(bank) = read.motor else { return values::fits(read) };
    let in_bank = || module.ports.iter().filter(|port| port.bank == bank.value);
    if in_bank().next().is_none() {
        let message = format!("the {} has no ports in bank {}", module.name, bank.value);
        return Some(Diagnostic::new(Code::UnknownPort, bank.span, message).note(banks(module, sets)));
    }
    let Some(kind) = read.kind else { return values::fits(read) };
    if kind.value == ALL && bank.value == if sets { OUTPUT_BANK } else { INPUT_BANK } {
        return value(&ALL_OUTPUTS, &format!("SIO {ALL}, which sets all outputs,"), read);
    }
    match module.port(bank.value, kind.value) {
        Some(port) if sets && port.direction == Direction::Input => {
            let message = format!("port {} of bank {} ({}) is an input", port.number, port.bank, port.name);
            Some(Diagnostic::new(Code::UnknownPort, bank.span, message).note(banks(module, sets)))
        }
        Some(port) => value(&port.range, port.name, read),
        None => {
            let message = format!("the {} has no port {} in bank {}", module.name, kind.value, bank.value);
            let numbers = words::numbers(in_bank().map(|port| port.number));
            let diagnostic = Diagnostic::new(Code::UnknownPort, kind.span, message);
            Some(diagnostic.note(format!(
                "bank {} has {numbers}{}",
                bank.value,
                all_at_once(bank.value, sets)
            )))
        }
    }
}

fn all_at_once(bank: u8, sets: bool) -> String {
    match (bank, sets) {
        (OUTPUT_BANK, true) | (INPUT_BANK, false) => format!("; {ALL} stands for all of them"),
        _ => String::new(),
    }
}

fn value(allowed: &ValueSet, name: &str, read: &Read) -> Option<Diagnostic> {
    let value = read.value?;
    if bits(value.value, false).is_some_and(|bits| allowed.contains(i64::from(bits))) {
        return None;
    }
    let message = format!("{name} does not take {}", value.value.value);
    let diagnostic = label_value(Diagnostic::new(Code::ValueRange, value.span, message), value.value);
    Some(diagnostic.note(format!("it takes {allowed}")))
}

/// The banks that have what is wanted.
fn banks(module: &ModuleSpec, sets: bool) -> String {
    let fits = |port: &&PortSpec| !sets || port.direction == Direction::Output;
    let banks = words::numbers(module.ports.iter().filter(fits).map(|port| port.bank));
    match (banks.as_str(), sets) {
        ("", _) => "it has none at all".to_owned(),
        (banks, true) => format!("outputs are in bank {banks}"),
        (banks, false) => format!("its banks are {banks}"),
    }
}
