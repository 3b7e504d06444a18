//! What a plot of a run shows: panels, the columns of the trace they are made of, and their units.

use virtual_bench::{Bench, ModuleId, Trace};

use super::units::{self, Conversion, Counting, Steps, Unit};
use super::usual;
use crate::panel::{self, CurveText, Look, PanelText};
use crate::plot::{Across, Figure, Panel, Series, Style};

/// How a run is drawn.
pub(super) struct Drawing {
    panels: Vec<DrawnPanel>,
}

struct DrawnPanel {
    title: String,
    /// That of the vertical axis.
    unit: String,
    curves: Vec<Curve>,
    xy: bool,
}

struct Curve {
    text: CurveText,
    unit: Unit,
    counting: Counting,
    /// Of the trace, in the order of [`Counting::columns`].
    steps: Vec<String>,
    shown_in: String,
    conversion: Conversion,
}

impl Drawing {
    /// A drawing of these panels, or of the usual ones where there are none.
    ///
    /// # Errors
    /// What is wrong with a panel: a name that means nothing on this bench, or units that do not go together.
    pub(super) fn new(bench: &Bench, panels: &[PanelText]) -> Result<Self, String> {
        let usual;
        let panels = if panels.is_empty() {
            usual = usual_panels(bench)?;
            &usual
        } else {
            panels
        };
        Ok(Self {
            panels: panels.iter().map(|panel| DrawnPanel::new(bench, panel)).collect::<Result<_, _>>()?,
        })
    }

    /// The columns of a trace that it is made of; some more than once.
    pub(super) fn columns(&self) -> impl Iterator<Item = &str> {
        let curves = self.panels.iter().flat_map(|panel| &panel.curves);
        curves.flat_map(|curve| {
            let steps = if curve.is_of_motion() { &curve.steps[..] } else { &[] };
            std::iter::once(curve.text.name.as_str()).chain(steps.iter().map(String::as_str))
        })
    }

    /// The figure of a trace with these columns, from `from_ns` on.
    pub(super) fn figure(&self, trace: &Trace, title: &str, from_ns: u64) -> Figure {
        let first = trace.times_ns().partition_point(|time_ns| *time_ns < from_ns);
        let time_s = trace.times_ns().iter().skip(first).map(|time_ns| *time_ns as f64 * 1e-9).collect();
        let panels = self.panels.iter().map(|panel| panel.shown(trace, first)).collect();
        Figure { title: title.to_owned(), time_s, panels }
    }
}

fn usual_panels(bench: &Bench) -> Result<Vec<PanelText>, String> {
    let mut panels =
        usual::panels(bench).iter().map(|text| panel::parse(text)).collect::<Result<Vec<_>, _>>()?;
    for curve in panels.iter_mut().flat_map(|panel| &mut panel.curves) {
        curve.name = prefixed(bench, ModuleId(0), &curve.name);
    }
    Ok(panels)
}

impl DrawnPanel {
    fn new(bench: &Bench, panel: &PanelText) -> Result<Self, String> {
        let curves =
            panel.curves.iter().map(|curve| Curve::new(bench, curve)).collect::<Result<Vec<_>, _>>()?;
        let mut drawn = Self { title: panel.title.clone(), unit: String::new(), curves, xy: panel.xy };
        drawn.choose_units(panel.unit.as_deref())?;
        Ok(drawn)
    }

    /// One unit for all curves: the one that is named, or one they have in common. Over another curve each may have its own.
    fn choose_units(&mut self, named: Option<&str>) -> Result<(), String> {
        let lines: Vec<&Curve> = self.curves.iter().filter(|curve| curve.text.look != Look::Band).collect();
        let units: Vec<Unit> = lines.iter().map(|curve| curve.unit).collect();
        let one = named.or(units::common(&units)).map(str::to_owned);
        if one.is_none() && !self.xy && !lines.is_empty() {
            return Err(apart(&lines));
        }
        for curve in self.curves.iter_mut().filter(|curve| curve.text.look != Look::Band) {
            let own = units::common(&[curve.unit]).unwrap_or_default();
            curve.show_in(one.as_deref().unwrap_or(own))?;
            self.unit.clone_from(&curve.shown_in);
        }
        Ok(())
    }

    fn shown(&self, trace: &Trace, first: usize) -> Panel {
        let series = |curve: &Curve| Series {
            name: curve.text.label.clone(),
            values: curve.values(trace).split_off(first),
            style: match curve.text.look {
                Look::Solid => Style::Solid,
                Look::Dashed => Style::Dashed,
                Look::Band => Style::Band,
            },
        };
        let across = self
            .curves
            .first()
            .filter(|_| self.xy)
            .map(|curve| Across { unit: curve.shown_in.clone(), series: series(curve) });
        let over_time = usize::from(self.xy);
        Panel {
            title: self.title.clone(),
            unit: self.unit.clone(),
            across,
            series: self.curves.iter().skip(over_time).map(series).collect(),
        }
    }
}

