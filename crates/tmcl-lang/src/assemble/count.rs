//! How many operands a command takes.

use tmcl_tables::{Command, CommandSpec, MotorField, NamedType, Operand as Field, TypeField, ValueField};

use super::words;
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::instruction::ALL;
use crate::source::Span;
use crate::syntax::{InstructionSyntax, Operand, OperandKind};

/// The complaint where there are too many operands or too few.
pub(super) fn check(spec: &CommandSpec, syntax: &InstructionSyntax) -> Option<Diagnostic> {
    let (takes, given) = (spec.operands.len(), syntax.operands.len());
    if given == takes || lacks_only_an_ignored_value(spec, &syntax.operands) {
        return None;
    }
    if let Some(surplus) = syntax.operands.get(takes) {
        return surplus_operand(spec, syntax, surplus);
    }
    let missing: Vec<String> =
        spec.operands.iter().skip(given).map(|field| noun(spec, *field).to_owned()).collect();
    let verb = if missing.len() == 1 { "is" } else { "are" };
    let label = format!("{} {verb} missing", words::list(&missing, "and"));
    Some(wrong_count(spec, given, syntax.span).label(label))
}

/// CALC NOT does not use its number, so it need not be written.
fn lacks_only_an_ignored_value(spec: &CommandSpec, operands: &[Operand]) -> bool {
    let is_not = |named: &NamedType, operand: &Operand| match &operand.kind {
        OperandKind::Name(name) => named.keyword.eq_ignore_ascii_case(name),
        OperandKind::Number(number) => u32::from(named.value) == *number,
    };
    let not = spec.types.iter().find(|named| spec.command == Command::Calculate && named.id == "not");
    match (not, operands) {
        (Some(not), [only]) => !only.negated && is_not(not, only),
        _ => false,
    }
}

fn surplus_operand(spec: &CommandSpec, syntax: &InstructionSyntax, surplus: &Operand) -> Option<Diagnostic> {
    let takes = spec.operands.len();
    let last = syntax.operands.last().unwrap_or(surplus);
    let span = surplus.span.to(last.span);
    if syntax.operands.len() != takes + 1 || !reads(spec.command) {
        return Some(wrong_count(spec, syntax.operands.len(), span).label("more than it takes"));
    }
    if spec.motor_field == MotorField::CoordinateStore && is_copying_form(&syntax.operands) {
        return None;
    }
    let before = takes.checked_sub(1).and_then(|last| syntax.operands.get(last));
    let from = before.map_or(surplus.span, |before| Span { start: before.span.end, ..surplus.span });
    let message = format!("{} takes no value; this operand is ignored", spec.mnemonic);
    let diagnostic = Diagnostic::new(Code::SurplusOperand, surplus.span, message).note(usage(spec));
    Some(diagnostic.suggest(from.to(surplus.span), "", "leave the operand out"))
}

/// Commands whose value the manuals print now and then, although it means nothing: `GAP 1, 0, 0` (TMCM-1311 §5.7.18).
fn reads(command: Command) -> bool {
    matches!(
        command,
        Command::GetAxisParameter | Command::GetGlobalParameter | Command::GetInput | Command::GetCoordinate
    )
}

/// `GCO n, 255, 0`, as TMCM-1311 §5.7.25 prints it.
fn is_copying_form(operands: &[Operand]) -> bool {
    matches!(
        operands,
        [
            _,
            Operand { negated: false, kind: OperandKind::Number(motor), .. },
            Operand { kind: OperandKind::Number(0), .. }
        ] if *motor == u32::from(ALL)
    )
}

fn wrong_count(spec: &CommandSpec, given: usize, span: Span) -> Diagnostic {
    let takes = match spec.operands.len() {
        0 => "no operands".to_owned(),
        1 => "1 operand".to_owned(),
        count => format!("{count} operands"),
    };
    let message = format!("{} takes {takes}, not {given}", spec.mnemonic);
    Diagnostic::new(Code::OperandCount, span, message).note(usage(spec))
}

/// What a command takes, in words and as a pattern.
pub(super) fn usage(spec: &CommandSpec) -> String {
    let mnemonic = spec.mnemonic;
    if spec.operands.is_empty() {
        return format!("{mnemonic} stands alone");
    }
    let nouns: Vec<&str> = spec.operands.iter().map(|field| noun(spec, *field)).collect();
    let patterns: Vec<String> = spec.operands.iter().map(|field| pattern(spec, *field)).collect();
    format!("{mnemonic} takes {}: `{mnemonic} {}`", words::list(&nouns, "and"), patterns.join(", "))
}

/// What an operand is, with its article.
pub(super) fn noun(spec: &CommandSpec, field: Field) -> &'static str {
    match field {
        Field::Type => match spec.type_field {
            TypeField::Unused => "a type",
            TypeField::Named => "a keyword",
            TypeField::AxisParameter | TypeField::GlobalParameter => "a parameter",
            TypeField::Port => "a port",
            TypeField::Coordinate => "a coordinate",
            TypeField::Interrupt => "an interrupt",
        },
        Field::Motor => match spec.motor_field {
            MotorField::Bank => "a bank",
            MotorField::Unused | MotorField::Motor | MotorField::CoordinateStore => "a motor",
        },
        Field::Value => match spec.value_field {
            ValueField::Velocity => "a velocity",
            ValueField::Position | ValueField::CoordinateValue => "a position",
            ValueField::Number => "a number",
            ValueField::Address => "a label",
            ValueField::Ticks => "a number of ticks",
            ValueField::Motor => "a motor",
            ValueField::Unused | ValueField::ParameterValue | ValueField::PortValue | ValueField::Magic => {
                "a value"
            }
        },
    }
}

fn pattern(spec: &CommandSpec, field: Field) -> String {
    const MOST_KEYWORDS: usize = 5;
    if field == Field::Type && !spec.types.is_empty() && spec.types.len() <= MOST_KEYWORDS {
        let keywords: Vec<&str> = spec.types.iter().map(|named| named.keyword).collect();
        return format!("<{}>", keywords.join("|"));
    }
    let noun = noun(spec, field);
    let bare = noun.trim_start_matches("an ").trim_start_matches("a ");
    format!("<{}>", bare.trim_start_matches("number of "))
}

#[cfg(test)]
mod tests {
    use tmcl_tables::commands;

    use super::*;

    #[test]
    fn every_command_says_what_it_takes() {
        let usages = commands::COMMANDS.iter().filter(|spec| !spec.mnemonic.is_empty()).map(usage);
        insta::assert_snapshot!(usages.collect::<Vec<_>>().join("\n"));
    }
}
