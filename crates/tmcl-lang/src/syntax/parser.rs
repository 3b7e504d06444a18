//! Tokens to tree. Lines are parsed on their own: the first thing in a line that makes no sense ends it, and the next line
//! starts afresh. What is wrong only in its form, a missing comma or a malformed number, stays in the tree.

use super::complaint::{self, Found};
use super::lexer::lex;
use super::number;
use super::token::{Token, TokenKind};
use super::tree::{Constant, File, Include, InstructionSyntax, Line, Name, Operand, OperandKind, Statement};
use crate::diagnostic::Diagnostic;
use crate::source::{FileId, Span};

/// A tree, and what made no sense in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parse {
    /// The tree.
    pub file: File,
    /// What made no sense, in the order of the file.
    pub diagnostics: Vec<Diagnostic>,
}

/// Parses a file; `file` goes into the spans.
#[must_use]
pub fn parse(file: FileId, bytes: &[u8]) -> Parse {
    let tokens = lex(bytes);
    let mut diagnostics = Vec::new();
    let newlines = tokens.iter().filter(|token| token.kind == TokenKind::Newline).count();
    let mut lines = Vec::with_capacity(newlines + 1);
    let mut start = 0;
    for line in tokens.split_inclusive(|token| token.kind == TokenKind::Newline) {
        let parser =
            LineParser { file, bytes, tokens: line, at: 0, diagnostics: &mut diagnostics, has_errors: false };
        lines.push(parser.line(start));
        start += line.len();
    }
    Parse { file: File { tokens, lines }, diagnostics }
}

struct LineParser<'a> {
    file: FileId,
    bytes: &'a [u8],
    /// Those of the line.
    tokens: &'a [Token],
    /// The next token.
    at: usize,
    diagnostics: &'a mut Vec<Diagnostic>,
    has_errors: bool,
}

impl<'a> LineParser<'a> {
    /// Parses the line whose first token is number `start` of the file.
    fn line(mut self, start: usize) -> Line {
        let comment = self.tokens.iter().position(|token| token.kind == TokenKind::Comment);
        let mut labels = Vec::new();
        while let Some(label) = self.label() {
            labels.push(label);
        }
        let statement = self.statement();
        if !self.has_errors && self.peek().is_some() {
            self.unexpected("the end of the line");
        }
        Line {
            tokens: start..start + self.tokens.len(),
            labels,
            statement,
            comment: comment.map(|comment| start + comment),
            has_errors: self.has_errors,
        }
    }

    /// `NAME ':'`
    fn label(&mut self) -> Option<Name> {
        let before = self.at;
        let name = self.take(TokenKind::Name);
        if let Some(name) = name
            && self.take(TokenKind::Colon).is_some()
        {
            return Some(self.name(name));
        }
        self.at = before;
        None
    }

    fn statement(&mut self) -> Option<Statement> {
        match self.peek()?.kind {
            TokenKind::Include => self.include().map(Statement::Include),
            TokenKind::Name => {
                let token = self.take(TokenKind::Name)?;
                let name = self.name(token);
                if self.take(TokenKind::Equals).is_some() {
                    return Some(Statement::Constant(self.constant(name)));
                }
                self.instruction(name).map(Statement::Instruction)
            }
            _ => {
                self.unexpected("a label, a command, a constant or `#include`");
                None
            }
        }
    }

    /// The rest of `NAME '=' operand`. Without a value it is 0, so that not every use is reported too.
    fn constant(&mut self, name: Name) -> Constant {
        let nothing = Operand { negated: false, kind: OperandKind::Number(0), span: self.here() };
        let value = self.operand("the value of the constant").unwrap_or(nothing);
        Constant { name, value }
    }

    /// `'#include' path`
    fn include(&mut self) -> Option<Include> {
        let keyword = self.take(TokenKind::Include)?;
        let Some(path) = self.take(TokenKind::Path) else {
            self.unexpected("the name of a file");
            return None;
        };
        let span = self.span(path);
        let text = String::from_utf8_lossy(self.text(path));
        let inside = match text.strip_prefix('"') {
            None => Some(text.as_ref()),
            Some(open) => open.strip_suffix('"').filter(|inside| !inside.is_empty()),
        };
        let Some(inside) = inside else {
            self.report(complaint::bad_path(span, &text));
            return None;
        };
        let path = Name { text: inside.to_owned(), span };
        Some(Include { path, span: self.span(keyword).to(span) })
    }

