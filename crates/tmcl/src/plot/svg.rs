//! A figure as an SVG file.
//!
//! The file stands alone: no fonts, scripts or pictures from elsewhere. It has a title and a description for those who
//! cannot see it, follows the reader's choice of a light or a dark screen, and keeps to the palette of Okabe and Ito
//! (<https://jfly.uni-koeln.de/color/>), which is told apart with any colour vision.

use svg::Document;
use svg::node::element::{Description, Group, Path, Rectangle, Style as StyleSheet, TSpan, Text, Title};

use super::axis::Axis;
use super::curve::{Point, thinned};
use super::path::{path_data, tenths};
use super::{Figure, Panel, Style};

const WIDTH: f64 = 860.0;
const MARGIN: f64 = 18.0;
const TITLE_HEIGHT: f64 = 44.0;
/// Of a line of text above a panel.
const LINE_HEIGHT: f64 = 20.0;
const PANEL_HEIGHT: f64 = 132.0;
const GAP: f64 = 18.0;
const TIME_AXIS_HEIGHT: f64 = 34.0;
/// The widths of a character, in pixels, on the wide side: the reader's font is not known.
const TICK: f64 = 6.6;
const TEXT: f64 = 7.4;
const BOLD: f64 = 8.6;
const LEGEND_LINE: f64 = 22.0;
const COLOURS: usize = 6;

/// Light first; a dark screen gets the palette's brighter half and its own greys. Programs that ignore `@media` show light.
const STYLE: &str = include_str!("svg.css");

/// Where a panel's curves are drawn, in pixels, and its axes.
struct Area<'a> {
    left: f64,
    top: f64,
    time: &'a Axis,
    value: &'a Axis,
}

impl Area<'_> {
    const RIGHT: f64 = WIDTH - MARGIN;

    fn bottom(&self) -> f64 {
        self.top + PANEL_HEIGHT
    }

    fn x(&self, time_s: f64) -> f64 {
        self.left + self.time.fraction(time_s) * (Self::RIGHT - self.left)
    }

    fn y(&self, value: f64) -> f64 {
        self.bottom() - self.value.fraction(value) * PANEL_HEIGHT
    }
}

/// The text of an SVG file that shows a figure, 860 pixels wide.
pub(crate) fn svg(figure: &Figure) -> String {
    let time = Axis::new(figure.time_range(), 0.0, "s", 11);
    let values: Vec<Axis> = figure
        .panels
        .iter()
        .map(|panel| Axis::new(figure.value_range(panel), 0.06, &panel.unit, 6))
        .collect();
    let labels = values.iter().map(Axis::label_width).max().unwrap_or(0);
    let left = (MARGIN + 8.0 + labels as f64 * TICK).round();

    let mut plot = Group::new().add(text("title", MARGIN, 30.0, &shortened(&figure.title, 9.5)));
    let mut top = TITLE_HEIGHT;
    for (index, (panel, value)) in figure.panels.iter().zip(&values).enumerate() {
        let (header, lines) = header(panel, &value.unit, left, top);
        let area = Area { left, top: top + LINE_HEIGHT * lines as f64, time: &time, value };
        plot = plot.add(header).add(diagram(figure, panel, &area));
        if index + 1 == figure.panels.len() {
            plot = plot.add(time_labels(&area));
        }
        top = area.bottom() + GAP;
    }
    document(figure, plot, top - GAP + TIME_AXIS_HEIGHT + 10.0)
}

fn document(figure: &Figure, plot: Group, height: f64) -> String {
    let document = Document::new()
        .set("xmlns", "http://www.w3.org/2000/svg")
        .set("viewBox", format!("0 0 {WIDTH} {height}"))
        .set("width", WIDTH)
        .set("height", height)
        .set("class", "tmcl-plot")
        .set("role", "img")
        .set("aria-labelledby", "plot-title plot-description")
        .add(Title::new(printable(&figure.title)).set("id", "plot-title"))
        .add(Description::new().set("id", "plot-description").add(svg::node::Text::new(description(figure))))
        .add(StyleSheet::new(STYLE))
        .add(Rectangle::new().set("class", "paper").set("width", "100%").set("height", "100%").set("rx", 6))
        .add(plot);
    format!("{document}\n")
}

