//! Where comments stand.

use super::{Row, Source, width};
use crate::syntax::{Line, TokenKind, is_space};

/// What is between the longest code of a block and the comments behind it.
const GAP: usize = 2;

/// How far editors move to at a tab, by taste.
const TABS: [usize; 2] = [4, 8];

/// A comment, without spaces at its end.
pub(super) struct Comment<'a> {
    pub(super) text: &'a [u8],
    pub(super) place: Place,
}

impl Comment<'_> {
    pub(super) fn column(&self) -> usize {
        match self.place {
            Place::Column(column) => column,
            Place::Block => 0,
        }
    }
}

/// Where a comment goes.
#[derive(Clone, Copy)]
pub(super) enum Place {
    /// To this column.
    Column(usize),
    /// Below the other comments behind code, as far as the next blank line.
    Block,
}

/// Gives the comments of every block their column.
pub(super) fn align(rows: &mut [Row<'_>]) {
    for block in rows.split_mut(|row| !matches!(row, Row::LaidOut { .. })) {
        let column = block.iter().filter_map(code_width).max().unwrap_or(0) + GAP;
        for row in block {
            if let Row::LaidOut { comment: Some(comment), .. } = row
                && let Place::Block = comment.place
            {
                comment.place = Place::Column(column);
            }
        }
    }
}

/// The width of code that has a comment behind it.
fn code_width(row: &Row<'_>) -> Option<usize> {
    match row {
        Row::LaidOut { code, comment: Some(_) } if !code.is_empty() => Some(width(code)),
        _ => None,
    }
}

/// Whether the comment of `line` stands right below that of the line above, and so goes on with it.
pub(super) fn is_below(source: &Source<'_>, line: &Line, above: &Line) -> bool {
    TABS.iter().any(|tab| column(source, line, *tab) == column(source, above, *tab))
}

/// Where the comment of a line stands. Only the spaces between tokens may hold tabs: that way it is clear for every text
/// that was laid out, and laying it out again changes nothing.
fn column(source: &Source<'_>, line: &Line, tab: usize) -> usize {
    let code = source.tokens(line).iter().take_while(|token| token.kind != TokenKind::Comment);
    code.fold(0, |column, token| match token.kind {
        TokenKind::Whitespace => source.text(token).iter().fold(column, |column, byte| match byte {
            b'\t' => (column + 1).next_multiple_of(tab),
            // A byte order mark takes no room.
            _ => column + usize::from(is_space(*byte)),
        }),
        _ => column + width(source.text(token)),
    })
}
