//! `tmcl demo`: a virtual module moves its motor in virtual time, and one sees what happens.
//!
//! It speaks to the module as any host does, in datagrams, and compares what the module reports with what the shaft did.

mod brushless;
mod stepper;

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use tmcl_tables::{Command, Status};
use tmcl_wire::{Request, serial};
use virtual_bench::config::{ModuleConfig, Setting};
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId};

use crate::arguments::Demo;
use crate::exit::{Code, Failure, Outcome};
use crate::recording::Recorder;
use crate::{bench_file, module_name, plot, print};

const MS: u64 = 1_000_000;

/// Time between samples when nothing is said: fine enough for the coil currents of a fast motor.
const SAMPLE_NS: u64 = MS / 2;

/// How long the ramps take.
const RAMP_S: f64 = 0.25;

/// How long a move may take beyond what it should.
const PATIENCE_NS: u64 = 2_000 * MS;

/// The number of AP 8, which every module has.
const POSITION_REACHED: u8 = 8;

/// Runs it.
pub(crate) fn run(options: &Demo) -> Outcome {
    let standard = module_name::VirtualModule { kind: ModuleKind::Tmcm1311, address: None };
    let module = if options.bench.is_none() { options.module.or(Some(standard)) } else { options.module };
    let config = bench_file::load(module, options.bench.as_deref())?;
    let Some(first) = config.modules.first() else {
        return Err(Failure::new(Code::Usage, "there is no module on the bench").into());
    };
    match first.kind {
        ModuleKind::Tmcm1311 => stepper::run(&config, first, options),
        ModuleKind::Tmcm1640 => brushless::run(&config, first, options),
        ModuleKind::Tmcm1076 => {
            let message = "a TMCM-1076 has no motion commands to demonstrate: it follows pulses; \
                           `tmcl run --bench FILE` with a [module.step_dir] moves it";
            Err(Failure::new(Code::Usage, message).into())
        }
    }
}

/// What the motor shall do: so far, and back.
#[derive(Clone, Copy, Debug)]
struct Journey {
    turns: f64,
    rpm: f64,
    /// What pulls at the shaft between the moves on the default bench.
    load_nm: f64,
}

impl Journey {
    /// How long a move should take.
    fn move_ns(self) -> u64 {
        ((self.turns.abs() / (self.rpm / 60.0) + 2.0 * RAMP_S) * 1e9) as u64
    }

    fn planned_ns(self) -> u64 {
        2 * self.move_ns() + 1250 * MS
    }
}

/// A bench, a host at its first port, and a recorder.
struct Show {
    bench: Bench,
    address: u8,
    journey: Journey,
    recorder: Recorder,
    progress: ProgressBar,
}

impl Show {
    fn new(config: &BenchConfig, options: &Demo, journey: Journey) -> Result<Self, Failure> {
        let bench = Bench::new(config);
        let recorder = Recorder::new(&bench, &options.recording, SAMPLE_NS)?;
        let address = config.modules.first().and_then(|module| module.address).unwrap_or(1);
        // Hidden where stderr is no terminal.
        let progress = ProgressBar::new((journey.planned_ns() / MS).max(1));
        let style = ProgressStyle::with_template("{bar:40} {pos}/{len} ms of virtual time");
        progress.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Ok(Self { bench, address, journey, recorder, progress })
    }

    /// There, a pull at the shaft where the bench has no events of its own, and back. The time in which the shaft was to stand
    /// still between the moves.
    fn go_and_return(&mut self, steps_of_a_turn: f64, options: &Demo) -> Result<[u64; 2], Failure> {
        self.move_to(self.journey.turns * steps_of_a_turn)?;
        let arrived_ns = self.bench.time_ns();
        self.advance(250 * MS);
        if options.bench.is_none() {
            self.bench.apply(ModuleId(0), Setting::LoadTorqueNm(self.journey.load_nm));
            self.advance(400 * MS);
            self.bench.apply(ModuleId(0), Setting::LoadTorqueNm(0.0));
            self.advance(250 * MS);
        }
        let left_ns = self.bench.time_ns();
        self.move_to(0.0)?;
        self.advance(250 * MS);
        self.progress.finish_and_clear();
        Ok([arrived_ns, left_ns])
    }

