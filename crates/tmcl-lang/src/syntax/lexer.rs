//! Bytes to tokens. Every byte sequence has exactly one way of being cut, and nothing is refused here: what means nothing
//! becomes [`TokenKind::Unknown`], a number may still be malformed, and saying so is the parser's business.

use super::token::{Token, TokenKind};

/// What editors put before UTF-8 text; it counts as whitespace at the start of a file.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// Cuts a file into tokens; together they are the whole file.
#[must_use]
pub fn lex(bytes: &[u8]) -> Vec<Token> {
    let mut tokens = Vec::with_capacity(bytes.len() / 3);
    let mut at = 0;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        at = BYTE_ORDER_MARK.len();
        tokens.push(Token::new(TokenKind::Whitespace, 0..at));
    }
    let mut path_follows = false;
    while let Some((kind, length)) = bytes.get(at..).and_then(|rest| first(rest, path_follows)) {
        tokens.push(Token::new(kind, at..at + length));
        at += length;
        path_follows = kind == TokenKind::Include || (path_follows && kind == TokenKind::Whitespace);
    }
    tokens
}

/// The kind and length of the first token; none at the end.
fn first(rest: &[u8], path_follows: bool) -> Option<(TokenKind, usize)> {
    let (&byte, behind) = rest.split_first()?;
    Some(match byte {
        _ if is_space(byte) => (TokenKind::Whitespace, run(rest, is_space)),
        b'\r' if behind.first() == Some(&b'\n') => (TokenKind::Newline, 2),
        b'\r' | b'\n' => (TokenKind::Newline, 1),
        _ if is_comment(rest) => (TokenKind::Comment, run(rest, |byte| !is_newline(byte))),
        _ if path_follows => (TokenKind::Path, path(rest)),
        b':' => (TokenKind::Colon, 1),
        b',' => (TokenKind::Comma, 1),
        b'=' => (TokenKind::Equals, 1),
        b'-' => (TokenKind::Minus, 1),
        b'#' => hash(rest),
        b'$' | b'0'..=b'9' => (TokenKind::Number, 1 + run(behind, is_word)),
        _ if is_word(byte) => (TokenKind::Name, run(rest, is_word)),
        _ => (TokenKind::Unknown, unknown(rest)),
    })
}

/// `#include`; anything else that begins with `#` means nothing as a whole.
fn hash(rest: &[u8]) -> (TokenKind, usize) {
    let length = 1 + run(rest.get(1..).unwrap_or_default(), is_word);
    let word = rest.get(..length).unwrap_or_default();
    if word.eq_ignore_ascii_case(b"#include") {
        (TokenKind::Include, length)
    } else {
        (TokenKind::Unknown, length)
    }
}

/// A quoted path with its quotes; otherwise to the last byte before a comment or the end of the line that is no space.
fn path(rest: &[u8]) -> usize {
    let line = run(rest, |byte| !is_newline(byte));
    let line = rest.get(..line).unwrap_or_default();
    if let Some((b'"', inside)) = line.split_first()
        && let Some(length) = inside.iter().position(|byte| *byte == b'"')
    {
        return length + 2;
    }
    let comment = (0..line.len()).find(|at| line.get(*at..).is_some_and(is_comment));
    let line = line.get(..comment.unwrap_or(line.len())).unwrap_or_default();
    line.iter().rposition(|byte| !is_space(*byte)).map_or(line.len(), |last| last + 1)
}

/// All bytes that mean nothing, up to the first that means something.
fn unknown(rest: &[u8]) -> usize {
    let means_something = |at: &usize| rest.get(*at..).is_some_and(starts_token);
    (1..rest.len()).find(means_something).unwrap_or(rest.len())
}

fn starts_token(rest: &[u8]) -> bool {
    rest.first().is_some_and(|&byte| {
        is_space(byte)
            || is_newline(byte)
            || is_word(byte)
            || matches!(byte, b':' | b',' | b'=' | b'-' | b'#' | b'$')
            || is_comment(rest)
    })
}

/// How many bytes from the start on `belong`.
fn run(bytes: &[u8], belong: impl Fn(u8) -> bool) -> usize {
    bytes.iter().position(|byte| !belong(*byte)).unwrap_or(bytes.len())
}

fn is_comment(rest: &[u8]) -> bool {
    rest.starts_with(b";") || rest.starts_with(b"//")
}

