//! What the lexer cuts a file into.

use core::ops::Range;

/// A kind of token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenKind {
    /// Spaces and tabs, and a byte order mark at the start of the file.
    Whitespace,
    /// `\n`, `\r\n`, or `\r` alone.
    Newline,
    /// From `//` or `;` to the end of the line, without the newline; any bytes.
    Comment,
    /// A mnemonic, keyword, label or constant.
    Name,
    /// A decimal or hexadecimal number, without a sign; or what was meant as one, such as `12abc` or `$`.
    Number,
    /// `:`
    Colon,
    /// `,`
    Comma,
    /// `=`
    Equals,
    /// `-`
    Minus,
    /// `#include`, in any case.
    Include,
    /// What follows `#include`, with its quotes where there are any.
    Path,
    /// Bytes that mean nothing, as many as there are in a row.
    Unknown,
}

/// A token. Small, for there are many; files beyond 4 GiB are not for us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token {
    /// Its kind.
    pub kind: TokenKind,
    start: u32,
    end: u32,
}

impl Token {
    /// The bytes `range` of a file.
    #[must_use]
    pub fn new(kind: TokenKind, range: Range<usize>) -> Self {
        let offset = |offset: usize| u32::try_from(offset).unwrap_or(u32::MAX);
        Self { kind, start: offset(range.start), end: offset(range.end) }
    }

    /// Its bytes in the file.
    #[must_use]
    pub fn range(&self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}
