//! Columns of names and values.

use comfy_table::{CellAlignment, Table, presets};

/// A table without lines; numbers stand in column `numbers`.
pub(crate) fn columns<const N: usize>(
    header: [&str; N],
    numbers: usize,
    rows: impl IntoIterator<Item = [String; N]>,
) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header.map(str::to_uppercase)).add_rows(rows);
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((u16::from(index > 0), 1));
        if index == numbers {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{}\n", table.trim_fmt())
}

/// Text without the spaces that would end its lines.
pub(crate) fn to_text(table: &str) -> String {
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}
