//! The tree: lines, and what stands in them.

use core::ops::Range;

use super::token::Token;
use crate::source::Span;

/// A parsed file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// Every byte of the file, cut up.
    pub tokens: Vec<Token>,
    /// The lines; their tokens one after the other are all tokens.
    pub lines: Vec<Line>,
}

/// A line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Its tokens, with the newline where there is one.
    pub tokens: Range<usize>,
    /// The labels before the statement.
    pub labels: Vec<Name>,
    /// The statement. A line with errors still has it where only numbers are bad or commas are missing, or where a constant
    /// has no value, which is read as 0.
    pub statement: Option<Statement>,
    /// The index of the comment among the tokens.
    pub comment: Option<usize>,
    /// Whether something in it made no sense, so that it is not all in the tree; the formatter leaves such a line alone.
    pub has_errors: bool,
}

/// A name as it is written. Names are the same in any case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// The name.
    pub text: String,
    /// Where.
    pub span: Span,
}

/// What a line says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Statement {
    /// A command for the module.
    Instruction(InstructionSyntax),
    /// `NAME = value`.
    Constant(Constant),
    /// `#include FILE`.
    Include(Include),
}

/// A command and its operands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InstructionSyntax {
    /// The command.
    pub mnemonic: Name,
    /// A comma right after the mnemonic, as the manuals print now and then (`EI, 255`).
    pub stray_comma: Option<Span>,
    /// The operands.
    pub operands: Vec<Operand>,
    /// From the mnemonic to the last operand.
    pub span: Span,
}

/// An operand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Operand {
    /// Whether a minus stands before it.
    pub negated: bool,
    /// What it is.
    pub kind: OperandKind,
    /// With its minus.
    pub span: Span,
}

/// What an operand is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OperandKind {
    /// A number; malformed ones and those beyond 32 bits were reported and read as 0.
    Number(u32),
    /// A keyword, constant or label.
    Name(String),
}

/// A definition of a constant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constant {
    /// What it is called.
    pub name: Name,
    /// What it stands for.
    pub value: Operand,
}

/// An included file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Include {
    /// The file, without quotes; bytes that are no UTF-8 are replaced.
    pub path: Name,
    /// From `#include` to the end of the path.
    pub span: Span,
}
