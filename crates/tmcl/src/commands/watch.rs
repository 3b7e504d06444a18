//! `tmcl watch`: parameters as they change.

use std::collections::VecDeque;
use std::io::{self, IsTerminal, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use serde::Serialize;
use tmcl_config::{Name, described};
use tmcl_link::Link as _;

use crate::arguments::{duration, interval};
use crate::connection::{AnyClient, ConnectionOptions, failure};
use crate::exit::{Code, Failure, Outcome};
use crate::parameters::{self, unit};
use crate::print;

/// How many values the curve in the last column shows.
const HISTORY: usize = 40;

/// How long a Ctrl-C may have to wait for us.
const SLICE: Duration = Duration::from_millis(100);

/// `tmcl watch`.
#[derive(Args)]
#[command(
    after_help = "A table that is drawn anew on a terminal, CSV with a line a sample everywhere else, with --json an object a line. Ctrl-C ends it. A module \
    in this process (virtual:…) lives only while it is watched: its time runs with the samples."
)]
pub(crate) struct Watch {
    /// What to read, such as actual_position or 'ain.*'
    #[arg(required = true, value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Time between samples: 20ms, 1s
    #[arg(long, value_name = "TIME", default_value = "100ms", value_parser = interval)]
    pub(crate) every: u64,
    /// Print CSV on a terminal too
    #[arg(long, conflicts_with = "json")]
    pub(crate) csv: bool,
    /// Print JSON, an object a line
    #[arg(long)]
    pub(crate) json: bool,
    /// End after this time: 500ms, 10s, 1h
    #[arg(long = "for", value_name = "TIME", value_parser = duration)]
    pub(crate) duration: Option<u64>,
    /// End after so many samples
    #[arg(long, value_name = "N", value_parser = samples)]
    pub(crate) count: Option<u64>,
    #[command(flatten)]
    pub(crate) connection: ConnectionOptions,
}

fn samples(text: &str) -> Result<u64, String> {
    text.parse()
        .ok()
        .filter(|count| *count > 0)
        .ok_or_else(|| "a number of samples is expected, from 1 on".to_owned())
}

/// Samples until time, count or the user says that it is enough.
pub(crate) fn run(options: &Watch) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    let names = parameters::named(&options.names, module, |item| item.access().read, "can only be written")?;
    let closed_loop = parameters::closed_loop(&mut client, module, names.iter().map(|name| name.item))?;
    let enough = interruption()?;
    let mut view = View::new(&names, closed_loop, options);
    let mut grid = Grid::new(Duration::from_nanos(options.every), client.link_mut().has_own_time());
    let end = options.duration.map(Duration::from_nanos);
    view.begin()?;
    for sample in 1_u64.. {
        match sample_all(&mut client, &names) {
            Ok(values) => view.show(grid.time(), &values)?,
            // Who presses Ctrl-C may have unplugged the cable before.
            Err(_) if enough.load(Ordering::Relaxed) => break,
            Err(failure) => return Err(failure.into()),
        }
        if options.count == Some(sample) || end.is_some_and(|end| grid.next_time() > end) {
            break;
        }
        grid.wait(&mut client, view.is_live(), &enough)?;
        if enough.load(Ordering::Relaxed) {
            break;
        }
    }
    Ok(())
}

/// Set once the user has seen enough.
fn interruption() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let theirs = Arc::clone(&flag);
    ctrlc::set_handler(move || theirs.store(true, Ordering::Relaxed))
        .map_err(|error| Failure::new(Code::Usage, format!("cannot listen for Ctrl-C: {error}")))?;
    Ok(flag)
}

fn sample_all(client: &mut AnyClient, names: &[Name]) -> Result<Vec<i64>, Failure> {
    let value = |name: &Name| {
        let whole = parameters::read(client, name.item).map_err(|error| failure(&error))?;
        Ok(name.extract(whole))
    };
    names.iter().map(value).collect()
}

/// When samples are taken: at multiples of an interval from the first one on, however long the reading takes.
struct Grid {
    every: Duration,
    /// Whether the link has a time of its own, in which reading takes none.
    own_time: bool,
    start: Instant,
    slot: u32,
}

impl Grid {
    fn new(every: Duration, own_time: bool) -> Self {
        Self { every, own_time, start: Instant::now(), slot: 0 }
    }

    /// The time of the present sample.
    fn time(&self) -> Duration {
        if self.own_time { self.every.saturating_mul(self.slot) } else { self.start.elapsed() }
    }

