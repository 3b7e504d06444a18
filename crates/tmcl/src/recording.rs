//! What a run leaves behind: a trace in a CSV file, a plot, a figure for the terminal.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use virtual_bench::{Bench, Trace};

use crate::arguments::Recording;
use crate::exit::{Code, Failure};
use crate::plot::{self, Figure, Panel, Series, Style};

/// What is recorded when nothing is said.
const COLUMNS: [&str; 15] = [
    "actual_position",
    "physical.rotor_turns",
    "encoder_counter",
    "actual_velocity",
    "physical.velocity_rpm",
    "physical.load_nm",
    "physical.torque_nm",
    "physical.load_angle_deg",
    "physical.coil_a_a",
    "physical.coil_b_a",
    "physical.bus_voltage_v",
    "physical.supply_current_a",
    "load_value",
    "microstep_resolution",
    "motor_full_steps",
];

/// Samples kept for a plot; older ones go.
const KEPT: usize = 200_000;

/// Samples between two writes to the trace file.
const CHUNK: usize = 256;

/// Records a bench while it runs.
pub(crate) struct Recorder {
    trace: Trace,
    written: usize,
    csv: Option<BufWriter<File>>,
    /// The first failure to write; there is no point in trying again.
    failure: Option<io::Error>,
}

impl Recorder {
    /// A recorder of `bench` as the options say, a sample every `every_ns` unless they say otherwise.
    pub(crate) fn new(bench: &Bench, options: &Recording, every_ns: u64) -> Result<Self, Failure> {
        let mut columns: Vec<String> = COLUMNS.iter().map(|name| prefixed(bench, name)).collect();
        columns.extend(options.column.iter().cloned());
        let every_ns = options.every.unwrap_or(every_ns);
        let trace = Trace::new(bench, &columns, every_ns)
            .map_err(|error| Failure::new(Code::Usage, error.to_string()))?;
        let csv = options.trace.as_deref().map(|path| create(path, &trace)).transpose()?;
        Ok(Self { trace, written: 0, csv, failure: None })
    }

    /// [`Recorder::new`] where the options name a file to record to.
    pub(crate) fn wanted(bench: &Bench, options: &Recording, every_ns: u64) -> Result<Option<Self>, Failure> {
        if options.trace.is_some() || options.plot.is_some() {
            return Self::new(bench, options, every_ns).map(Some);
        }
        if options.every.is_some() || !options.column.is_empty() {
            let message = "--every and --column say what to record: add --trace FILE.csv or --plot FILE.svg";
            return Err(Failure::new(Code::Usage, message));
        }
        Ok(None)
    }

    /// Runs the bench on, and takes samples on the way.
    pub(crate) fn advance_to(&mut self, bench: &mut Bench, time_ns: u64) {
        self.trace.advance_to(bench, time_ns);
        self.keep_up();
    }

    /// When the next sample falls due.
    pub(crate) fn next_sample_ns(&self) -> u64 {
        self.trace.next_sample_ns()
    }

    /// Takes a sample if one is due, of a bench that somebody else runs on.
    pub(crate) fn sample_if_due(&mut self, bench: &Bench) {
        self.trace.sample_if_due(bench);
        self.keep_up();
    }

    /// Writes samples down and forgets the oldest, now and then.
    fn keep_up(&mut self) {
        let taken = self.trace.times_ns().len();
        if taken - self.written >= CHUNK {
            self.write();
        }
        if taken >= 2 * KEPT {
            self.write();
            self.trace.keep_last(KEPT);
            self.written = self.trace.times_ns().len();
        }
    }

    /// Writes down what is left, and the plot where one was asked for.
    pub(crate) fn finish(&mut self, options: &Recording, title: &str) -> Result<(), Failure> {
        self.write();
        let flushed = self.csv.as_mut().map_or(Ok(()), Write::flush);
        if let Some(error) = self.failure.take().or(flushed.err()) {
            return Err(Failure::new(Code::Usage, format!("cannot write the trace: {error}")));
        }
        if let Some(path) = &options.plot {
            std::fs::write(path, plot::svg(&self.figure(title))).map_err(|error| {
                Failure::new(Code::Usage, format!("cannot write {}: {error}", path.display()))
            })?;
        }
        Ok(())
    }

