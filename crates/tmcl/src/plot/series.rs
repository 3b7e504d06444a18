//! What a plot shows.

/// Panels one above the other over the same time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Figure {
    /// Stands above all.
    pub(crate) title: String,
    /// When the samples were taken, in seconds, ascending.
    pub(crate) time_s: Vec<f64>,
    /// From top to bottom.
    pub(crate) panels: Vec<Panel>,
}

/// One diagram.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Panel {
    /// What is shown, as "velocity".
    pub(crate) title: String,
    /// The unit of all its values, as "rpm"; empty for a bare number.
    pub(crate) unit: String,
    /// The curves; later ones are drawn over earlier ones.
    pub(crate) series: Vec<Series>,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Series {
    /// As the legend has it.
    pub(crate) name: String,
    /// One value for each instant of the figure's `time_s`, in the panel's unit. Surplus values, and values that are not
    /// finite, are not drawn.
    pub(crate) values: Vec<f64>,
    /// How the line is drawn.
    pub(crate) style: Style,
}

/// How a line is drawn. A dashed line over a solid one lets both be seen where they agree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Style {
    #[default]
    Solid,
    Dashed,
}

impl Figure {
    /// The first and the last instant.
    pub(super) fn time_range(&self) -> Option<(f64, f64)> {
        range(self.time_s.iter().copied())
    }

    /// The lowest and the highest value of a panel that is drawn.
    pub(super) fn value_range(&self, panel: &Panel) -> Option<(f64, f64)> {
        range(panel.series.iter().flat_map(|series| self.samples(series).map(|(_, value)| value)))
    }

    /// Instants and values of a curve, without those that cannot be drawn.
    pub(super) fn samples<'a>(&'a self, series: &'a Series) -> impl Iterator<Item = (f64, f64)> + 'a {
        let pairs = self.time_s.iter().copied().zip(series.values.iter().copied());
        pairs.filter(|(time_s, value)| time_s.is_finite() && value.is_finite())
    }
}

impl Panel {
    /// The curves to name in a legend: none where the title says it already.
    pub(super) fn legend(&self) -> &[Series] {
        match self.series.as_slice() {
            [only] if only.name.is_empty() || only.name == self.title => &[],
            series => series,
        }
    }
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |range, value| match range {
        None => Some((value, value)),
        Some((low, high)) => Some((value.min(low), value.max(high))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_can_be_drawn_counts() {
        let values = vec![1.0, f64::NAN, -2.0, 99.0];
        let panel = Panel { series: vec![Series { values, ..Series::default() }], ..Panel::default() };
        let figure = Figure { time_s: vec![0.0, 1.0, 2.0], ..Figure::default() };
        assert_eq!(figure.value_range(&panel), Some((-2.0, 1.0)));
        assert_eq!(figure.time_range(), Some((0.0, 2.0)));
        assert_eq!(figure.value_range(&Panel::default()), None);
    }

    #[test]
    fn a_legend_does_not_repeat_the_title() {
        let series = |name: &str| Series { name: name.to_owned(), ..Series::default() };
        let panel = |series| Panel { title: "velocity".to_owned(), series, ..Panel::default() };
        assert_eq!(panel(vec![series("velocity")]).legend().len(), 0);
        assert_eq!(panel(vec![series("encoder")]).legend().len(), 1);
        assert_eq!(panel(vec![series("velocity"), series("encoder")]).legend().len(), 2);
    }
}