    /// The place on the grid of the next sample; where reading takes longer than the interval, places are left out.
    fn next_slot(&self) -> u32 {
        let passed = self.time().as_nanos() / self.every.as_nanos().max(1);
        u32::try_from(passed).unwrap_or(u32::MAX).max(self.slot).saturating_add(1)
    }

    fn next_time(&self) -> Duration {
        self.every.saturating_mul(self.next_slot())
    }

    /// Waits for the next sample. Somebody who looks on wants to see a simulation at a pace.
    fn wait(&mut self, client: &mut AnyClient, is_live: bool, enough: &AtomicBool) -> Result<(), Failure> {
        let (slot, until) = (self.next_slot(), self.next_time());
        let pause = |client: &mut AnyClient, duration| {
            client
                .link_mut()
                .wait(duration)
                .map_err(|error| Failure::new(Code::Connection, error.to_string()))
        };
        if self.own_time {
            pause(client, self.every)?;
        }
        let at_a_pace = is_live || !self.own_time;
        while at_a_pace && !enough.load(Ordering::Relaxed) {
            let left = until.saturating_sub(self.start.elapsed());
            if left.is_zero() {
                break;
            }
            if self.own_time { std::thread::sleep(left.min(SLICE)) } else { pause(client, left.min(SLICE))? }
        }
        self.slot = slot;
        Ok(())
    }
}

/// A sample, as JSON has it.
#[derive(Serialize)]
struct Sample {
    time_s: f64,
    values: serde_json::Map<String, serde_json::Value>,
}

/// What is made of the samples.
enum View<'n> {
    Csv(&'n [Name]),
    Json(&'n [Name]),
    Live { names: &'n [Name], closed_loop: bool, history: Vec<VecDeque<i64>>, lines: usize },
}

impl<'n> View<'n> {
    fn new(names: &'n [Name], closed_loop: bool, options: &Watch) -> Self {
        if options.json {
            Self::Json(names)
        } else if options.csv || !io::stdout().is_terminal() {
            Self::Csv(names)
        } else {
            Self::Live { names, closed_loop, history: vec![VecDeque::new(); names.len()], lines: 0 }
        }
    }

    fn is_live(&self) -> bool {
        matches!(self, Self::Live { .. })
    }

    fn begin(&self) -> io::Result<()> {
        match self {
            Self::Csv(names) => {
                let names: String = names.iter().map(|name| format!(",{name}")).collect();
                print::text(&format!("time_s{names}\n"))
            }
            Self::Json(_) | Self::Live { .. } => Ok(()),
        }
    }

    fn show(&mut self, time: Duration, values: &[i64]) -> io::Result<()> {
        let seconds = format!("{}.{:06}", time.as_secs(), time.subsec_micros());
        match self {
            Self::Csv(_) => {
                let values: String = values.iter().map(|value| format!(",{value}")).collect();
                print::text(&format!("{seconds}{values}\n"))
            }
            Self::Json(names) => {
                let values =
                    names.iter().zip(values).map(|(name, value)| (name.to_string(), (*value).into()));
                print::json_line(&Sample { time_s: time.as_micros() as f64 / 1e6, values: values.collect() })
            }
            Self::Live { names, closed_loop, history, lines } => {
                for (past, value) in history.iter_mut().zip(values) {
                    past.push_back(*value);
                    if past.len() > HISTORY {
                        past.pop_front();
                    }
                }
                let rows = names.iter().zip(values).zip(&*history).map(|((name, value), past)| {
                    let (unit, curve) = (unit(name, *closed_loop), parameters::spark(past.iter().copied()));
                    [name.to_string(), value.to_string(), unit.to_owned(), described(name, *value), curve]
                });
                let table = print::columns(["name", "value", "unit", "meaning", ""], Some(1), rows);
                let frame = format!("{}{:.3} s, Ctrl-C ends\n", table, time.as_secs_f64());
                draw(&frame, lines)
            }
        }
    }
}

/// Draws a frame over the last one, which had so many lines. What does not fit the terminal is cut off.
fn draw(frame: &str, lines: &mut usize) -> io::Result<()> {
    let (width, height) = terminal_size::terminal_size_of(io::stdout())
        .map_or((80, 24), |(width, height)| (usize::from(width.0), usize::from(height.0)));
    let mut out = io::stdout().lock();
    if *lines > 0 {
        write!(out, "\x1b[{lines}F\x1b[J")?;
    }
    *lines = 0;
    let fitting = height.saturating_sub(1).max(1);
    let skipped = frame.lines().count().saturating_sub(fitting);
    for line in frame.lines().skip(skipped) {
        writeln!(out, "{}", line.chars().take(width.saturating_sub(1)).collect::<String>())?;
        *lines += 1;
    }
    out.flush()
}
