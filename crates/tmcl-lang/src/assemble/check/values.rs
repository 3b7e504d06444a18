//! Numbers, velocities, addresses and times.

use tmcl_tables::{ModuleSpec, ValueField};

use super::{bits, is_type, label_value};
use crate::assemble::builder::Read;
use crate::code::Code;
use crate::diagnostic::Diagnostic;

/// The axis parameter that ROR and ROL set.
const TARGET_VELOCITY: u8 = 2;

/// The complaint where the value does not fit 32 bits.
pub(super) fn fits(read: &Read) -> Option<Diagnostic> {
    let value = read.value?;
    if bits(value.value, takes_unsigned(read)).is_some() {
        return None;
    }
    let message = format!("{} does not fit 32 bits with a sign", value.value.value);
    let diagnostic = Diagnostic::new(Code::OperandRange, value.span, message).note(format!(
        "the value takes {}…{}",
        i32::MIN,
        i32::MAX
    ));
    let beyond = (i64::from(i32::MAX) + 1..=i64::from(u32::MAX)).contains(&value.value.value);
    let diagnostic = label_value(diagnostic, value.value);
    Some(if beyond { diagnostic.note("numbers in hexadecimal may use all 32 bits") } else { diagnostic })
}

/// Whether the value may be that of an unsigned parameter, for all we know.
fn takes_unsigned(read: &Read) -> bool {
    read.spec.value_field == ValueField::ParameterValue
}

/// The complaint where a velocity is none that the target velocity takes.
pub(super) fn velocity(module: &ModuleSpec, read: &Read) -> Option<Diagnostic> {
    let value = read.value?;
    let Some(target) = module.axis_parameter(TARGET_VELOCITY) else { return fits(read) };
    if bits(value.value, target.unsigned).is_some_and(|bits| target.allows_write(bits)) {
        return None;
    }
    let message = format!("the {} does not run at a velocity of {}", module.name, value.value.value);
    let diagnostic = Diagnostic::new(Code::ValueRange, value.span, message);
    let note = format!("{} takes {} {}", read.spec.mnemonic, target.write_range, target.unit);
    Some(label_value(diagnostic, value.value).note(note.trim_end()))
}

/// The complaint where an address is outside the program memory. Whether an instruction is there is the lint's business.
pub(super) fn address(module: &ModuleSpec, read: &Read) -> Option<Diagnostic> {
    let value = read.value?;
    let memory = i64::from(module.program_memory);
    // A label beyond the memory belongs to a program that is too long, which is complained about as a whole.
    if (0..memory).contains(&value.value.value) || value.value.is_label {
        return None;
    }
    let message = format!("{} is no address in the program memory of the {}", value.value.value, module.name);
    let diagnostic = Diagnostic::new(Code::ValueRange, value.span, message);
    Some(label_value(diagnostic, value.value).note(format!("addresses are 0…{}", memory - 1)))
}

/// The warning where a time is negative; WAIT TICKS with -1 waits as long as the accumulator says.
pub(super) fn ticks(read: &Read) -> Option<Diagnostic> {
    let (kind, value) = (read.kind?, read.value?);
    let ticks = bits(value.value, false)?;
    if ticks >= 0 || ticks == -1 && is_type(read, "ticks") {
        return None;
    }
    let named = read.spec.types.iter().find(|named| named.value == kind.value)?;
    let message = format!("{} is no time to wait", value.value.value);
    let diagnostic = label_value(Diagnostic::new(Code::NegativeTime, value.span, message), value.value);
    Some(diagnostic.note(if is_type(read, "ticks") {
        "times are in ticks of 10 ms; -1 takes them from the accumulator".to_owned()
    } else {
        let (mnemonic, keyword) = (read.spec.mnemonic, named.keyword);
        format!("{mnemonic} {keyword} takes a timeout in ticks of 10 ms, and 0 for none")
    }))
}
