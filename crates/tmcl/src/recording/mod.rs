//! What a run leaves behind: a trace in a CSV file, a plot, a figure for the terminal.

mod drawing;
mod units;
mod usual;

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use virtual_bench::{Bench, ModuleId, Trace};

use crate::arguments::Recording;
use crate::exit::{Code, Failure};
use crate::plot::{self, Figure};
use drawing::{Drawing, prefixed};

/// Samples kept for a plot; older ones go.
const KEPT: usize = 200_000;

/// Samples between two writes to the trace file.
const CHUNK: usize = 256;

/// Records a bench while it runs.
pub(crate) struct Recorder {
    trace: Trace,
    /// The first ones of the trace.
    usual: &'static [&'static str],
    drawing: Drawing,
    written: usize,
    csv: Option<BufWriter<File>>,
    /// The first failure to write; there is no point in trying again.
    failure: Option<io::Error>,
}

impl Recorder {
    /// A recorder of `bench` as the options say, a sample every `every_ns` unless they say otherwise.
    pub(crate) fn new(bench: &Bench, options: &Recording, every_ns: u64) -> Result<Self, Failure> {
        let drawing = Drawing::new(bench, &options.panel)
            .map_err(|error| Failure::new(Code::Usage, format!("in --panel: {error}")))?;
        let usual = usual::columns(bench);
        let mut columns: Vec<String> = usual.iter().map(|name| prefixed(bench, ModuleId(0), name)).collect();
        columns.extend(options.column.iter().cloned());
        for name in drawing.columns() {
            if !columns.iter().any(|column| column == name) {
                columns.push(name.to_owned());
            }
        }
        let every_ns = options.every.unwrap_or(every_ns);
        let trace = Trace::new(bench, &columns, every_ns)
            .map_err(|error| Failure::new(Code::Usage, error.to_string()))?;
        let csv = options.trace.as_deref().map(|path| create(path, &trace)).transpose()?;
        Ok(Self { trace, usual, drawing, written: 0, csv, failure: None })
    }

    /// [`Recorder::new`] where the options name a file to record to.
    pub(crate) fn wanted(bench: &Bench, options: &Recording, every_ns: u64) -> Result<Option<Self>, Failure> {
        let draws = !options.panel.is_empty() || options.title.is_some() || options.plot_from.is_some();
        if draws && options.plot.is_none() {
            let message = "--panel, --title and --plot-from say what to draw: add --plot FILE.svg";
            return Err(Failure::new(Code::Usage, message));
        }
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
            std::fs::write(path, plot::svg(&self.figure(options, title))).map_err(|error| {
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

    /// The panels that were asked for, or position, velocity, load and currents. The title gives way to one that was
    /// asked for.
    pub(crate) fn figure(&self, options: &Recording, title: &str) -> Figure {
        let title = options.title.as_deref().unwrap_or(title);
        self.drawing.figure(&self.trace, title, options.plot_from.unwrap_or(0))
    }

    /// Where the first module says that its motor is, in turns.
    pub(crate) fn commanded_turns(&self, bench: &Bench) -> Vec<f64> {
        drawing::commanded_turns(bench, &self.trace)
    }

    /// When the samples were taken.
    pub(crate) fn times_ns(&self) -> &[u64] {
        self.trace.times_ns()
    }

    /// The samples of one of the usual columns by its name.
    pub(crate) fn values(&self, name: &str) -> Vec<f64> {
        let index = self.usual.iter().position(|column| *column == name);
        index.map(|index| self.trace.values(index).collect()).unwrap_or_default()
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
