//! Motors, coordinates and interrupts.

use tmcl_tables::{Command, ModuleSpec, MotorField};

use super::{label_value, names_motor};
use crate::assemble::builder::Read;
use crate::assemble::words;
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::instruction::ALL;

/// The complaint where there is no such motor: each module has motor 0 only.
pub(super) fn motor(module: &ModuleSpec, read: &Read) -> Option<Diagnostic> {
    let motor = read.motor?;
    let is_eeprom = read.spec.motor_field == MotorField::CoordinateStore && motor.value == ALL;
    if motor.value == 0 || is_eeprom || !names_motor(read) {
        return None;
    }
    let message = format!("the {} has no motor {}", module.name, motor.value);
    let diagnostic = Diagnostic::new(Code::UnknownMotor, motor.span, message);
    let diagnostic = match read.spec.motor_field {
        MotorField::CoordinateStore => {
            diagnostic.note(format!("its only motor is 0; {ALL} copies between RAM and EEPROM"))
        }
        _ => diagnostic.note("its only motor is 0"),
    };
    Some(match global_counterpart(module, read) {
        Some((global, note)) => diagnostic.note(note).suggest(
            read.mnemonic,
            global,
            "the same for global parameters, if that is meant",
        ),
        None => diagnostic,
    })
}

/// The command for global parameters that must be meant where an axis command has a bank in place of its motor, as in the
/// slip `AAP MyVariable, 2` of TMCM-1311 §11.4.
fn global_counterpart(module: &ModuleSpec, read: &Read) -> Option<(&'static str, String)> {
    let global = match read.spec.command {
        Command::SetAxisParameter => Command::SetGlobalParameter,
        Command::GetAxisParameter => Command::GetGlobalParameter,
        Command::StoreAxisParameter => Command::StoreGlobalParameter,
        Command::RestoreAxisParameter => Command::RestoreGlobalParameter,
        Command::AccumulatorToAxisParameter => Command::AccumulatorToGlobalParameter,
        _ => return None,
    };
    let mnemonic = module.command(global.number())?.spec.mnemonic;
    let (number, bank) = (read.kind?.value, read.motor?.value);
    let parameter = module.global_parameter(bank, number)?.parameter;
    let title = format!("`{mnemonic} {number}, {bank}`");
    let name = parameter.name.to_lowercase();
    let what = match bank {
        2 => format!("{name} {number}"),
        _ => format!("global parameter {number} of bank {bank} ({})", parameter.name),
    };
    Some((mnemonic, format!("{title} is the form for {what}")))
}

/// The complaint where there is no such coordinate.
pub(super) fn coordinate(module: &ModuleSpec, read: &Read) -> Option<Diagnostic> {
    let kind = read.kind?;
    if kind.value < module.coordinates {
        return None;
    }
    let message = format!("the {} has no coordinate {}", module.name, kind.value);
    Some(Diagnostic::new(Code::UnknownCoordinate, kind.span, message).note(coordinates(module)))
}

/// The same for the value of MVP COORD.
pub(super) fn coordinate_to_move_to(module: &ModuleSpec, read: &Read) -> Option<Diagnostic> {
    let value = read.value?;
    if (0..i64::from(module.coordinates)).contains(&value.value.value) {
        return None;
    }
    let message = format!("the {} has no coordinate {}", module.name, value.value.value);
    let diagnostic = Diagnostic::new(Code::UnknownCoordinate, value.span, message);
    Some(label_value(diagnostic, value.value).note(coordinates(module)))
}

fn coordinates(module: &ModuleSpec) -> String {
    match module.coordinates.checked_sub(1) {
        Some(last) => format!("coordinates are 0…{last}"),
        None => "it has no coordinates at all".to_owned(),
    }
}

/// The complaint where there is no such interrupt; EI and DI also take all of them.
pub(super) fn interrupt(module: &ModuleSpec, read: &Read) -> Option<Diagnostic> {
    let kind = read.kind?;
    let takes_all = read.spec.command != Command::SetInterruptVector;
    if module.interrupt(kind.value).is_some() || kind.value == ALL && takes_all {
        return None;
    }
    let message = match kind.value {
        ALL => format!("{ALL} stands for all interrupts and has no routine of its own"),
        number => format!("the {} has no interrupt {number}", module.name),
    };
    let diagnostic = Diagnostic::new(Code::UnknownInterrupt, kind.span, message);
    let numbers = words::numbers(module.interrupts.iter().map(|interrupt| interrupt.number));
    let all = if takes_all { format!("; {ALL} stands for all of them") } else { String::new() };
    Some(diagnostic.note(format!("interrupts are {numbers}{all}")))
}
