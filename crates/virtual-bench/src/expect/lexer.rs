//! Words and symbols, with their places.

use core::ops::Range;

/// The symbols; where one begins like another, the longer one comes first.
const SYMBOLS: [&str; 12] = ["==", "!=", "<=", ">=", "+/-", "+-", "±", "<", ">", "&", "=", "!"];

/// A word or symbol.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Token<'t> {
    pub(super) text: &'t str,
    pub(super) span: Range<usize>,
    pub(super) is_word: bool,
}

/// Cuts a text into words and symbols. A word is whatever stands between symbols and white space.
pub(super) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut start = 0;
    while let Some(rest) = text.get(start..).filter(|rest| !rest.is_empty()) {
        let blank = rest.len() - rest.trim_start().len();
        if blank > 0 {
            start += blank;
            continue;
        }
        let symbol = symbol_at(rest);
        let length = symbol.map_or_else(|| word_length(rest), str::len);
        let text = rest.get(..length).unwrap_or(rest);
        tokens.push(Token { text, span: start..start + text.len(), is_word: symbol.is_none() });
        start += text.len();
    }
    tokens
}

fn symbol_at(rest: &str) -> Option<&'static str> {
    SYMBOLS.into_iter().find(|symbol| rest.starts_with(symbol))
}

fn word_length(rest: &str) -> usize {
    let ends = |&(index, letter): &(usize, char)| {
        letter.is_whitespace() || rest.get(index..).is_some_and(|rest| symbol_at(rest).is_some())
    };
    rest.char_indices().skip(1).find(ends).map_or(rest.len(), |(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<&str> {
        tokens(text).into_iter().map(|token| token.text).collect()
    }

    #[test]
    fn spaces_are_needed_between_words_only() {
        assert_eq!(words("a==-5+-2"), ["a", "==", "-5", "+-", "2"]);
        assert_eq!(
            words("  m-1.status_word & 0x200  within\t2s"),
            ["m-1.status_word", "&", "0x200", "within", "2s"]
        );
        assert_eq!(words("a<=5±0.1"), ["a", "<=", "5", "±", "0.1"]);
        assert_eq!(words("1e+5 +/- 2"), ["1e+5", "+/-", "2"]);
        assert_eq!(words("a=b!"), ["a", "=", "b", "!"]);
        assert_eq!(words(" \n"), [""; 0]);
    }

    #[test]
    fn places_are_bytes() {
        let tokens = tokens("µ ± x");
        let spans: Vec<_> = tokens.iter().map(|token| token.span.clone()).collect();
        assert_eq!(spans, [0..2, 3..5, 6..7]);
        assert_eq!(tokens.iter().map(|token| token.is_word).collect::<Vec<_>>(), [true, false, true]);
    }
}
