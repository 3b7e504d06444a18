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
pub(crate) use series::{Across, Figure, Panel, Series, Style};

#[cfg(test)]
mod tests {
    use super::*;

    /// Libraries that keep things in hash maps would show them in another order now and then.
    #[test]
    fn the_same_figure_gives_the_same_text() {
        let figure = sample::movement(500);
        let again = figure.clone();
        assert_eq!(svg(&figure), svg(&again));
        assert_eq!(terminal(&figure, 80, 40, true), terminal(&again, 80, 40, true));
    }
}
