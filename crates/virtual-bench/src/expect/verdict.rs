//! What came of an expectation.

use core::fmt;

use super::show;

/// An expectation and what came of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// The expectation's text.
    pub text: String,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of an expectation. Times are the bench's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It was met.
    Held {
        /// When that was certain.
        at_ns: u64,
    },
    /// It was not.
    Failed {
        /// When that was certain.
        at_ns: u64,
        /// What the values were instead, and when.
        reason: String,
    },
    /// Neither is certain.
    Undecided {
        /// After the run's end, what the values were instead; empty before.
        reason: String,
    },
}

impl Outcome {
    /// Whether it held or failed.
    #[must_use]
    pub fn is_decided(&self) -> bool {
        !matches!(self, Self::Undecided { .. })
    }
}

/// `held at 1.200 s`, `failed: actual_position was 9987 at 2.000 s`, `undecided`.
impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Held { at_ns } => write!(f, "held at {}", show::time(*at_ns)),
            Self::Failed { reason, .. } => write!(f, "failed: {reason}"),
            Self::Undecided { reason } if reason.is_empty() => f.write_str("undecided"),
            Self::Undecided { reason } => write!(f, "undecided: {reason}"),
        }
    }
}

/// The text and the outcome: `output.3 rises: held at 1.200 s`.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.text, self.outcome)
    }
}
