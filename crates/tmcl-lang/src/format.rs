//! Lays text out.
//!
//! Labels, constants and includes begin at the left edge, instructions at one column of their own in the whole file.
//! Comments behind code stand below one another from one blank line to the next; those on their own line stay at the left
//! edge, or move to the instructions. Mnemonics and keywords become upper case; names, numbers, paths and comments stay as
//! they are written. What a program means never changes, and a line that makes no sense is not touched.
//!
//! All of it is OpenTMCL's choice (decision); no two listings of the manuals are alike. Which commands there are is for
//! `tmcl-tables` to know.

mod code;
mod comment;

use crate::source::Sources;
use crate::syntax::{BYTE_ORDER_MARK, File, Line, Token, TokenKind, is_space, parse};
use comment::{Comment, Place};

/// The text of a file, laid out. Lines that make no sense are left as they are, but for the newline.
///
/// One newline ends every line, of the kind that the file mostly has; there is never more than one blank line, and no space
/// at the end of a line. Laying out twice is the same as once.
#[must_use]
pub fn format(bytes: &[u8]) -> Vec<u8> {
    let file = parse(Sources::ROOT, bytes).file;
    let source = Source { bytes, file: &file };
    let mut rows = source.rows();
    comment::align(&mut rows);
    let mut out = Vec::with_capacity(bytes.len() + bytes.len() / 4);
    if bytes.starts_with(BYTE_ORDER_MARK) {
        out.extend_from_slice(BYTE_ORDER_MARK);
    }
    write(&rows, source.newline(), &mut out);
    out
}

/// A line of the result.
enum Row<'a> {
    /// Nothing.
    Blank,
    /// A line that makes no sense, as it was.
    Verbatim(&'a [u8]),
    /// Code, a comment, or both.
    LaidOut { code: Vec<u8>, comment: Option<Comment<'a>> },
}

impl Row<'_> {
    fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::Blank => {}
            Self::Verbatim(text) => out.extend_from_slice(text),
            Self::LaidOut { code, comment } => {
                out.extend_from_slice(code);
                if let Some(comment) = comment {
                    pad(out, comment.column().saturating_sub(width(code)));
                    out.extend_from_slice(comment.text);
                }
            }
        }
    }
}

fn write(rows: &[Row<'_>], newline: &[u8], out: &mut Vec<u8>) {
    let mut blank_above = false;
    let mut is_first = true;
    for row in rows {
        if matches!(row, Row::Blank) {
            blank_above = true;
            continue;
        }
        // At the very start, bytes that mean nothing could become a byte order mark, and the line would mean something.
        let is_mark =
            out.is_empty() && matches!(row, Row::Verbatim(text) if text.starts_with(BYTE_ORDER_MARK));
        if blank_above && (!is_first || is_mark) {
            out.extend_from_slice(newline);
        }
        row.write(out);
        out.extend_from_slice(newline);
        (blank_above, is_first) = (false, false);
    }
}

/// A file and its tree.
struct Source<'a> {
    bytes: &'a [u8],
    file: &'a File,
}

impl<'a> Source<'a> {
    fn rows(&self) -> Vec<Row<'a>> {
        let column = code::column(&self.file.lines);
        let mut rows = Vec::with_capacity(self.file.lines.len());
        let mut above = None;
        for line in &self.file.lines {
            let row = self.row(line, column, above);
            above = match &row {
                Row::LaidOut { comment: Some(Comment { place: Place::Block, .. }), .. } => Some(line),
                _ => None,
            };
            rows.push(row);
        }
        rows
    }

    /// `above` is the line above if its comment stands behind code, or below such a comment.
    fn row(&self, line: &Line, column: usize, above: Option<&Line>) -> Row<'a> {
        if line.has_errors {
            return Row::Verbatim(self.verbatim(line));
        }
        let code = code::code(self.bytes, line, column);
        let comment = line.comment.and_then(|index| self.file.tokens.get(index)).map(|token| {
            let is_in_block =
                !code.is_empty() || above.is_some_and(|above| comment::is_below(self, line, above));
            let place = match token.range().start - self.start(line) {
                _ if is_in_block => Place::Block,
                0 => Place::Column(0),
                _ => Place::Column(column),
            };
            Comment { text: trim_end(self.text(token)), place }
        });
        if code.is_empty() && comment.is_none() { Row::Blank } else { Row::LaidOut { code, comment } }
    }

    /// The bytes of a line, without its newline.
    fn verbatim(&self, line: &Line) -> &'a [u8] {
        let end = match self.tokens(line).last() {
            Some(token) if token.kind == TokenKind::Newline => token.range().start,
            Some(token) => token.range().end,
            None => self.start(line),
        };
        self.bytes.get(self.start(line)..end).unwrap_or_default()
    }

    /// Where a line begins, behind a byte order mark.
    fn start(&self, line: &Line) -> usize {
        let start = self.tokens(line).first().map_or(0, |token| token.range().start);
        if start == 0 && self.bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { start }
    }

    fn tokens(&self, line: &Line) -> &'a [Token] {
        self.file.tokens.get(line.tokens.clone()).unwrap_or_default()
    }

    fn text(&self, token: &Token) -> &'a [u8] {
        self.bytes.get(token.range()).unwrap_or_default()
    }

    /// `\r\n` where most lines end so, otherwise `\n`.
    fn newline(&self) -> &'static [u8] {
        let newlines = self.file.tokens.iter().filter(|token| token.kind == TokenKind::Newline);
        let (windows, others): (Vec<&Token>, Vec<&Token>) =
            newlines.partition(|token| token.range().len() == 2);
        if windows.len() > others.len() { b"\r\n" } else { b"\n" }
    }
}

/// How many columns a text without tabs takes.
fn width(text: &[u8]) -> usize {
    String::from_utf8_lossy(text).chars().count()
}

fn pad(out: &mut Vec<u8>, spaces: usize) {
    out.resize(out.len() + spaces, b' ');
}

fn trim_end(text: &[u8]) -> &[u8] {
    let length = text.iter().rposition(|byte| !is_space(*byte)).map_or(0, |last| last + 1);
    text.get(..length).unwrap_or_default()
}

#[cfg(test)]
mod tests;
