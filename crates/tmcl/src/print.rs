//! Text for people and for machines.

use std::io::{self, Write};

use comfy_table::{CellAlignment, Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// `error: …` on stderr, in red where the terminal has colours and `NO_COLOR` does not forbid them.
pub(crate) fn error(message: &str) {
    let style = anstyle::AnsiColor::Red.on_default().bold();
    anstream::eprintln!("{style}error:{style:#} {message}");
}

/// `note: …` on stderr.
pub(crate) fn note(message: &str) {
    let style = anstyle::Style::new().bold();
    anstream::eprintln!("{style}note:{style:#} {message}");
}

/// Data on stdout, as it is.
pub(crate) fn text(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()
}

/// Data on stdout as JSON.
pub(crate) fn json(value: &impl Serialize) -> io::Result<()> {
    text(&format!("{}\n", serde_json::to_string_pretty(value)?))
}

/// Data on stdout as JSON, a line of it.
pub(crate) fn json_line(value: &impl Serialize) -> io::Result<()> {
    text(&format!("{}\n", serde_json::to_string(value)?))
}

/// A bar on stderr, where that is a terminal.
pub(crate) fn progress(length: usize, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(length as u64);
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(what.to_owned());
    bar
}

/// A table without lines; the first column is right-aligned.
pub(crate) fn table<const N: usize>(
    header: [&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> io::Result<()> {
    text(&columns(header, Some(0), rows))
}

/// A table without lines; the first column is left-aligned.
pub(crate) fn listing<const N: usize>(
    header: [&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> io::Result<()> {
    text(&columns(header, None, rows))
}

/// As [`listing`], as a text, and with numbers in the column `numbers`, if there is one of that index.
pub(crate) fn columns<const N: usize>(
    header: [&str; N],
    numbers: Option<usize>,
    rows: impl IntoIterator<Item = [String; N]>,
) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header.map(str::to_uppercase)).add_rows(rows);
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((u16::from(index > 0), 1));
        if Some(index) == numbers {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{}\n", table.trim_fmt())
}
