//! Plots of a run, as an SVG file and in a terminal.
//!
//! A [`Figure`] holds what is to be seen; [`svg()`] and [`terminal()`] turn it into text. Both are pure functions and
//! never fail, whatever the values. Nothing here knows a bench, a module, a file or the terminal's size.

mod axis;
mod curve;
mod number;
mod path;
#[cfg(test)]
mod sample;
mod series;
mod svg;
mod terminal;

pub(crate) use self::svg::svg;
pub(crate) use self::terminal::terminal;
pub(crate) use series::{Figure, Panel, Series, Style};
