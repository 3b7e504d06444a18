//! Why a text is no expectation, and where.

use core::ops::Range;

use crate::probe::ProbeError;

/// Why a text is no expectation. Spans are bytes of the text, and never lie beyond its end.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExpectError {
    /// Something else must stand here.
    #[error("expected {expected}, found {found}")]
    Expected {
        /// What.
        expected: &'static str,
        /// What stands here instead.
        found: String,
        /// Where.
        span: Range<usize>,
    },
    /// A name that names nothing on this bench.
    #[error("{problem}")]
    Quantity {
        /// Why.
        problem: ProbeError,
        /// Where.
        span: Range<usize>,
    },
    /// A word that is neither a quantity nor a value of the parameter it is compared with.
    #[error("`{name}` is neither a quantity nor a value of `{parameter}`: {values}")]
    Value {
        /// The word.
        name: String,
        /// The parameter.
        parameter: String,
        /// What the parameter's values are called.
        values: String,
        /// Where.
        span: Range<usize>,
    },
    /// A mask on what is not a whole number.
    #[error("`{name}` is not a whole number: it has no bits to mask")]
    NoBits {
        /// The quantity.
        name: String,
        /// Where.
        span: Range<usize>,
    },
    /// Two parts that do not go together.
    #[error("{message}")]
    Conflict {
        /// Why not, and what to write instead.
        message: &'static str,
        /// The later part.
        span: Range<usize>,
    },
}

impl ExpectError {
    /// Which bytes of the text it is about.
    #[must_use]
    pub fn span(&self) -> Range<usize> {
        let (Self::Expected { span, .. }
        | Self::Quantity { span, .. }
        | Self::Value { span, .. }
        | Self::NoBits { span, .. }
        | Self::Conflict { span, .. }) = self;
        span.clone()
    }

    /// The error as people read it: the message, the text, and a mark under what it is about. Three lines, without a line
    /// break at the end.
    #[must_use]
    pub fn report(&self, text: &str) -> String {
        let span = self.span();
        let shown: String =
            text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
        let before = text.get(..span.start).map_or(0, |before| before.chars().count());
        let marked = text.get(span).map_or(1, |marked| marked.chars().count().max(1));
        format!("{self}\n  {shown}\n  {}{}", " ".repeat(before), "^".repeat(marked))
    }
}
