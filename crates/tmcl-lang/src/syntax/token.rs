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

/// A token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Token {
    /// Its kind.
    pub kind: TokenKind,
    /// Its bytes in the file.
    pub range: Range<usize>,
}
