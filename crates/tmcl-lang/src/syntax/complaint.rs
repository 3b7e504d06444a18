//! The words for text that makes no sense: what was found, and what is expected.

use super::command::command;
use super::number::BadNumber;
use super::token::TokenKind;
use super::tree::{Name, Operand};
use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// How many characters of the file a message repeats.
const SHOWN: usize = 32;

/// A token that should not be where it is.
#[derive(Clone, Copy)]
pub(super) struct Found<'a> {
    pub(super) kind: TokenKind,
    pub(super) text: &'a [u8],
}

/// Something else than `expected`; nothing found is the end of the line.
pub(super) fn unexpected(span: Span, found: Option<Found<'_>>, expected: &str) -> Diagnostic {
    let Some(found) = found else {
        let message = format!("expected {expected}, found the end of the line");
        return Diagnostic::new(Code::UnexpectedToken, span, message).label(format!("expected {expected}"));
    };
    let text = shown(found.text);
    if found.kind == TokenKind::Unknown {
        let message = format!("`{text}` has no meaning here");
        let diagnostic =
            Diagnostic::new(Code::UnexpectedCharacter, span, message).label(format!("expected {expected}"));
        return match unknown_note(found.text) {
            Some(note) => diagnostic.note(note),
            None => diagnostic,
        };
    }
    let message = format!("expected {expected}, found `{text}`");
    let diagnostic =
        Diagnostic::new(Code::UnexpectedToken, span, message).label(format!("expected {expected}"));
    if found.kind == TokenKind::Minus { diagnostic.note(NO_ARITHMETIC) } else { diagnostic }
}

const NO_ARITHMETIC: &str = "program text has no arithmetic, only a minus before an operand";

/// What is worth knowing about bytes without a meaning.
fn unknown_note(text: &[u8]) -> Option<&'static str> {
    match text {
        [b'#', ..] => Some("the only word that begins with `#` is `#include`"),
        b"+" | b"*" | b"/" | b"%" | b"(" => Some(NO_ARITHMETIC),
        b"." => Some("numbers are whole"),
        b"\"" => Some("only the name of an included file stands in quotes"),
        [first, ..] if !first.is_ascii() => {
            Some("names are made of the letters A to Z, digits and `_`; comments may hold anything")
        }
        _ => None,
    }
}

/// A number token that is none, or none of 32 bits.
pub(super) fn bad_number(span: Span, text: &[u8], bad: BadNumber) -> Diagnostic {
    let number = shown(text);
    let diagnostic = match bad {
        BadNumber::TooLarge => {
            Diagnostic::new(Code::NumberTooLarge, span, format!("`{number}` does not fit 32 bits"))
        }
        _ => Diagnostic::new(Code::UnexpectedCharacter, span, format!("`{number}` is no number")),
    };
    let diagnostic = diagnostic.label(bad.to_string());
    if bad == BadNumber::NotDecimal && text.iter().all(u8::is_ascii_hexdigit) {
        return diagnostic.note(format!("hexadecimal it would be `${number}`"));
    }
    diagnostic
}

/// An unterminated or empty path.
pub(super) fn bad_path(span: Span, path: &str) -> Diagnostic {
    let message = format!("expected the name of a file, found `{}`", shown(path.as_bytes()));
    let diagnostic = Diagnostic::new(Code::UnexpectedToken, span, message);
    if path == "\"\"" {
        return diagnostic.label("nothing stands between the quotes");
    }
    if path == "\"" {
        return diagnostic.label("a quote opens here and is not closed");
    }
    let end = Span { start: span.end, ..span };
    diagnostic.label("expected a closing `\"`").suggest(end, "\"", "close the quotes")
}

/// Operands that follow one another without a comma.
pub(super) fn missing_comma(span: Span, bytes: &[u8], mnemonic: &Name, operands: &[Operand]) -> Diagnostic {
    let text = |span: Span| String::from_utf8_lossy(bytes.get(span.range()).unwrap_or_default());
    let found = shown(text(span).as_bytes());
    let message = format!("expected `,` or the end of the line, found `{found}`");
    let diagnostic = Diagnostic::new(Code::UnexpectedToken, span, message).label("expected `,` before this");
    let (Some(first), Some(last)) = (operands.first(), operands.last()) else { return diagnostic };
    let names: Vec<_> = operands.iter().map(|operand| text(operand.span)).collect();
    let is_command = |name: &str| command(name).is_some();
    if !is_command(&mnemonic.text) && names.first().is_some_and(|name| is_command(name)) {
        let label = format!("{}:", mnemonic.text);
        return diagnostic.suggest(mnemonic.span, label, "a label ends with a colon");
    }
    diagnostic.suggest(first.span.to(last.span), names.join(", "), "operands are separated by commas")
}

/// Bytes for a message: visible, on one line, not too long.
fn shown(bytes: &[u8]) -> String {
    let visible = |character: char| match character {
        '"' | '\'' | '\\' => character.to_string(),
        _ => character.escape_debug().to_string(),
    };
    let text: String = match core::str::from_utf8(bytes) {
        Ok(text) => text.chars().map(visible).collect(),
        Err(_) => bytes.escape_ascii().to_string(),
    };
    if text.chars().count() <= SHOWN { text } else { text.chars().take(SHOWN).chain(['…']).collect() }
}
