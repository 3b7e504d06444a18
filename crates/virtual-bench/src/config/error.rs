//! What is wrong with a bench file, and where.

use core::fmt::Write as _;
use core::ops::Range;

/// One thing that is wrong with a bench file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ConfigError {
    /// What is wrong and what is allowed.
    pub message: String,
    /// Which bytes of the text it is about; never beyond its end.
    pub span: Range<usize>,
    /// What might have been meant, or what there is to choose from.
    pub help: Option<String>,
}

impl ConfigError {
    /// An error about `span`.
    pub(super) fn new(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { message: message.into(), span, help: None }
    }

    /// The same error with a hint.
    pub(super) fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// Line and column of its start in the text that was parsed, both from 1; columns count characters.
    #[must_use]
    pub fn line_column(&self, text: &str) -> (usize, usize) {
        let before = text.get(..self.span.start).unwrap_or(text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |rest| rest.chars().count()) + 1;
        (line, column)
    }

    /// The error as people read it: the message, the line of `text` it is about, marked, and the hint. `file` is what the
    /// text is called.
    #[must_use]
    pub fn report(&self, file: &str, text: &str) -> String {
        let (line, column) = self.line_column(text);
        let source =
            text.split('\n').nth(line - 1).unwrap_or_default().trim_end_matches('\r').replace('\t', " ");
        let gutter = " ".repeat(line.to_string().len());
        let indent = " ".repeat(column - 1);
        let room = source.chars().count().saturating_sub(column - 1);
        let marked = text.get(self.span.clone()).map_or(0, |marked| marked.chars().count());
        let mark = "^".repeat(marked.min(room).max(1));
        let mut report = format!("{file}:{line}:{column}: {}\n", self.message);
        // Writing to a string cannot fail.
        let _ = writeln!(report, "{gutter} |\n{line} | {source}\n{gutter} | {indent}{mark}");
        if let Some(help) = &self.help {
            let _ = writeln!(report, "{gutter} = {help}");
        }
        report
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters() {
        let text = "# Ω\nµ = 1\n";
        assert_eq!(ConfigError::new(0..1, "").line_column(text), (1, 1));
        assert_eq!(ConfigError::new(10..11, "").line_column(text), (2, 5));
        assert_eq!(ConfigError::new(text.len()..text.len(), "").line_column(text), (3, 1));
    }

    #[test]
    fn a_report_marks_what_it_is_about() {
        let error = ConfigError::new(5..9, "unknown key \"torq\"").with_help("did you mean \"torque\"?");
        let report = error.report("bench.toml", "a=1\n\ttorq = 2\r\n");
        assert_eq!(
            report,
            "bench.toml:2:2: unknown key \"torq\"\n  |\n2 |  torq = 2\n  |  ^^^^\n  = did you mean \"torque\"?\n"
        );
    }
}