    /// Sets an axis parameter to the nearest whole number, 1 at least.
    fn set(&mut self, parameter: u8, value: f64) -> Result<(), Failure> {
        let value = value.round().clamp(1.0, f64::from(i32::MAX)) as i32;
        self.send(Request::new(Command::SetAxisParameter, parameter, 0, value)).map(|_| ())
    }

    /// Starts a move and waits until the module says that it arrived.
    fn move_to(&mut self, position: f64) -> Result<(), Failure> {
        self.send(Request::new(Command::MoveToPosition, 0, 0, position.round() as i32))?;
        let latest_ns = self.bench.time_ns() + self.journey.move_ns() + PATIENCE_NS;
        let reached = Request::new(Command::GetAxisParameter, POSITION_REACHED, 0, 0);
        while self.send(reached)? == 0 && self.bench.time_ns() < latest_ns {
            self.advance(MS);
        }
        Ok(())
    }

    /// One datagram there, one back.
    fn send(&mut self, request: Request) -> Result<i32, Failure> {
        let [port, ..] = PortId::ALL;
        let datagram = serial::encode_request(self.address, request);
        let answer = self.bench.exchange(ModuleId(0), port, &datagram);
        let failure = |text: String| Failure::new(Code::TmclStatus, text);
        let answer: [u8; 9] = answer
            .try_into()
            .map_err(|_| failure("the module does not answer; is its power off?".to_owned()))?;
        match serial::decode_reply(answer) {
            Ok((_, _, reply)) if reply.status == Status::Ok => Ok(reply.value),
            Ok((_, _, reply)) => Err(failure(refusal(&request, reply.status))),
            Err(error) => Err(failure(error.to_string())),
        }
    }

    fn advance(&mut self, duration_ns: u64) {
        let until_ns = self.bench.time_ns() + duration_ns;
        self.recorder.advance_to(&mut self.bench, until_ns);
        self.progress.set_position(self.bench.time_ns() / MS);
    }

    /// The largest amount that a recorded column came to.
    fn largest(&self, name: &str) -> f64 {
        self.recorder.values(name).into_iter().fold(0.0_f64, |most, value| most.max(value.abs()))
    }

    fn virtual_s(&self) -> f64 {
        self.bench.time_ns() as f64 / 1e9
    }

    fn times_real_time(&self, elapsed: Duration) -> f64 {
        (self.virtual_s() / elapsed.as_secs_f64()).round()
    }
}

fn refusal(request: &Request, status: Status) -> String {
    let Request { command, kind, value, .. } = request;
    format!("the module refused command {command}, type {kind}, value {value}: {status:?}")
}

/// A line of the summary.
fn row(name: &str, value: f64, digits: usize, unit: &str) -> [String; 3] {
    [name.to_owned(), format!("{value:.digits$}"), unit.to_owned()]
}

/// Plays, writes down what was recorded, and tells what it came to.
fn tell<S: Serialize>(
    module: &ModuleConfig,
    options: &Demo,
    mut show: Show,
    play: impl FnOnce(&mut Show) -> Result<[u64; 2], Failure>,
    summary: impl FnOnce(&Show, [u64; 2], Duration) -> S,
    rows: impl FnOnce(&S) -> Vec<[String; 3]>,
) -> Outcome {
    let started = Instant::now();
    let held = play(&mut show)?;
    let summary = summary(&show, held, started.elapsed());
    let title = format!("{} on the virtual bench", module.kind.spec().name);
    show.recorder.finish(&options.recording, &title)?;
    if options.json {
        return Ok(print::json(&summary)?);
    }
    let width = terminal_size::terminal_size().map_or(100, |(terminal_size::Width(width), _)| width.min(140));
    let colour =
        std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
    print::text(&plot::terminal(&show.recorder.figure(&options.recording, &title), width, 50, colour))?;
    print::text("\n")?;
    print::table(["quantity", "value", "unit"], rows(&summary).into_iter())?;
    for (what, path) in [("plot", &options.recording.plot), ("trace", &options.recording.trace)] {
        if let Some(path) = path {
            print::note(&format!("{what} written to {}", path.display()));
        }
    }
    Ok(())
}