/// What is seen, in words.
fn description(figure: &Figure) -> String {
    let mut text = match figure.time_range() {
        Some((first, last)) => format!("Plots over time, {} to {} s.", rounded(first), rounded(last)),
        None => "Plots without samples.".to_owned(),
    };
    for panel in &figure.panels {
        for series in &panel.series {
            let alone = Panel { series: vec![series.clone()], ..Panel::default() };
            let unit = &panel.unit;
            let seen = match figure.value_range(&alone) {
                Some((low, high)) => format!("{} to {} {unit}", rounded(low), rounded(high)),
                None => "no samples".to_owned(),
            };
            text += &format!(" {}, {}: {}.", panel.title, series.name, seen.trim_end());
        }
    }
    printable(&text)
}

/// To four digits after the first.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// A panel's title and legend, and the lines they take.
fn header(panel: &Panel, unit: &str, left: f64, top: f64) -> (Group, usize) {
    let title = shortened(&panel.title, BOLD);
    let unit = if unit.is_empty() { String::new() } else { format!("[{}]", shortened(unit, TEXT)) };
    let heading = text("panel", left, top + 13.0, &title);
    let mut header =
        Group::new().add(heading.add(TSpan::new(printable(&unit)).set("class", "muted unit").set("dx", 7)));
    let mut x = left + width_of(&title, BOLD) + width_of(&unit, TEXT) + 30.0;
    let mut lines = 1;
    for (index, series) in panel.legend().iter().enumerate() {
        let name = shortened(&series.name, BOLD);
        let width = LEGEND_LINE + 6.0 + width_of(&name, TEXT);
        if x + width > Area::RIGHT && x > left {
            (x, lines) = (left, lines + 1);
        }
        let y = top + 13.0 + LINE_HEIGHT * (lines - 1) as f64;
        let line = path(&[(x, y - 4.0), (x + LEGEND_LINE, y - 4.0)]);
        header = header.add(line.set("class", curve_class(index, series.style)));
        header = header.add(text("legend", x + LEGEND_LINE + 6.0, y, &name));
        x += width + 20.0;
    }
    (header, lines)
}

fn width_of(text: &str, character_width: f64) -> f64 {
    text.chars().count() as f64 * character_width
}

fn diagram(figure: &Figure, panel: &Panel, area: &Area<'_>) -> Group {
    let mut diagram = Group::new().add(grid(area)).add(frame(area));
    if area.value.crosses_zero() {
        let (y, left) = (area.y(0.0), area.left);
        diagram = diagram.add(path(&[(left, y), (Area::RIGHT, y)]).set("class", "zero"));
    }
    for tick in &area.value.ticks {
        diagram = diagram.add(text("tick end", area.left - 7.0, area.y(tick.value) + 4.0, &tick.label));
    }
    let mut empty = true;
    for (index, series) in panel.series.iter().enumerate() {
        let points = figure.samples(series).map(|(time_s, value)| (area.x(time_s), area.y(value)));
        let points = thinned(points, 0.1);
        if !points.is_empty() {
            empty = false;
            diagram = diagram.add(path(&points).set("class", curve_class(index, series.style)));
        }
    }
    if empty {
        let middle = (area.left + Area::RIGHT) / 2.0;
        diagram = diagram.add(text("muted middle", middle, area.top + PANEL_HEIGHT / 2.0, "no samples"));
    }
    diagram
}

fn grid(area: &Area<'_>) -> Path {
    let across = area.value.ticks.iter().map(|tick| area.y(tick.value));
    let across = across.map(|y| path_data(&[(area.left, y), (Area::RIGHT, y)]));
    let upright = area.time.ticks.iter().map(|tick| area.x(tick.value));
    let upright = upright.map(|x| path_data(&[(x, area.top), (x, area.bottom())]));
    Path::new().set("class", "grid").set("d", across.chain(upright).collect::<String>())
}

fn frame(area: &Area<'_>) -> Path {
    let (left, bottom) = (area.left, area.bottom());
    path(&[(left, area.top), (left, bottom), (Area::RIGHT, bottom)]).set("class", "frame")
}