/// Says of two curves that they have no unit in common.
fn apart(curves: &[&Curve]) -> String {
    let said = |curve: &Curve| format!("`{}` ({})", curve.text.name, curve.unit.name());
    let other = curves.iter().find(|curve| units::common(&[curves[0].unit, curve.unit]).is_none());
    let other = other.map_or_else(String::new, |curve| said(curve));
    format!("{} and {other} have no unit in common; give each a panel of its own", said(curves[0]))
}

impl Curve {
    fn new(bench: &Bench, text: &CurveText) -> Result<Self, String> {
        let probe = bench.probe(&text.name).map_err(|error| error.to_string())?;
        let alone = Trace::new(bench, &[&text.name], 0).map_err(|error| error.to_string())?;
        let unit = alone.columns().first().map_or("", |column| column.unit);
        let spec = bench.spec(probe.module);
        let counting = Counting::of(spec);
        Ok(Self {
            text: text.clone(),
            unit: Unit::of(probe, spec, unit),
            counting,
            steps: step_columns(bench, probe.module, counting),
            shown_in: String::new(),
            conversion: Conversion::Factor(1.0),
        })
    }

    fn is_of_motion(&self) -> bool {
        matches!(self.conversion, Conversion::Motion { .. })
    }

    fn show_in(&mut self, unit: &str) -> Result<(), String> {
        let conversion = Conversion::new(self.unit, unit).filter(|_| self.counting.knows(unit));
        self.conversion = conversion.ok_or_else(|| {
            format!("`{}` ({}) cannot be shown in `{unit}`", self.text.name, self.unit.name())
        })?;
        self.shown_in = unit.to_owned();
        Ok(())
    }

    fn values(&self, trace: &Trace) -> Vec<f64> {
        let values = trace.values_of(&self.text.name).unwrap_or_default();
        if !self.is_of_motion() {
            return values
                .into_iter()
                .map(|value| self.conversion.convert(value, Steps::default()))
                .collect();
        }
        let converted = |(value, steps)| self.conversion.convert(value, steps);
        values.into_iter().zip(steps(trace, self.counting, &self.steps)).map(converted).collect()
    }
}

/// The columns that say how many steps a turn of a module's motor has.
fn step_columns(bench: &Bench, module: ModuleId, counting: Counting) -> Vec<String> {
    counting.columns().iter().map(|name| prefixed(bench, module, name)).collect()
}

/// How many steps a turn had, sample by sample, by the columns of these names.
fn steps(trace: &Trace, counting: Counting, names: &[String]) -> Vec<Steps> {
    let columns: Vec<Vec<f64>> = names.iter().map(|name| trace.values_of(name).unwrap_or_default()).collect();
    let at = |sample: usize| -> Vec<f64> {
        columns.iter().filter_map(|column| column.get(sample).copied()).collect()
    };
    (0..trace.times_ns().len()).map(|sample| counting.steps(&at(sample))).collect()
}

/// The positions of the first module in turns.
pub(super) fn commanded_turns(bench: &Bench, trace: &Trace) -> Vec<f64> {
    let module = ModuleId(0);
    let counting = Counting::of(bench.spec(module));
    let names = step_columns(bench, module, counting);
    let in_turns = Conversion::Motion { from: Unit::Steps, to: "turn".to_owned() };
    let positions = trace.values_of(&prefixed(bench, module, "actual_position")).unwrap_or_default();
    let converted = |(value, steps)| in_turns.convert(value, steps);
    positions.into_iter().zip(steps(trace, counting, &names)).map(converted).collect()
}