    /// The rest of `NAME ','? (operand (',' operand)*)?`; None where that is not what follows.
    fn instruction(&mut self, mnemonic: Name) -> Option<InstructionSyntax> {
        let stray_comma = self.take(TokenKind::Comma).map(|comma| self.span(comma));
        let mut operands: Vec<Operand> = Vec::new();
        let mut missing_comma = None;
        if self.peek().is_some() {
            // No command takes more.
            operands.reserve_exact(3);
            operands.push(self.operand("an operand or the end of the line")?);
        }
        while let Some(next) = self.peek() {
            if self.take(TokenKind::Comma).is_some() {
                operands.push(self.operand("an operand after the comma")?);
            } else if matches!(next.kind, TokenKind::Number | TokenKind::Name) {
                missing_comma = missing_comma.or(Some(self.span(next)));
                operands.push(self.operand("an operand")?);
            } else {
                self.unexpected("`,` or the end of the line");
                return None;
            }
        }
        if let Some(span) = missing_comma {
            self.report(complaint::missing_comma(span, self.bytes, &mnemonic, &operands));
        }
        let end = operands.last().map(|operand| operand.span).or(stray_comma).unwrap_or(mnemonic.span);
        Some(InstructionSyntax { span: mnemonic.span.to(end), mnemonic, stray_comma, operands })
    }

    /// `'-'? (NUMBER | NAME)`; `expected` says in a message what should stand here.
    fn operand(&mut self, expected: &str) -> Option<Operand> {
        let minus = self.take(TokenKind::Minus);
        let kind = if let Some(number) = self.take(TokenKind::Number) {
            OperandKind::Number(self.number(number))
        } else if let Some(name) = self.take(TokenKind::Name) {
            OperandKind::Name(self.name(name).text)
        } else {
            let behind_minus = "a number or a name after the minus";
            self.unexpected(if minus.is_some() { behind_minus } else { expected });
            return None;
        };
        let last = self.here();
        let span = minus.map_or(self.last_span(), |minus| self.span(minus).to(last));
        Some(Operand { negated: minus.is_some(), kind, span })
    }

    fn number(&mut self, token: &Token) -> u32 {
        let text = self.text(token);
        number::read(text).unwrap_or_else(|bad| {
            self.report(complaint::bad_number(self.span(token), text, bad));
            0
        })
    }

    fn name(&self, token: &Token) -> Name {
        Name { text: String::from_utf8_lossy(self.text(token)).into_owned(), span: self.span(token) }
    }

    /// The next token that is no whitespace; none where nothing but a comment is left.
    fn peek(&mut self) -> Option<&'a Token> {
        while self.tokens.get(self.at).is_some_and(|token| token.kind == TokenKind::Whitespace) {
            self.at += 1;
        }
        let next = self.tokens.get(self.at);
        next.filter(|token| !matches!(token.kind, TokenKind::Comment | TokenKind::Newline))
    }

    /// Passes the next token if it is of this kind.
    fn take(&mut self, kind: TokenKind) -> Option<&'a Token> {
        let token = self.peek().filter(|token| token.kind == kind)?;
        self.at += 1;
        Some(token)
    }

    /// Reports that `expected` should stand here.
    fn unexpected(&mut self, expected: &str) {
        let found = self.peek();
        let span = found.map_or(self.here(), |token| self.span(token));
        let found = found.map(|token| Found { kind: token.kind, text: self.text(token) });
        self.report(complaint::unexpected(span, found, expected));
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        self.has_errors = true;
        self.diagnostics.push(diagnostic);
    }

    /// The token that was passed last, whitespace apart.
    fn last_span(&self) -> Span {
        let passed = self.tokens.get(..self.at).unwrap_or_default();
        let last = passed.iter().rfind(|token| token.kind != TokenKind::Whitespace);
        let start = self.tokens.first().map_or(0, |token| token.range().start);
        Span::new(self.file, last.map_or(start..start, Token::range))
    }

    /// Right behind what was passed last.
    fn here(&self) -> Span {
        let last = self.last_span();
        Span { start: last.end, ..last }
    }

    fn span(&self, token: &Token) -> Span {
        Span::new(self.file, token.range())
    }

    fn text(&self, token: &Token) -> &'a [u8] {
        self.bytes.get(token.range()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests;
