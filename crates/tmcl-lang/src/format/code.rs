//! The text of labels and statements.

use super::pad;
use crate::source::Span;
use crate::syntax::{Constant, InstructionSyntax, Line, Operand, OperandKind, Statement, command, is_space};

/// Instructions begin at a multiple of this.
const STEP: usize = 4;

/// Labels that would push the instructions farther than this push only their own.
const LARGEST_COLUMN: usize = 16;

/// Where the instructions of a file begin: just as far in that they have room behind labels on the same line.
pub(super) fn column(lines: &[Line]) -> usize {
    let has_code = |line: &&Line| line.statement.is_some() && !line.has_errors;
    let widths = lines.iter().filter(has_code).map(|line| labels(line).len() + 1);
    let widest = widths.filter(|width| *width <= LARGEST_COLUMN).max().unwrap_or(0);
    widest.next_multiple_of(STEP).max(STEP)
}

/// The labels and the statement of a line, with the instruction at `column`.
pub(super) fn code(bytes: &[u8], line: &Line, column: usize) -> Vec<u8> {
    let mut out = labels(line).into_bytes();
    let Some(statement) = &line.statement else { return out };
    if !out.is_empty() {
        let spaces = column.saturating_sub(out.len()).max(1);
        pad(&mut out, spaces);
    } else if matches!(statement, Statement::Instruction(_)) {
        pad(&mut out, column);
    }
    let text = |span: Span| bytes.get(span.range()).unwrap_or_default();
    match statement {
        Statement::Instruction(syntax) => instruction(syntax, text, &mut out),
        Statement::Constant(Constant { name, value }) => {
            out.extend_from_slice(name.text.as_bytes());
            out.extend_from_slice(b" = ");
            operand(value, text, &mut out);
        }
        Statement::Include(include) => {
            out.extend_from_slice(b"#include ");
            out.extend_from_slice(text(include.path.span));
        }
    }
    out
}

fn labels(line: &Line) -> String {
    let labels: Vec<_> = line.labels.iter().map(|label| format!("{}:", label.text)).collect();
    labels.join(" ")
}

fn instruction<'a>(syntax: &InstructionSyntax, text: impl Fn(Span) -> &'a [u8], out: &mut Vec<u8>) {
    let spec = command(&syntax.mnemonic.text);
    out.extend_from_slice(spec.map_or(&*syntax.mnemonic.text, |spec| spec.mnemonic).as_bytes());
    let mut types = spec.into_iter().flat_map(|spec| {
        spec.operands.iter().map(|kind| if *kind == tmcl_tables::Operand::Type { spec.types } else { &[] })
    });
    for (index, syntax) in syntax.operands.iter().enumerate() {
        out.extend_from_slice(if index == 0 { b" " } else { b", " });
        let keywords = types.next().unwrap_or_default();
        match keyword(syntax, keywords) {
            Some(keyword) => out.extend_from_slice(keyword.as_bytes()),
            None => operand(syntax, &text, out),
        }
    }
}

/// The keyword that an operand is.
fn keyword(operand: &Operand, keywords: &[tmcl_tables::NamedType]) -> Option<&'static str> {
    let OperandKind::Name(name) = &operand.kind else { return None };
    let mut keywords = keywords.iter().map(|named| named.keyword);
    keywords.find(|keyword| keyword.eq_ignore_ascii_case(name) && !operand.negated)
}

/// An operand as it is written, but for spaces behind its minus.
fn operand<'a>(operand: &Operand, text: impl Fn(Span) -> &'a [u8], out: &mut Vec<u8>) {
    let kept = text(operand.span).iter().filter(|byte| !is_space(**byte));
    out.extend(kept);
}