/// A module's, by its name where the bench has several.
pub(super) fn prefixed(bench: &Bench, module: ModuleId, name: &str) -> String {
    match bench.modules().count() {
        0 | 1 => name.to_owned(),
        _ => format!("{}.{name}", bench.name(module).unwrap_or("m1")),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use virtual_bench::{BenchConfig, ModuleKind};

    use super::*;

    fn bench() -> Bench {
        bench_of(ModuleKind::Tmcm1311)
    }

    fn bench_of(kind: ModuleKind) -> Bench {
        Bench::new(&BenchConfig::default_for(kind))
    }

    fn drawing(texts: &[&str]) -> Result<Drawing, String> {
        drawing_of(ModuleKind::Tmcm1311, texts)
    }

    fn drawing_of(kind: ModuleKind, texts: &[&str]) -> Result<Drawing, String> {
        let panels = texts.iter().map(|text| panel::parse(text)).collect::<Result<Vec<_>, _>>()?;
        Drawing::new(&bench_of(kind), &panels)
    }

    fn unit_of(text: &str) -> Result<String, String> {
        drawing(&[text]).map(|drawing| drawing.panels[0].unit.clone())
    }

    #[test]
    fn a_brushless_motors_units() {
        let unit = |text: &str| {
            drawing_of(ModuleKind::Tmcm1640, &[text]).map(|drawing| drawing.panels[0].unit.clone())
        };
        let is = |text: &str| unit(text).unwrap();
        assert_eq!(
            is("actual_position, encoder_counter, sensed.encoder_counts, physical.rotor_turns"),
            "turn"
        );
        assert_eq!(is("actual_velocity, ramp_velocity, physical.velocity_rpm"), "rpm");
        assert_eq!(is("motor_current, physical.current_q_a"), "A");
        assert_eq!(is("[count]: actual_position, target_position"), "count");
        let error = unit("[µstep]: actual_position").unwrap_err();
        assert_eq!(error, "`actual_position` (steps) cannot be shown in `µstep`");
        let error = unit("[pps]: actual_velocity").unwrap_err();
        assert_eq!(error, "`actual_velocity` (rpm) cannot be shown in `pps`");
    }

    #[test]
    fn every_module_has_something_to_be_drawn() {
        for kind in ModuleKind::ALL {
            let mut bench = bench_of(kind);
            let drawing = Drawing::new(&bench, &[]).unwrap();
            let columns: Vec<&str> = drawing.columns().collect();
            let mut trace = Trace::new(&bench, &columns, 1_000_000).unwrap();
            trace.advance_to(&mut bench, 10_000_000);
            let figure = drawing.figure(&trace, "", 0);
            assert!(figure.panels.len() >= 4);
            let series = figure.panels.iter().flat_map(|panel| &panel.series);
            assert!(series.flat_map(|series| &series.values).all(|value| value.is_finite()));
            for name in usual::columns(&bench) {
                assert!(bench.probe(name).is_ok(), "{name}");
            }
        }
    }

    #[test]
    fn units_are_the_tables() {
        let unit = |text: &str| unit_of(text).unwrap();
        assert_eq!(unit("phase_a_current, phase_b_current"), "mA");
        assert_eq!(unit("phase_a_current, physical.coil_a_a"), "A");
        assert_eq!(unit("encoder_counter, virtual_position"), "turn");
        assert_eq!(unit("actual_velocity, physical.velocity_rpm, band home_switch"), "rpm");
        assert_eq!(unit("actual_velocity"), "pps");
        assert_eq!(unit("position_error"), "turn", "steps of two kinds");
        assert_eq!(unit("[encoder step]: position_error"), "encoder step");
        assert_eq!(unit("band home_switch"), "");
        assert_eq!(unit("xy: physical.velocity_rpm, physical.torque_nm"), "Nm");
    }

    #[test]
    fn what_cannot_be_drawn() {
        let error = |text: &str| unit_of(text).unwrap_err();
        assert!(error("a, b").starts_with("nothing called `a`"));
        assert_eq!(
            error("gamma, physical.torque_nm"),
            "`gamma` (a plain number) and `physical.torque_nm` (Nm) have no unit in common; give each a panel of its own"
        );
        assert_eq!(error("[turn]: supply_voltage"), "`supply_voltage` (0.1 V) cannot be shown in `turn`");
    }

    #[test]
    fn samples_before_the_beginning_are_left_out() {
        let mut bench = bench();
        let drawing = drawing(&["xy: physical.rotor_turns, supply_voltage", "actual_position"]).unwrap();
        let columns: Vec<&str> = drawing.columns().collect();
        let mut trace = Trace::new(&bench, &columns, 1_000_000).unwrap();
        trace.advance_to(&mut bench, 10_000_000);
        let figure = drawing.figure(&trace, "t", 4_000_000);
        assert_eq!(figure.time_s.len(), 7);
        let across = figure.panels[0].across.as_ref().unwrap();
        assert_eq!((across.unit.as_str(), across.series.values.len()), ("turn", 7));
        assert_eq!(figure.panels[0].series.len(), 1);
        assert_eq!(figure.panels[0].series[0].values, [480.0; 7]);
        assert_eq!(figure.panels[1].series[0].values, [0.0; 7]);
    }

    const SOME: [&str; 10] = [
        "actual_position",
        "virtual_position",
        "encoder_counter",
        "sensed.encoder_counts",
        "physical.rotor_turns",
        "physical.velocity_rpm",
        "actual_velocity",
        "phase_a_current",
        "physical.coil_a_a",
        "gamma",
    ];

    proptest! {
        /// What is not refused is drawn, in one unit and with a value for every sample.
        #[test]
        fn whatever_goes_together(
            names in prop::collection::vec(prop::sample::select(&SOME[..]), 1..4),
            unit in prop::sample::select(vec!["", "[turn]", "[µstep]", "[rpm]", "[A]", "[mA]"]),
            xy in prop::sample::select(vec!["", "xy "]),
        ) {
            let Ok(drawing) = drawing(&[&format!("{xy}Panel {unit}: {}", names.join(", "))]) else { return Ok(()) };
            let mut bench = bench();
            let mut trace = Trace::new(&bench, &drawing.columns().collect::<Vec<_>>(), 1_000_000).unwrap();
            trace.advance_to(&mut bench, 2_000_000);
            let panel = &drawing.figure(&trace, "", 0).panels[0];
            let shown = format!("[{}]", panel.unit);
            prop_assert!(unit.is_empty() || unit == shown);
            let across = panel.across.iter().map(|across| &across.series);
            let mut curves = 0;
            for series in across.chain(&panel.series) {
                prop_assert!(series.values.len() == 3 && series.values.iter().all(|value| value.is_finite()));
                curves += 1;
            }
            prop_assert_eq!(curves, names.len());
        }
    }
}
