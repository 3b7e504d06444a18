//! A panel's frame, grid, curves and axis labels.

use svg::node::element::{Group, Path};

use super::shape::Shape;
use super::{RIGHT, curve_class, path, rectangle, text};
use crate::plot::axis::Axis;
use crate::plot::curve::{Point, retraced, thinned};
use crate::plot::path::path_data;
use crate::plot::{Across, Figure, Panel, Series, Style};

/// Where a panel's curves are drawn, in pixels, and its axes.
pub(super) struct Area<'a> {
    left: f64,
    right: f64,
    top: f64,
    pub(super) bottom: f64,
    across: &'a Axis,
    value: &'a Axis,
}

impl<'a> Area<'a> {
    /// The area of a panel whose upper left corner is there.
    pub(super) fn new(shape: &'a Shape, left: f64, top: f64) -> Self {
        let right = shape.width.map_or(RIGHT, |width| left + width);
        Self { left, right, top, bottom: top + shape.height, across: &shape.across, value: &shape.value }
    }

    fn x(&self, across: f64) -> f64 {
        self.left + self.across.fraction(across) * (self.right - self.left)
    }

    fn y(&self, value: f64) -> f64 {
        self.bottom - self.value.fraction(value) * (self.bottom - self.top)
    }
}

/// All but the labels below it, which panels may share.
pub(super) fn diagram(figure: &Figure, panel: &Panel, area: &Area<'_>) -> Group {
    let mut diagram = bands(figure, panel, area).add(grid(area)).add(frame(area));
    if area.value.crosses_zero() {
        let y = area.y(0.0);
        diagram = diagram.add(path(&[(area.left, y), (area.right, y)]).set("class", "zero"));
    }
    for tick in &area.value.ticks {
        diagram = diagram.add(text("tick end", area.left - 7.0, area.y(tick.value) + 4.0, &tick.label));
    }
    let mut empty = true;
    for (index, series) in panel.series.iter().enumerate().filter(|(_, series)| series.style != Style::Band) {
        for points in lines(figure, panel, series, area) {
            empty = false;
            diagram = diagram.add(path(&points).set("class", curve_class(index, series.style)));
        }
    }
    if empty && !panel.series.iter().any(|series| series.style == Style::Band) {
        let middle = (area.left + area.right) / 2.0;
        diagram = diagram.add(text("muted middle", middle, (area.top + area.bottom) / 2.0, "no samples"));
    }
    diagram
}

fn bands(figure: &Figure, panel: &Panel, area: &Area<'_>) -> Group {
    let mut group = Group::new();
    for (index, series) in panel.series.iter().enumerate().filter(|(_, series)| series.style == Style::Band) {
        for (from, to) in figure.spans(panel, series) {
            let band = rectangle((area.x(from.min(to)), area.top), (area.x(from.max(to)), area.bottom));
            group = group.add(band.set("class", curve_class(index, series.style)));
        }
    }
    group
}

/// The lines that make up a curve.
fn lines(figure: &Figure, panel: &Panel, series: &Series, area: &Area<'_>) -> Vec<Vec<Point>> {
    let points = figure.samples(panel, series).map(|(across, value)| (area.x(across), area.y(value)));
    if panel.across.is_some() {
        return retraced(points, 0.1);
    }
    let points = thinned(points, 0.1);
    if points.is_empty() { Vec::new() } else { vec![points] }
}

fn grid(area: &Area<'_>) -> Path {
    let across = area.value.ticks.iter().map(|tick| area.y(tick.value));
    let across = across.map(|y| path_data(&[(area.left, y), (area.right, y)]));
    let upright = area.across.ticks.iter().map(|tick| area.x(tick.value));
    let upright = upright.map(|x| path_data(&[(x, area.top), (x, area.bottom)]));
    Path::new().set("class", "grid").set("d", across.chain(upright).collect::<String>())
}

fn frame(area: &Area<'_>) -> Path {
    let (left, bottom) = (area.left, area.bottom);
    path(&[(left, area.top), (left, bottom), (area.right, bottom)]).set("class", "frame")
}

/// The labels of the axis to the right, and what it is.
pub(super) fn labels_below(area: &Area<'_>, across: Option<&Across>) -> Group {
    let mut labels = Group::new();
    for tick in &area.across.ticks {
        labels = labels.add(text("tick middle", area.x(tick.value), area.bottom + 16.0, &tick.label));
    }
    let name = across.map_or("time", |across| across.series.name.as_str());
    let unit = &area.across.unit;
    let name = if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") };
    labels.add(text("muted middle", (area.left + area.right) / 2.0, area.bottom + 34.0, &name))
}
