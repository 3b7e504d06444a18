//! What happened, sample by sample: named columns with units over virtual time.

use core::fmt::Write;

use crate::bench::Bench;
use crate::probe::{Probe, ProbeError, unit};

/// A column of a trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// The name it was asked for by.
    pub name: String,
    /// Its unit; empty for plain numbers.
    pub unit: &'static str,
    probe: Probe,
}

/// Samples of some quantities, every so often.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    columns: Vec<Column>,
    every_ns: u64,
    next_ns: u64,
    times_ns: Vec<u64>,
    values: Vec<f64>,
}

impl Trace {
    /// A trace of the quantities called `names` on `bench`, a sample every `every_ns` from now on.
    ///
    /// # Errors
    /// [`ProbeError`] when a name means nothing on this bench.
    pub fn new<S: AsRef<str>>(bench: &Bench, names: &[S], every_ns: u64) -> Result<Self, ProbeError> {
        let columns = names.iter().map(|name| column(bench, name.as_ref())).collect::<Result<_, _>>()?;
        let every_ns = every_ns.max(crate::TICK_NS);
        Ok(Self { columns, every_ns, next_ns: bench.time_ns(), times_ns: Vec::new(), values: Vec::new() })
    }

    /// Runs `bench` on to `time_ns`, and takes the samples that fall due on the way.
    pub fn advance_to(&mut self, bench: &mut Bench, time_ns: u64) {
        while self.next_ns <= time_ns {
            bench.advance_to(self.next_ns);
            self.sample(bench);
            self.next_ns += self.every_ns;
        }
        bench.advance_to(time_ns);
    }

    /// When the next sample falls due.
    #[must_use]
    pub fn next_sample_ns(&self) -> u64 {
        self.next_ns
    }

    /// Takes a sample if one is due, for those who run the bench on themselves, never past [`Trace::next_sample_ns`].
    pub fn sample_if_due(&mut self, bench: &Bench) {
        if bench.time_ns() >= self.next_ns {
            self.sample(bench);
            self.next_ns += self.every_ns;
        }
    }

    fn sample(&mut self, bench: &Bench) {
        self.times_ns.push(self.next_ns);
        self.values.extend(self.columns.iter().map(|column| bench.read(column.probe)));
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// When the samples were taken.
    #[must_use]
    pub fn times_ns(&self) -> &[u64] {
        &self.times_ns
    }

    /// A column's values, one a sample.
    pub fn values(&self, column: usize) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().copied().skip(column).step_by(self.columns.len().max(1))
    }

    /// The values of the column called `name`.
    #[must_use]
    pub fn values_of(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.columns.iter().position(|column| column.name == name)?;
        Some(self.values(index).collect())
    }

    /// The header of its CSV form: names and units.
    #[must_use]
    pub fn csv_header(&self) -> String {
        let mut text = "time_s".to_owned();
        for Column { name, unit, .. } in &self.columns {
            let _ = if unit.is_empty() { write!(text, ",{name}") } else { write!(text, ",{name} [{unit}]") };
        }
        text + "\n"
    }

    /// Samples `from` on in CSV form. The same run gives the same bytes on every machine.
    #[must_use]
    pub fn csv_rows(&self, from: usize) -> String {
        let mut text = String::new();
        let rows = self.values.chunks(self.columns.len().max(1));
        for (time_ns, row) in self.times_ns.iter().zip(rows).skip(from) {
            let _ = write!(text, "{}.{:06}", time_ns / 1_000_000_000, time_ns % 1_000_000_000 / 1000);
            for value in row {
                let _ = write!(text, ",{value}");
            }
            text.push('\n');
        }
        text
    }

    /// Forgets all samples but the last `samples`.
    pub fn keep_last(&mut self, samples: usize) {
        let surplus = self.times_ns.len().saturating_sub(samples);
        self.times_ns.drain(..surplus);
        self.values.drain(..surplus * self.columns.len());
    }
}

fn column(bench: &Bench, name: &str) -> Result<Column, ProbeError> {
    let probe = bench.probe(name)?;
    let unit = bench.spec(probe.module).map_or("", |spec| unit(probe.quantity, spec));
    Ok(Column { name: name.to_owned(), unit, probe })
}