fn is_newline(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// Vertical tabs and form feeds are spaces, as in C.
pub(crate) fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0B | 0x0C)
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::TokenKind::*;
    use super::*;

    fn cut(text: &[u8]) -> Vec<(TokenKind, &[u8])> {
        lex(text).into_iter().map(|token| (token.kind, &text[token.range()])).collect()
    }

    fn meaningful(text: &str) -> Vec<(TokenKind, String)> {
        let all = cut(text.as_bytes()).into_iter().filter(|(kind, _)| *kind != Whitespace);
        all.map(|(kind, bytes)| (kind, String::from_utf8_lossy(bytes).into_owned())).collect()
    }

    fn path_of(text: &str) -> Option<String> {
        meaningful(text).into_iter().find(|(kind, _)| *kind == Path).map(|(_, text)| text)
    }

    #[test]
    fn a_line_with_everything() {
        let expected = [
            (Name, "Loop"),
            (Colon, ":"),
            (Name, "SAP"),
            (Number, "$1F"),
            (Comma, ","),
            (Number, "0x1f"),
            (Comma, ","),
            (Minus, "-"),
            (Name, "Max_1"),
            (Equals, "="),
            (Comment, "//x;y"),
            (Newline, "\r\n"),
        ];
        let expected: Vec<_> = expected.into_iter().map(|(kind, text)| (kind, text.to_owned())).collect();
        assert_eq!(meaningful("Loop:\tSAP $1F,0x1f , -Max_1=//x;y\r\n"), expected);
    }

    #[test]
    fn newlines_of_all_systems() {
        let newlines: Vec<&[u8]> = vec![b"\n", b"\r\n", b"\r", b"\r\n"];
        assert_eq!(cut(b"\n\r\n\r\r\n").into_iter().map(|(_, bytes)| bytes).collect::<Vec<_>>(), newlines);
    }

    #[test]
    fn comments_hold_any_bytes() {
        assert_eq!(
            cut(b"; \xF6\x00//\rMST"),
            [(Comment, &b"; \xF6\x00//"[..]), (Newline, b"\r"), (Name, b"MST")]
        );
    }

    #[test]
    fn the_byte_order_mark_counts_only_at_the_start() {
        assert_eq!(cut(b"\xEF\xBB\xBF ")[0], (Whitespace, BYTE_ORDER_MARK));
        assert_eq!(cut(b" \xEF\xBB\xBF")[1], (Unknown, BYTE_ORDER_MARK));
    }

    #[test]
    fn what_means_nothing_is_one_token() {
        assert_eq!(cut(b"a\xC3\xB6+/b"), [(Name, &b"a"[..]), (Unknown, b"\xC3\xB6+/"), (Name, b"b")]);
        assert_eq!(cut(b"...//x"), [(Unknown, &b"..."[..]), (Comment, b"//x")]);
        assert_eq!(cut(b"#define x")[0], (Unknown, &b"#define"[..]));
    }

    #[test]
    fn numbers_run_on_to_where_a_word_ends() {
        for text in ["0", "12abc", "$", "$1F", "0x", "1_000"] {
            assert_eq!(meaningful(text), [(Number, text.to_owned())]);
        }
    }

    #[test]
    fn paths_end_at_quotes_comments_and_lines() {
        let path = |text: &str| path_of(text);
        assert_eq!(path("#include Interrupts.inc"), Some("Interrupts.inc".to_owned()));
        assert_eq!(path("  #INCLUDE\t a b.inc  // why\n"), Some("a b.inc".to_owned()));
        assert_eq!(path("#include dir//file"), Some("dir".to_owned()));
        assert_eq!(path("#include \"dir//file;\" ; why"), Some("\"dir//file;\"".to_owned()));
        assert_eq!(path("#include \"open.inc // why"), Some("\"open.inc".to_owned()));
        assert_eq!(path("#include // nothing"), None);
        assert_eq!(path("#include\nMST"), None);
    }

    proptest! {
        #[test]
        fn the_tokens_are_the_file(bytes in any::<Vec<u8>>()) {
            prop_assert_eq!(cut(&bytes).into_iter().flat_map(|(_, bytes)| bytes.to_vec()).collect::<Vec<_>>(), bytes);
        }

        #[test]
        fn the_tokens_of_heaps_of_pieces_are_the_file(pieces in proptest::collection::vec(piece(), 0..40)) {
            let bytes = pieces.concat();
            prop_assert_eq!(cut(&bytes).into_iter().flat_map(|(_, bytes)| bytes.to_vec()).collect::<Vec<_>>(), bytes.clone());
            prop_assert!(lex(&bytes).iter().all(|token| !token.range().is_empty()));
        }
    }

    fn piece() -> impl Strategy<Value = Vec<u8>> {
        let single = proptest::sample::select(b" \t\r\n#aF0$_\"/;:,=-x\xC3\xB6\x00".to_vec())
            .prop_map(|byte| vec![byte]);
        prop_oneof![8 => single, 1 => Just(b"#include ".to_vec()), 1 => Just(BYTE_ORDER_MARK.to_vec())]
    }
}
