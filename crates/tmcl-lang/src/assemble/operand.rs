//! What each operand stands for.

use tmcl_tables::{CommandSpec, NamedType, Operand as Field, TypeField, ValueField};

use super::builder::{Builder, Read};
use super::count;
use super::names::Number;
use super::words;
use crate::builtin::BuiltinName;
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::{InstructionSyntax, Operand, OperandKind};

/// A value and where it is written.
#[derive(Clone, Copy, Debug)]
pub(super) struct At<T> {
    pub(super) value: T,
    pub(super) span: Span,
}

impl Builder<'_> {
    /// Reads the operands of a command, those that it does not take too: what they name is used.
    pub(super) fn operands(&mut self, spec: &'static CommandSpec, syntax: &InstructionSyntax) -> Read {
        let mut read = Read { spec, mnemonic: syntax.mnemonic.span, kind: None, motor: None, value: None };
        for (index, operand) in syntax.operands.iter().enumerate() {
            let span = operand.span;
            match spec.operands.get(index) {
                Some(Field::Type) => read.kind = self.kind(spec, operand).map(|value| At { value, span }),
                Some(Field::Motor) => {
                    let noun = count::noun(spec, Field::Motor);
                    read.motor = self.byte(spec.mnemonic, operand, noun).map(|value| At { value, span });
                }
                Some(Field::Value) if spec.value_field == ValueField::Address => {
                    read.value = self.address(spec, operand).map(|value| At { value, span });
                }
                Some(Field::Value) | None => {
                    let number = self.number(spec.mnemonic, "a number", operand);
                    let is_taken = index < spec.operands.len();
                    read.value = number.filter(|_| is_taken).map(|value| At { value, span }).or(read.value);
                }
            }
        }
        read
    }

    /// The number that a constant shall stand for.
    pub(super) fn constant_value(&mut self, operand: &Operand) -> Option<Number> {
        self.number("a constant", "a number", operand)
    }

    /// A number, or a constant that stands for one. `taker` takes it, and calls it `noun`.
    pub(super) fn number(&mut self, taker: &str, noun: &str, operand: &Operand) -> Option<Number> {
        let name = match &operand.kind {
            OperandKind::Number(number) => return Some(self.literal(*number, operand)),
            OperandKind::Name(name) => name,
        };
        if let Some(constant) = self.names.use_constant(name) {
            return constant.map(|number| signed(Number { is_named: true, ..number }, operand.negated));
        }
        let complaint = match self.names.label(name) {
            Some(label) if self.names.constant_anywhere(name).is_none() => {
                let message =
                    format!("`{}` is a label, but {taker} takes {noun} here", words::shortened(name));
                Diagnostic::new(Code::OperandKind, operand.span, message).also(label, "the label stands here")
            }
            _ => self.undefined_constant(name, operand.span),
        };
        self.complain(complaint);
        None
    }

    fn literal(&self, number: u32, operand: &Operand) -> Number {
        let text = self.text(operand.span);
        let is_hexadecimal = text.iter().any(|byte| matches!(byte, b'$' | b'x' | b'X'));
        signed(
            Number { value: i64::from(number), is_hexadecimal, is_named: false, is_label: false },
            operand.negated,
        )
    }

    fn undefined_constant(&mut self, name: &str, span: Span) -> Diagnostic {
        let shown = words::shortened(name);
        if let Some(below) = self.names.constant_anywhere(name) {
            let message = format!("`{shown}` is not defined yet");
            let diagnostic = Diagnostic::new(Code::UndefinedName, span, message);
            return diagnostic
                .also(below, "defined only here")
                .note("a constant counts below its definition");
        }
        let diagnostic = Diagnostic::new(Code::UndefinedName, span, format!("`{shown}` is not defined"));
        if let Some(file) = self.builtin_file(name) {
            return diagnostic.note(format!("the built-in file {file} defines it: `#include {file}`"));
        }
        let nearest = self.near.nearest(name, self.names.constant_names()).map(str::to_owned);
        let name_span = Span { start: span.end.saturating_sub(length(name)), ..span };
        if let Some(near) = nearest {
            return diagnostic.suggest(name_span, near, "a constant has a similar name");
        }
        match self.near_builtin(name) {
            Some(BuiltinName { name: near, file }) => diagnostic
                .note(format!("the built-in file {file} defines `{near}`: `#include {file}`"))
                .suggest(name_span, near, "a built-in constant has a similar name"),
            None => diagnostic,
        }
    }

    /// A number that fits a byte.
    pub(super) fn byte(&mut self, taker: &str, operand: &Operand, noun: &str) -> Option<u8> {
        let number = self.number(taker, noun, operand)?;
        let byte = u8::try_from(number.value).ok();
        if byte.is_none() {
            let message = format!(
                "{} is too {} for {noun}",
                number.value,
                if number.value < 0 { "small" } else { "large" }
            );
            let diagnostic = Diagnostic::new(Code::OperandRange, operand.span, message);
            self.complain(diagnostic.note("this field is a byte: it takes 0…255"));
        }
        byte
    }

    /// The type byte.
    fn kind(&mut self, spec: &'static CommandSpec, operand: &Operand) -> Option<u8> {
        match spec.type_field {
            TypeField::Named => self.named_type(spec, operand),
            _ => self.byte(spec.mnemonic, operand, count::noun(spec, Field::Type)),
        }
    }

    /// A keyword, or a constant or number that is the type of one.
    fn named_type(&mut self, spec: &'static CommandSpec, operand: &Operand) -> Option<u8> {
        if let OperandKind::Name(name) = &operand.kind {
            let is_keyword = |named: &&NamedType| named.keyword.eq_ignore_ascii_case(name);
            if let Some(named) = spec.types.iter().find(is_keyword) {
                return self.known_type(spec, named, operand);
            }
            if self.names.constant_anywhere(name).is_none() {
                let complaint = self.unknown_keyword(spec, name, operand);
                self.complain(complaint);
                return None;
            }
        }
        let number = self.number(spec.mnemonic, "a keyword", operand)?;
        match spec.types.iter().find(|named| i64::from(named.value) == number.value) {
            Some(named) => self.known_type(spec, named, &Operand { negated: false, ..operand.clone() }),
            None => {
                let message = format!("{} has no type {}", spec.mnemonic, number.value);
                let note = self.allowed_types(spec);
                self.complain(Diagnostic::new(Code::OperandKind, operand.span, message).note(note));
                None
            }
        }
    }

    /// A type of the family, if the module has it.
    fn known_type(&mut self, spec: &'static CommandSpec, named: &NamedType, operand: &Operand) -> Option<u8> {
        if operand.negated {
            let message = format!("there is a minus before the keyword `{}`", named.keyword);
            self.complain(Diagnostic::new(Code::OperandKind, operand.span, message));
            return None;
        }
        let entry = self.module.command(spec.number);
        if self.checks_module && entry.is_some_and(|entry| !entry.types.contains(&named.value)) {
            let (module, mnemonic, keyword) = (self.module.name, spec.mnemonic, named.keyword);
            let message = format!("the {module} has no {mnemonic} {keyword}");
            let note = self.allowed_types(spec);
            self.complain(Diagnostic::new(Code::CommandMissing, operand.span, message).note(note));
            return None;
        }
        Some(named.value)
    }

    /// The types of a command that the module has, or else all of the family.
    fn types(&self, spec: &'static CommandSpec) -> Vec<&'static NamedType> {
        match self.module.command(spec.number) {
            Some(entry) if self.checks_module => entry.named_types().collect(),
            _ => spec.types.iter().collect(),
        }
    }

    fn allowed_types(&self, spec: &'static CommandSpec) -> String {
        let keywords: Vec<&str> = self.types(spec).iter().map(|named| named.keyword).collect();
        format!("{} takes {}", spec.mnemonic, words::list(&keywords, "or"))
    }

    fn unknown_keyword(&mut self, spec: &'static CommandSpec, name: &str, operand: &Operand) -> Diagnostic {
        let (shown, mnemonic) = (words::shortened(name), spec.mnemonic);
        let diagnostic = match self.names.label(name) {
            Some(label) => {
                let message = format!("`{shown}` is a label, but {mnemonic} takes a keyword here");
                Diagnostic::new(Code::OperandKind, operand.span, message).also(label, "the label stands here")
            }
            None => {
                let message = format!("`{shown}` is no keyword of {mnemonic}");
                Diagnostic::new(Code::OperandKind, operand.span, message)
            }
        };
        let diagnostic = diagnostic.note(self.allowed_types(spec));
        let keywords: Vec<&str> = self.types(spec).iter().map(|named| named.keyword).collect();
        match self.near.nearest(name, keywords) {
            Some(near) => diagnostic.suggest(operand.span, near, "a keyword has a similar name"),
            None => diagnostic,
        }
    }

    /// A label, or a number that is an address.
    fn address(&mut self, spec: &CommandSpec, operand: &Operand) -> Option<Number> {
        let OperandKind::Name(name) = &operand.kind else {
            return self.number(spec.mnemonic, "a label", operand);
        };
        if let Some(address) = self.names.use_label(name) {
            if operand.negated {
                let message = format!("there is a minus before the label `{}`", words::shortened(name));
                self.complain(Diagnostic::new(Code::OperandKind, operand.span, message));
                return None;
            }
            return Some(Number {
                value: i64::from(address),
                is_hexadecimal: false,
                is_named: true,
                is_label: true,
            });
        }
        if self.names.constant_anywhere(name).is_some() {
            return self.number(spec.mnemonic, "a label", operand);
        }
        let complaint = self.undefined_label(name, operand.span);
        self.complain(complaint);
        None
    }

    fn undefined_label(&mut self, name: &str, span: Span) -> Diagnostic {
        let message = format!("there is no label `{}`", words::shortened(name));
        let diagnostic = Diagnostic::new(Code::UndefinedLabel, span, message);
        let nearest = self.near.nearest(name, self.names.label_names()).map(str::to_owned);
        match nearest {
            Some(near) => diagnostic.suggest(span, near, "a label has a similar name"),
            None => diagnostic,
        }
    }
}

fn signed(number: Number, is_negated: bool) -> Number {
    if is_negated { Number { value: -number.value, is_hexadecimal: false, ..number } } else { number }
}

fn length(name: &str) -> u32 {
    u32::try_from(name.len()).unwrap_or(u32::MAX)
}
