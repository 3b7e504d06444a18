//! What stands above a panel: its title, its unit, and its legend.

use svg::node::element::{Group, TSpan};

use super::{BOLD, LINE_HEIGHT, RIGHT, TEXT, curve_class, path, printable, rectangle, shortened, text};
use crate::plot::{Panel, Style};

const LEGEND_LINE: f64 = 22.0;

/// A panel's title and legend, and the lines they take.
pub(super) fn header(panel: &Panel, unit: &str, left: f64, top: f64) -> (Group, usize) {
    let title = shortened(&panel.title, BOLD);
    let unit = upwards(panel, unit);
    let heading = text("panel", left, top + 13.0, &title);
    let gap = if title.is_empty() { 0 } else { 7 };
    let mut header =
        Group::new().add(heading.add(TSpan::new(printable(&unit)).set("class", "muted unit").set("dx", gap)));
    let mut x = left + width_of(&title, BOLD) + width_of(&unit, TEXT) + 30.0;
    let mut lines = 1;
    let legend = if panel.across.is_some() { &[] } else { panel.legend() };
    for (index, series) in legend.iter().enumerate() {
        let name = shortened(&series.name, BOLD);
        let width = LEGEND_LINE + 6.0 + width_of(&name, TEXT);
        if x + width > RIGHT && x > left {
            (x, lines) = (left, lines + 1);
        }
        let y = top + 13.0 + LINE_HEIGHT * (lines - 1) as f64;
        let class = curve_class(index, series.style);
        header = if series.style == Style::Band {
            header.add(rectangle((x, y - 10.0), (x + LEGEND_LINE, y + 2.0)).set("class", class))
        } else {
            header.add(path(&[(x, y - 4.0), (x + LEGEND_LINE, y - 4.0)]).set("class", class))
        };
        header = header.add(text("legend", x + LEGEND_LINE + 6.0, y, &name));
        x += width + 20.0;
    }
    (header, lines)
}

/// The unit upwards; with its name where there is one to the right too.
fn upwards(panel: &Panel, unit: &str) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!("[{}]", shortened(unit, TEXT)) };
    match (&panel.across, panel.series.first()) {
        (Some(_), Some(series)) => format!("{} {unit}", shortened(&series.name, TEXT)).trim_end().to_owned(),
        _ => unit,
    }
}

fn width_of(text: &str, character_width: f64) -> f64 {
    text.chars().count() as f64 * character_width
}