fn time_labels(area: &Area<'_>) -> Group {
    let mut labels = Group::new();
    for tick in &area.time.ticks {
        labels = labels.add(text("tick middle", area.x(tick.value), area.bottom() + 16.0, &tick.label));
    }
    let name = format!("time [{}]", area.time.unit);
    labels.add(text("muted middle", (area.left + Area::RIGHT) / 2.0, area.bottom() + 34.0, &name))
}

fn curve_class(index: usize, style: Style) -> String {
    let dashed = if style == Style::Dashed { " dashed" } else { "" };
    format!("curve c{}{dashed}", index % COLOURS)
}

fn text(class: &str, x: f64, y: f64, text: &str) -> Text {
    Text::new(printable(text)).set("class", class).set("x", tenths(x)).set("y", tenths(y))
}

fn path(points: &[Point]) -> Path {
    Path::new().set("d", path_data(points))
}

/// So much of a text as fits the figure's width.
fn shortened(text: &str, character_width: f64) -> String {
    let fits = ((WIDTH - 200.0) / character_width) as usize;
    if text.chars().count() <= fits {
        return text.to_owned();
    }
    text.chars().take(fits - 1).chain(['…']).collect()
}

/// XML has no control characters.
fn printable(text: &str) -> String {
    text.chars()
        .filter(|character| !character.is_control() && !matches!(character, '\u{fffe}' | '\u{ffff}'))
        .collect()
}

#[cfg(test)]
mod tests {
    use ::svg::parser::Event;
    use proptest::prelude::*;

    use super::*;
    use crate::plot::Series;
    use crate::plot::sample::movement;

    /// Parses, and gives the classes of all paths.
    fn path_classes(text: &str) -> Vec<String> {
        let class = |event| match event {
            Event::Error(error) => panic!("{error}"),
            Event::Tag("path", _, attributes) => attributes.get("class").map(ToString::to_string),
            _ => None,
        };
        ::svg::read(text).unwrap().filter_map(class).collect()
    }

    #[test]
    fn a_movement() {
        insta::assert_snapshot!(svg(&movement(41)));
    }

    #[test]
    fn twenty_thousand_samples_stay_small() {
        let mut figure = movement(20_000);
        figure.panels.push(figure.panels[2].clone());
        let noise = |index: usize| (index.wrapping_mul(2_654_435_761) % 1000) as f64;
        figure.panels[0].series[0].values = (0..20_000).map(noise).collect();
        let length = svg(&figure).len();
        assert!((10_000..200_000).contains(&length), "{length} bytes");
    }

    #[test]
    fn names_are_text() {
        let series = vec![Series { name: "</svg>\u{7}&".to_owned(), ..Series::default() }];
        let panel = Panel { title: "<a>".to_owned(), unit: "\"'".to_owned(), series };
        let text = svg(&Figure { title: "a & b".to_owned(), time_s: vec![], panels: vec![panel] });
        for shown in ["&lt;/svg&gt;&amp;", "a &amp; b", "&lt;a&gt;", "no samples"] {
            assert!(text.contains(shown), "{shown} in {text}");
        }
        assert_eq!(path_classes(&text), ["curve c0", "grid", "frame", "zero"]);
    }

    #[test]
    fn one_sample_is_a_dot() {
        let series = vec![Series { values: vec![3.0], ..Series::default() }];
        let panel = Panel { series, ..Panel::default() };
        let text = svg(&Figure { time_s: vec![0.0], panels: vec![panel], ..Figure::default() });
        assert!(text.contains("h0"), "{text}");
    }

    proptest! {
        #[test]
        fn whatever_the_values(
            time_s in prop::collection::vec(any::<f64>(), 0..20),
            values in prop::collection::vec(any::<f64>(), 0..20),
            name in ".{0,200}",
        ) {
            let series = Series { name: name.clone(), values, style: Style::Dashed };
            let panel = Panel { title: name.clone(), unit: name.clone(), series: vec![series.clone(), series] };
            let text = svg(&Figure { title: name, time_s, panels: vec![panel.clone(), panel] });
            path_classes(&text);
            prop_assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
        }
    }
}
