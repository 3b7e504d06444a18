//! What the module takes: the operands of an instruction against the module's tables.
//!
//! An operand that was complained about before is not there any more, so that nothing is said twice.

mod fields;
mod parameters;
mod ports;
mod values;

use tmcl_tables::{Command, MODULES, ModuleSpec, MotorField, TypeField, ValueField};

use super::builder::Read;
use super::names::Number;
use super::operand::At;
use crate::diagnostic::Diagnostic;

/// What is wrong with an instruction for a module; without one, only what is wrong anywhere.
pub(super) fn check(module: Option<&'static ModuleSpec>, read: &Read) -> Vec<Diagnostic> {
    let Some(module) = module else { return values::fits(read).into_iter().collect() };
    let mut complaints = Vec::new();
    if let Some(motor) = fields::motor(module, read) {
        let is_other_command = motor.suggestion.is_some();
        complaints.push(motor);
        if is_other_command {
            return complaints;
        }
    }
    match read.spec.type_field {
        TypeField::AxisParameter | TypeField::GlobalParameter => {
            complaints.extend(parameters::check(module, read));
        }
        TypeField::Port => complaints.extend(ports::check(module, read)),
        TypeField::Coordinate => complaints.extend(fields::coordinate(module, read)),
        TypeField::Interrupt => complaints.extend(fields::interrupt(module, read)),
        TypeField::Unused | TypeField::Named => {}
    }
    complaints.extend(value(module, read));
    complaints
}

/// What is wrong with the value. Those of parameters and ports are looked at with them.
fn value(module: &'static ModuleSpec, read: &Read) -> Option<Diagnostic> {
    match read.spec.value_field {
        ValueField::ParameterValue | ValueField::PortValue => None,
        ValueField::Velocity => values::velocity(module, read),
        ValueField::Address => values::address(module, read),
        ValueField::Position if moves_to_coordinate(read) => fields::coordinate_to_move_to(module, read),
        ValueField::Ticks => values::fits(read).or_else(|| values::ticks(read)),
        _ => values::fits(read),
    }
}

fn moves_to_coordinate(read: &Read) -> bool {
    is_type(read, "coordinate")
}

/// Whether the type is the one with this identifier.
fn is_type(read: &Read, id: &str) -> bool {
    let named = |kind: At<u8>| read.spec.types.iter().find(|named| named.value == kind.value);
    read.kind.and_then(named).is_some_and(|named| named.id == id)
}

/// Whether the motor byte must name a motor: with WAIT TICKS it means nothing (TMCM-1311 §5.7.22).
fn names_motor(read: &Read) -> bool {
    match read.spec.motor_field {
        MotorField::Motor => read.spec.command != Command::Wait || !is_type(read, "ticks"),
        MotorField::CoordinateStore => true,
        MotorField::Unused | MotorField::Bank => false,
    }
}

/// The 32 bits of a number, None where it does not fit them. What people write in hexadecimal is bits.
pub(super) fn bits(number: Number, is_unsigned: bool) -> Option<i32> {
    let signed = i32::try_from(number.value).ok();
    let unsigned = u32::try_from(number.value).ok().filter(|_| is_unsigned || number.is_hexadecimal);
    signed.or(unsigned.map(u32::cast_signed))
}

/// The 32 bits that stand in the instruction; 0 for what was complained about.
pub(super) fn wrapped(number: Number) -> i32 {
    bits(number, true).unwrap_or_default()
}

/// Says what a name stands for, below the operand.
fn label_value(diagnostic: Diagnostic, number: Number) -> Diagnostic {
    if number.is_named { diagnostic.label(format!("this is {}", number.value)) } else { diagnostic }
}

/// The names of the modules that have something.
pub(super) fn modules_with(has: impl Fn(&ModuleSpec) -> bool) -> Vec<&'static str> {
    MODULES.iter().filter(|module| has(module)).map(|module| module.name).collect()
}
