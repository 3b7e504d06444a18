//! What is wrong with a file, and where.

use core::ops::Range;

/// One thing that is wrong with a configuration file, or with `tmcl.toml`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Finding {
    /// What is wrong and what is allowed.
    pub message: String,
    /// Which bytes of the text it is about; never beyond its end.
    pub span: Range<usize>,
    /// What might have been meant, or what to do.
    pub help: Option<String>,
}

impl Finding {
    /// A finding about `span`.
    pub(crate) fn new(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { message: message.into(), span, help: None }
    }

    /// The same with a hint.
    pub(crate) fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}
