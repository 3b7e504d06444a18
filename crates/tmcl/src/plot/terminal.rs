//! A figure in a terminal: curves of braille dots, two by four to a character.

use ratatui_core::buffer::{Buffer, CellWidth};
use ratatui_core::layout::Rect;
use ratatui_core::style::{Color, Modifier, Style as CellStyle};
use ratatui_core::widgets::Widget;
use ratatui_widgets::canvas::{Canvas, Context, Line};

use super::axis::Axis;
use super::curve::{Point, dashes, thinned};
use super::{Figure, Panel, Style};

/// Of 256 colours those next to Okabe's and Ito's that can be read on white and on black.
const COLOURS: [u8; 6] = [32, 166, 36, 175, 74, 178];
/// The least width and height of a figure and the least height of a panel, in characters.
const LEAST_WIDTH: u16 = 24;
const LEAST_PANEL: u16 = 3;
const MOST: u16 = 500;

/// How a curve is told from the others.
#[derive(Clone, Copy, PartialEq)]
struct Look {
    stroke: Stroke,
    colour: Color,
}

#[derive(Clone, Copy, PartialEq)]
enum Stroke {
    Solid,
    Dashed,
    Dotted,
    /// No line, but shade.
    Shade,
}

impl Stroke {
    const LINES: [Self; 3] = [Self::Solid, Self::Dashed, Self::Dotted];

    fn sample(self) -> &'static str {
        match self {
            Self::Solid => "───",
            Self::Dashed => "╴╴╴",
            Self::Dotted => "···",
            Self::Shade => "░░░",
        }
    }
}

impl From<Style> for Stroke {
    fn from(style: Style) -> Self {
        match style {
            Style::Solid => Self::Solid,
            Style::Dashed => Self::Dashed,
            Style::Band => Self::Shade,
        }
    }
}

/// The lines of text that show a figure, at most `width` characters wide and, unless that is too low for its panels,
/// `height` lines high. With `colour` the curves have colours (ANSI, 256 of them); without, they have strokes of their own
/// and the text is plain.
pub(crate) fn terminal(figure: &Figure, width: u16, height: u16, colour: bool) -> String {
    let width = width.clamp(LEAST_WIDTH, MOST);
    let panels = u16::try_from(figure.panels.len()).unwrap_or(MOST).clamp(1, MOST);
    let axes = (1..=figure.panels.len()).filter(|panels| has_axis_below(figure, panels - 1)).count().max(1);
    let axes = 2 * u16::try_from(axes).unwrap_or(MOST).min(panels);
    let rows = (height.saturating_sub(1 + axes) / panels).saturating_sub(1).clamp(LEAST_PANEL, MOST / 4);
    let values: Vec<Axis> = figure
        .panels
        .iter()
        .take(panels.into())
        .map(|panel| Axis::new(figure.value_range(panel), 0.0, &panel.unit, usize::from(rows / 2)))
        .collect();
    let gutter = values.iter().map(Axis::label_width).max().unwrap_or(0).min(usize::from(width / 2)) as u16;
    let mut page = Buffer::empty(Rect::new(0, 0, width, 1 + panels * (rows + 1) + axes));
    put(&mut page, 0, 0, &figure.title, bold());
    let mut area = Rect::new(gutter + 1, 2, width - gutter - 1, rows);
    for (index, (panel, value)) in figure.panels.iter().zip(&values).enumerate() {
        let unit = panel.across.as_ref().map_or("s", |across| &across.unit);
        let across = Axis::new(figure.across_range(panel), 0.0, unit, usize::from((width - gutter) / 10));
        let looks = looks(panel, colour);
        header(&mut page, area.y - 1, panel, value, &looks);
        value_axis(&mut page, area, value);
        curves(&mut page, area, figure, panel, (&across, value), &looks);
        area.y += rows + 1;
        if has_axis_below(figure, index) {
            axis_below(&mut page, area, &across);
            area.y += 2;
        }
    }
    if figure.panels.is_empty() {
        axis_below(
            &mut page,
            area,
            &Axis::new(figure.time_range(), 0.0, "s", usize::from((width - gutter) / 10)),
        );
    }
    lines(&page, colour)
}

/// Panels over time that stand together share the axis below the last of them.
fn has_axis_below(figure: &Figure, index: usize) -> bool {
    let over_time = |index: usize| figure.panels.get(index).is_some_and(|panel| panel.across.is_none());
    !over_time(index) || !over_time(index + 1)
}

fn looks(panel: &Panel, colour: bool) -> Vec<Look> {
    let mut looks: Vec<Look> = Vec::new();
    for (index, series) in panel.series.iter().enumerate() {
        let own = Stroke::from(series.style);
        let taken = |stroke: Stroke| looks.iter().any(|look| look.stroke == stroke);
        let free = || Stroke::LINES.into_iter().find(|&stroke| !taken(stroke)).unwrap_or(own);
        let stroke = if colour || own == Stroke::Shade || !taken(own) { own } else { free() };
        looks.push(Look { stroke, colour: Color::Indexed(COLOURS[index % COLOURS.len()]) });
    }
    looks
}