    fn write(&mut self) {
        let rows = self.trace.csv_rows(self.written);
        self.written = self.trace.times_ns().len();
        let outcome = match (&mut self.csv, &self.failure) {
            (Some(csv), None) => csv.write_all(rows.as_bytes()),
            _ => Ok(()),
        };
        self.failure = self.failure.take().or(outcome.err());
    }

    /// Commanded and physical position and velocity, load, and coil currents.
    pub(crate) fn figure(&self, title: &str) -> Figure {
        let turns = |name: &str, scale: f64| self.in_turns(name).map(|turns| turns * scale).collect();
        let column = |name: &str| self.values(name);
        let series = |name: &str, values: Vec<f64>, style| Series { name: name.to_owned(), values, style };
        let panel = |title: &str, unit: &str, series| Panel {
            title: title.to_owned(),
            unit: unit.to_owned(),
            series,
        };
        let solid = Style::Solid;
        Figure {
            title: title.to_owned(),
            time_s: self.trace.times_ns().iter().map(|time_ns| *time_ns as f64 * 1e-9).collect(),
            panels: vec![
                panel(
                    "Position",
                    "turn",
                    vec![
                        series("physical", column("physical.rotor_turns"), solid),
                        series("commanded", turns("actual_position", 1.0), Style::Dashed),
                    ],
                ),
                panel(
                    "Velocity",
                    "rpm",
                    vec![
                        series("physical", column("physical.velocity_rpm"), solid),
                        series("commanded", turns("actual_velocity", 60.0), Style::Dashed),
                    ],
                ),
                panel(
                    "Load",
                    "Nm",
                    vec![
                        series("motor", column("physical.torque_nm"), solid),
                        series("load", column("physical.load_nm"), Style::Dashed),
                    ],
                ),
                panel(
                    "Load angle",
                    "°",
                    vec![series("Load angle", column("physical.load_angle_deg"), solid)],
                ),
                panel(
                    "Coil currents",
                    "A",
                    vec![
                        series("A", column("physical.coil_a_a"), solid),
                        series("B", column("physical.coil_b_a"), solid),
                    ],
                ),
            ],
        }
    }

    /// A column that counts microsteps, in turns.
    pub(crate) fn in_turns(&self, name: &str) -> impl Iterator<Item = f64> {
        let steps = self.values("motor_full_steps").into_iter().zip(self.values("microstep_resolution"));
        let per_turn = steps.map(|(full_steps, resolution)| full_steps * resolution.exp2());
        self.values(name).into_iter().zip(per_turn).map(|(microsteps, per_turn)| microsteps / per_turn)
    }

    /// The samples of a column by its name.
    pub(crate) fn values(&self, name: &str) -> Vec<f64> {
        let index = COLUMNS.iter().position(|column| *column == name);
        index.map(|index| self.trace.values(index).collect()).unwrap_or_default()
    }
}

/// The first module's, by its name where the bench has several.
fn prefixed(bench: &Bench, name: &str) -> String {
    match bench.modules().count() {
        0 | 1 => name.to_owned(),
        _ => format!("{}.{name}", bench.name(virtual_bench::ModuleId(0)).unwrap_or("m1")),
    }
}

fn create(path: &Path, trace: &Trace) -> Result<BufWriter<File>, Failure> {
    let created = File::create(path).and_then(|file| {
        let mut csv = BufWriter::new(file);
        csv.write_all(trace.csv_header().as_bytes())?;
        Ok(csv)
    });
    created.map_err(|error| Failure::new(Code::Usage, format!("cannot write {}: {error}", path.display())))
}
