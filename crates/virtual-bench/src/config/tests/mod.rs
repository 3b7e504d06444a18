//! Whole bench files: what they mean, what is said about wrong ones, and that nothing makes the reader stumble.

mod errors;
mod examples;
mod properties;
mod settings;
mod values;

use super::{BenchConfig, ConfigError, parse};

/// A file that must be right.
fn bench(text: &str) -> BenchConfig {
    parse(text).unwrap_or_else(|errors| panic!("{}", table(text, &errors)))
}

/// Errors as lines of position, message and help.
fn table(text: &str, errors: &[ConfigError]) -> String {
    let line = |error: &ConfigError| {
        let (line, column) = error.line_column(text);
        let help = error.help.as_ref().map(|help| format!("\n      {help}")).unwrap_or_default();
        format!("{line}:{column} {}{help}\n", error.message)
    };
    errors.iter().map(line).collect()
}