fn header(page: &mut Buffer, y: u16, panel: &Panel, value: &Axis, looks: &[Look]) {
    let mut x = put(page, 0, y, &panel.title, bold());
    if !value.unit.is_empty() {
        x = put(page, x, y, &format!(" [{}]", value.unit), CellStyle::new());
    }
    if let (Some(across), Some(series)) = (&panel.across, panel.series.first()) {
        let over = format!("   {} over {}", series.name, across.series.name);
        put(page, x, y, &over, CellStyle::new());
        return;
    }
    for (series, look) in panel.legend().iter().zip(looks) {
        x = put(page, x.saturating_add(3), y, look.stroke.sample(), CellStyle::new().fg(look.colour));
        x = put(page, x.saturating_add(1), y, &series.name, CellStyle::new());
    }
}

fn value_axis(page: &mut Buffer, area: Rect, value: &Axis) {
    let x = area.x - 1;
    for y in area.rows().map(|row| row.y) {
        put(page, x, y, "│", CellStyle::new());
    }
    for tick in &value.ticks {
        let dot = (1.0 - value.fraction(tick.value)) * f64::from(dots(area).1);
        let y = area.y + dot.round() as u16 / 4;
        let label_width = tick.label.chars().count() as u16;
        put(page, x.saturating_sub(label_width), y, &tick.label, CellStyle::new());
        put(page, x, y, "┤", CellStyle::new());
    }
}

fn axis_below(page: &mut Buffer, area: Rect, time: &Axis) {
    let line = format!("└{}", "─".repeat(area.width.into()));
    put(page, area.x - 1, area.y - 1, &line, CellStyle::new());
    for (index, tick) in time.ticks.iter().enumerate() {
        let x = area.x + (time.fraction(tick.value) * f64::from(dots(area).0)).round() as u16 / 2;
        put(page, x, area.y - 1, "┬", CellStyle::new());
        let last = index + 1 == time.ticks.len();
        let label = if last { format!("{} {}", tick.label, time.unit) } else { tick.label.clone() };
        let middle = tick.label.chars().count() as u16 / 2;
        let rightmost = area.right().saturating_sub(label.chars().count() as u16);
        put(page, x.saturating_sub(middle).min(rightmost), area.y, &label, CellStyle::new());
    }
}

fn curves(
    page: &mut Buffer,
    area: Rect,
    figure: &Figure,
    panel: &Panel,
    axes: (&Axis, &Axis),
    looks: &[Look],
) {
    let (right, bottom) = dots(area);
    let place = |(time_s, value): (f64, f64)| -> Point {
        (axes.0.fraction(time_s) * f64::from(right), axes.1.fraction(value) * f64::from(bottom))
    };
    let curves: Vec<Vec<Point>> =
        panel.series.iter().map(|series| thinned(figure.samples(panel, series).map(place), 0.1)).collect();
    if curves.iter().all(Vec::is_empty) {
        put(page, area.x + area.width / 2 - 5, area.y + area.height / 2, "no samples", CellStyle::new());
        return;
    }
    shade(page, area, figure, panel, axes.0, looks);
    let paint = |context: &mut Context<'_>| {
        for (points, look) in curves.iter().zip(looks) {
            draw(context, points, *look);
        }
    };
    let bounds = (f64::from(right), f64::from(bottom));
    Canvas::default().x_bounds([0.0, bounds.0]).y_bounds([0.0, bounds.1]).paint(paint).render(area, page);
}

/// The bands, under the curves.
fn shade(page: &mut Buffer, area: Rect, figure: &Figure, panel: &Panel, time: &Axis, looks: &[Look]) {
    let column = |time_s: f64| (time.fraction(time_s) * f64::from(area.width - 1)).round() as u16;
    for (series, look) in panel.series.iter().zip(looks).filter(|(series, _)| series.style == Style::Band) {
        for (from, to) in figure.spans(panel, series) {
            let (from, to) = (column(from.min(to)), column(from.max(to)));
            for row in area.rows() {
                put(
                    page,
                    area.x + from,
                    row.y,
                    &"░".repeat((to - from + 1).into()),
                    CellStyle::new().fg(look.colour),
                );
            }
        }
    }
}

fn draw(context: &mut Context<'_>, points: &[Point], look: Look) {
    let pieces = match (look.stroke, points) {
        (_, &[only]) => vec![[only, only]],
        (Stroke::Solid, _) => points.windows(2).map(|pair| [pair[0], pair[1]]).collect(),
        (Stroke::Dashed, _) => dashes(points, 6.0, 4.0),
        (Stroke::Dotted, _) => dashes(points, 0.0, 3.0),
        (Stroke::Shade, _) => Vec::new(),
    };
    for [from, to] in pieces {
        context.draw(&Line::new(from.0, from.1, to.0, to.1, look.colour));
    }
}

