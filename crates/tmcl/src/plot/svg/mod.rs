//! A figure as an SVG file.
//!
//! The file stands alone: no fonts, scripts or pictures from elsewhere. It has a title and a description for those who
//! cannot see it, follows the reader's choice of a light or a dark screen, and keeps to the palette of Okabe and Ito
//! (<https://jfly.uni-koeln.de/color/>), which is told apart with any colour vision.

mod diagram;
mod header;
mod shape;

use svg::Document;
use svg::node::element::{Description, Group, Path, Rectangle, Style as StyleSheet, Text, Title};

use super::curve::Point;
use super::path::{path_data, tenths};
use super::{Figure, Panel, Series, Style};
use diagram::{Area, diagram, labels_below};
use header::header;
use shape::Shape;

const WIDTH: f64 = 860.0;
const MARGIN: f64 = 18.0;
const TITLE_HEIGHT: f64 = 44.0;
/// Of a line of text above a panel.
const LINE_HEIGHT: f64 = 20.0;
const GAP: f64 = 18.0;
const AXIS_HEIGHT: f64 = 34.0;
const RIGHT: f64 = WIDTH - MARGIN;
/// The widths of a character, in pixels, on the wide side: the reader's font is not known.
const TICK: f64 = 6.6;
const TEXT: f64 = 7.4;
const BOLD: f64 = 8.6;
const COLOURS: usize = 6;

/// Light first; a dark screen gets the palette's brighter half and its own greys. Programs that ignore `@media` show light.
const STYLE: &str = include_str!("svg.css");

/// The text of an SVG file that shows a figure, 860 pixels wide.
pub(crate) fn svg(figure: &Figure) -> String {
    let shapes: Vec<Shape> = figure.panels.iter().map(|panel| Shape::new(figure, panel)).collect();
    let labels = shapes.iter().map(|shape| shape.value.label_width()).max().unwrap_or(0);
    let left = (MARGIN + 8.0 + labels as f64 * TICK).round();

    let mut plot = Group::new().add(text("title", MARGIN, 30.0, &shortened(&figure.title, 9.5)));
    let mut top = TITLE_HEIGHT;
    for (index, (panel, shape)) in figure.panels.iter().zip(&shapes).enumerate() {
        let (header, lines) = header(panel, &shape.value.unit, left, top);
        let area = Area::new(shape, left, top + LINE_HEIGHT * lines as f64);
        plot = plot.add(header).add(diagram(figure, panel, &area));
        top = area.bottom + GAP;
        // Panels over time that stand together share their labels.
        let next = figure.panels.get(index + 1);
        if panel.across.is_some() || next.is_none_or(|next| next.across.is_some()) {
            plot = plot.add(labels_below(&area, panel.across.as_ref()));
            top += AXIS_HEIGHT;
        }
    }
    let axes = if figure.panels.is_empty() { AXIS_HEIGHT } else { 0.0 };
    document(figure, plot, top - GAP + axes + 10.0)
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
            let mut name = format!("{}, {}", panel.title, series.name);
            if let Some(across) = &panel.across {
                name += &format!(" over {}", across.series.name);
            }
            text += &format!(" {name}: {}.", seen(figure, panel, series));
        }
    }
    printable(&text)
}

/// What there is to see of a curve.
fn seen(figure: &Figure, panel: &Panel, series: &Series) -> String {
    if series.style == Style::Band {
        let spans = figure.spans(panel, series);
        let from_to = spans.iter().map(|(from, to)| format!("{} to {} s", rounded(*from), rounded(*to)));
        return if spans.is_empty() { "never".to_owned() } else { from_to.collect::<Vec<_>>().join(", ") };
    }
    let alone = Panel { series: vec![series.clone()], across: panel.across.clone(), ..Panel::default() };
    match figure.value_range(&alone) {
        Some((low, high)) => {
            format!("{} to {} {}", rounded(low), rounded(high), panel.unit).trim_end().to_owned()
        }
        None => "no samples".to_owned(),
    }
}

/// To four digits after the first.
fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

fn curve_class(index: usize, style: Style) -> String {
    let colour = index % COLOURS;
    match style {
        Style::Solid => format!("curve c{colour}"),
        Style::Dashed => format!("curve c{colour} dashed"),
        Style::Band => format!("band c{colour}"),
    }
}

