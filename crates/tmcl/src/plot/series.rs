//! What a plot shows.

/// Panels one above the other, all over the same time but for those over a quantity of their own.
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
    /// What the curves are drawn over, if that is not time.
    pub(crate) across: Option<Across>,
    /// The curves; later ones are drawn over earlier ones.
    pub(crate) series: Vec<Series>,
}

/// What lies to the right in a panel that is not over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Across {
    /// Its unit.
    pub(crate) unit: String,
    /// Its name, and its value at each instant.
    pub(crate) series: Series,
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
    /// No line: the panel is shaded while the value is not 0.
    Band,
}

impl Figure {
    /// The first and the last instant.
    pub(super) fn time_range(&self) -> Option<(f64, f64)> {
        range(self.time_s.iter().copied())
    }

    /// The lowest and the highest value of a panel that is drawn.
    pub(super) fn value_range(&self, panel: &Panel) -> Option<(f64, f64)> {
        let lines = panel.series.iter().filter(|series| series.style != Style::Band);
        range(lines.flat_map(|series| self.samples(panel, series).map(|(_, value)| value)))
    }

    /// The range of what a panel is drawn over.
    pub(super) fn across_range(&self, panel: &Panel) -> Option<(f64, f64)> {
        let Some(across) = &panel.across else { return self.time_range() };
        range(across.series.values.iter().copied())
    }

    /// What a panel is drawn over, mostly instants, and values of a curve, without those that cannot be drawn.
    pub(super) fn samples<'a>(
        &'a self,
        panel: &'a Panel,
        series: &'a Series,
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        let across = panel.across.as_ref().map_or(&self.time_s, |across| &across.series.values);
        let pairs = across.iter().copied().zip(series.values.iter().copied());
        pairs.filter(|(across, value)| across.is_finite() && value.is_finite())
    }

    /// The spans of time in which a band is to be seen.
    pub(super) fn spans(&self, panel: &Panel, band: &Series) -> Vec<(f64, f64)> {
        let mut spans: Vec<(f64, f64)> = Vec::new();
        let mut before = 0.0;
        for (time_s, value) in self.samples(panel, band) {
            match spans.last_mut() {
                Some(span) if before != 0.0 => span.1 = time_s,
                _ if value != 0.0 => spans.push((time_s, time_s)),
                _ => {}
            }
            before = value;
        }
        spans
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
    fn a_band_lasts_until_the_value_is_0_again() {
        let band =
            Series { values: vec![0.0, 1.0, 2.0, 0.0, 0.0, 1.0], style: Style::Band, ..Series::default() };
        let panel = Panel { series: vec![band.clone()], ..Panel::default() };
        let figure = Figure { time_s: (0..6).map(f64::from).collect(), ..Figure::default() };
        assert_eq!(figure.spans(&panel, &band), [(1.0, 3.0), (5.0, 5.0)]);
        assert_eq!(figure.value_range(&panel), None, "it has no height");
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