/// The last dot to the right and the last downwards.
fn dots(area: Rect) -> (u16, u16) {
    (2 * area.width - 1, 4 * area.height - 1)
}

fn bold() -> CellStyle {
    CellStyle::new().add_modifier(Modifier::BOLD)
}

/// Puts a text on the page, cut off at its right edge, and says where it ends.
fn put(page: &mut Buffer, x: u16, y: u16, text: &str, style: CellStyle) -> u16 {
    if x >= page.area.right() {
        return x;
    }
    page.set_stringn(x, y, text, usize::from(page.area.width), style).0
}

fn lines(page: &Buffer, colour: bool) -> String {
    let line = |row: Rect| {
        let mut line = String::new();
        let mut hidden = 0;
        let mut now = anstyle::Style::new();
        for x in row.columns().map(|column| column.x) {
            let cell = &page[(x, row.y)];
            if hidden > 0 {
                hidden -= 1;
                continue;
            }
            hidden = cell.symbol().cell_width().saturating_sub(1);
            let style = if colour { ansi(cell.fg, cell.modifier) } else { anstyle::Style::new() };
            if style != now {
                line += &format!("{now:#}{style}");
                now = style;
            }
            line += cell.symbol();
        }
        format!("{}{now:#}\n", line.trim_end())
    };
    page.area.rows().map(line).collect()
}

fn ansi(colour: Color, modifier: Modifier) -> anstyle::Style {
    let style = anstyle::Style::new();
    let style = if modifier.contains(Modifier::BOLD) { style.bold() } else { style };
    match colour {
        Color::Indexed(index) => style.fg_color(Some(anstyle::Ansi256Color(index).into())),
        _ => style,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::plot::sample::movement;
    use crate::plot::{Across, Series};

    #[test]
    fn a_movement() {
        insta::assert_snapshot!(terminal(&movement(2000), 80, 44, false));
    }

    #[test]
    fn a_movement_in_colour() {
        insta::assert_snapshot!(terminal(&movement(2000), 80, 32, true).replace('\x1b', "␛"));
    }

    #[test]
    fn little_to_show() {
        let panel = |title: &str, values: &[f64]| Panel {
            title: title.to_owned(),
            unit: "A".to_owned(),
            across: None,
            series: vec![Series { name: "i".to_owned(), values: values.to_vec(), style: Style::Solid }],
        };
        let panels = vec![
            panel("nothing", &[]),
            panel("once", &[0.004]),
            panel("constant", &[-2.0; 3]),
            panel("huge", &[f64::MIN, 0.0, f64::MAX]),
            panel("tiny", &[0.0, 5e-324, 1e-200]),
        ];
        let figure = Figure { title: "corners".to_owned(), time_s: vec![0.0, 1e-4, 3e-4], panels };
        insta::assert_snapshot!(terminal(&figure, 60, 30, false));
        insta::assert_snapshot!(terminal(&Figure::default(), 0, 0, false));
    }

    #[test]
    fn colour_is_all_that_colour_adds() {
        let mut figure = movement(100);
        figure.panels[2].series[1].style = Style::Dashed;
        let coloured = terminal(&figure, 80, 40, true);
        assert_ne!(coloured, terminal(&figure, 80, 40, false));
        assert_eq!(anstream::adapter::strip_str(&coloured).to_string(), terminal(&figure, 80, 40, false));
    }

    proptest! {
        #[test]
        fn whatever_the_values(
            time_s in prop::collection::vec(any::<f64>(), 0..20),
            values in prop::collection::vec(any::<f64>(), 0..20),
            name in ".{0,50}",
            (width, height) in (0_u16..150, 0_u16..100),
            colour: bool,
        ) {
            let series = Series { name: name.clone(), values, style: Style::Dashed };
            let band = Series { style: Style::Band, ..series.clone() };
            let across = Some(Across { unit: name.clone(), series: series.clone() });
            let series = vec![series.clone(), series, band];
            let panel = Panel { title: name.clone(), unit: name.clone(), across: None, series };
            let xy = Panel { across, ..panel.clone() };
            let figure = Figure { title: name, time_s, panels: vec![panel.clone(), panel.clone(), xy, panel] };
            let text = anstream::adapter::strip_str(&terminal(&figure, width, height, colour)).to_string();
            for line in text.lines() {
                prop_assert!(line.cell_width() <= width.max(LEAST_WIDTH), "{line}");
            }
            prop_assert!(text.lines().count() <= usize::from(height.max(4 * (LEAST_PANEL + 1) + 7)));
        }
    }
}