fn text(class: &str, x: f64, y: f64, text: &str) -> Text {
    Text::new(printable(text)).set("class", class).set("x", tenths(x)).set("y", tenths(y))
}

fn path(points: &[Point]) -> Path {
    Path::new().set("d", path_data(points))
}

fn rectangle(from: Point, to: Point) -> Rectangle {
    Rectangle::new()
        .set("x", tenths(from.0))
        .set("y", tenths(from.1))
        .set("width", tenths((to.0 - from.0).max(1.0)))
        .set("height", tenths(to.1 - from.1))
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
    use crate::plot::Across;
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
        let panel = Panel { title: "<a>".to_owned(), unit: "\"'".to_owned(), across: None, series };
        let text = svg(&Figure { title: "a & b".to_owned(), time_s: vec![], panels: vec![panel] });
        for shown in ["&lt;/svg&gt;&amp;", "a &amp; b", "&lt;a&gt;", "no samples"] {
            assert!(text.contains(shown), "{shown} in {text}");
        }
        assert_eq!(path_classes(&text), ["curve c0", "grid", "frame", "zero"]);
    }

    fn circle(turns: u32) -> Figure {
        let angles = || (0..turns * 100).map(|index| f64::from(index) * std::f64::consts::TAU / 100.0);
        let along =
            |value: fn(f64) -> f64| Series { values: angles().map(value).collect(), ..Series::default() };
        let across = Some(Across { unit: "A".to_owned(), series: along(f64::cos) });
        let panel = Panel { unit: "A".to_owned(), across, series: vec![along(f64::sin)], ..Panel::default() };
        Figure { time_s: angles().collect(), panels: vec![panel], ..Figure::default() }
    }

    #[test]
    fn a_circle_is_round() {
        let text = svg(&circle(1));
        let data = text.split("<path").skip(1).find(|path| path.contains("curve")).unwrap();
        let data = data.split("d=\"").nth(1).unwrap().split('"').next().unwrap();
        let data = data.replace('-', " -").replace(['M', 'l'], " ");
        let numbers: Vec<f64> = data.split_whitespace().map(|number| number.parse().unwrap()).collect();
        let extent = |first: usize| {
            let mut at = 0.0;
            let places = numbers.iter().skip(first).step_by(2).map(|step| {
                at += step;
                at
            });
            let (low, high) =
                places.fold((f64::MAX, f64::MIN), |(low, high), at| (at.min(low), at.max(high)));
            high - low
        };
        assert!((extent(0) - extent(1)).abs() < 2.0 && extent(0) > 100.0, "{} {}", extent(0), extent(1));
    }

    #[test]
    fn a_circle_that_is_gone_round_often_stays_small() {
        let (once, often) = (svg(&circle(1)).len(), svg(&circle(1000)).len());
        assert!(often < once + 1000, "{once} bytes, {often} bytes");
    }

    #[test]
    fn a_band_is_shaded() {
        let mut figure = movement(41);
        let values = (0..41).map(|index| f64::from(u8::from((10..20).contains(&index)))).collect();
        figure.panels[0].series.push(Series { name: "switch".to_owned(), values, style: Style::Band });
        let text = svg(&figure);
        assert_eq!(text.matches("class=\"band c2\"").count(), 2, "the span and its legend");
        assert!(text.contains("position, switch: 0.5 to 1 s."), "{text}");
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
            let series = Series { name: name.clone(), values: values.clone(), style: Style::Dashed };
            let band = Series { style: Style::Band, ..series.clone() };
            let series = vec![series.clone(), series.clone(), band];
            let panel = Panel { title: name.clone(), unit: name.clone(), across: None, series };
            let mut xy = panel.clone();
            for unit in [name.clone(), "A".to_owned()] {
                let series = Series { values: values.iter().rev().copied().collect(), ..Series::default() };
                xy.across = Some(Across { unit, series });
            }
            let panels = vec![panel.clone(), panel.clone(), xy, panel];
            let text = svg(&Figure { title: name, time_s, panels });
            path_classes(&text);
            prop_assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
        }
    }
}
