//! `tmcl demo`: a virtual module moves its motor in virtual time, and one sees what happens.
//!
//! It speaks to the module as any host does, in datagrams, and compares what the module reports with what the shaft did.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use tmcl_tables::tmcm_1311::AxisParameter;
use tmcl_tables::{Command, Status};
use tmcl_wire::{Request, serial};
use virtual_bench::config::Setting;
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

/// What pulls at the shaft between the moves on the default bench.
const LOAD_NM: f64 = -0.3;

/// Microsteps in a full step after power-on.
const MICROSTEPS: f64 = 256.0;

/// Full steps in a turn of the usual stepper.
const USUAL_FULL_STEPS: f64 = 200.0;

/// How long a move may take beyond what it should.
const PATIENCE_NS: u64 = 2_000 * MS;

/// Runs it.
pub(crate) fn run(options: &Demo) -> Outcome {
    let standard = module_name::VirtualModule { kind: ModuleKind::Tmcm1311, address: None };
    let module = if options.bench.is_none() { options.module.or(Some(standard)) } else { options.module };
    let config = bench_file::load(module, options.bench.as_deref())?;
    let mut show = Show::new(&config, options)?;
    let started = Instant::now();
    show.play(options)?;
    let elapsed = started.elapsed();
    let title = format!(
        "{} on the virtual bench",
        config.modules.first().map_or("", |module| module.kind.spec().name)
    );
    show.recorder.finish(&options.recording, &title)?;
    let summary = show.summary(elapsed);
    if options.json {
        return Ok(print::json(&summary)?);
    }
    let width = terminal_size::terminal_size().map_or(100, |(terminal_size::Width(width), _)| width.min(140));
    let colour =
        std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
    print::text(&plot::terminal(&show.recorder.figure(&options.recording, &title), width, 50, colour))?;
    print::text("\n")?;
    print::table(["quantity", "value", "unit"], summary.rows().into_iter())?;
    if let Some(path) = &options.recording.plot {
        print::note(&format!("plot written to {}", path.display()));
    }
    if let Some(path) = &options.recording.trace {
        print::note(&format!("trace written to {}", path.display()));
    }
    Ok(())
}

/// A bench, a host at its first port, and a recorder.
struct Show {
    bench: Bench,
    address: u8,
    full_steps: f64,
    recorder: Recorder,
    progress: ProgressBar,
}

impl Show {
    fn new(config: &BenchConfig, options: &Demo) -> Result<Self, Failure> {
        let bench = Bench::new(config);
        let recorder = Recorder::new(&bench, &options.recording, SAMPLE_NS)?;
        let first = config.modules.first();
        let address = first.and_then(|module| module.address).unwrap_or(1);
        let motor = first.and_then(|module| module.motor.stepper());
        // An electrical period is four full steps.
        let full_steps = motor.map_or(USUAL_FULL_STEPS, |motor| motor.pole_pairs * 4.0);
        // Hidden where stderr is no terminal.
        let progress = ProgressBar::new((planned_ns(options) / MS).max(1));
        let style = ProgressStyle::with_template("{bar:40} {pos}/{len} ms of virtual time");
        progress.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Ok(Self { bench, address, full_steps, recorder, progress })
    }

    /// There, a pull at the shaft where the bench has no events of its own, and back.
    fn play(&mut self, options: &Demo) -> Result<(), Failure> {
        let microsteps = self.full_steps * MICROSTEPS;
        let velocity_pps = options.rpm / 60.0 * microsteps;
        self.set(AxisParameter::MotorFullSteps, self.full_steps)?;
        self.set(AxisParameter::MaxVelocity, velocity_pps)?;
        self.set(AxisParameter::MaxAcceleration, velocity_pps / RAMP_S)?;
        self.advance(100 * MS);
        self.move_to(options.turns * microsteps, options)?;
        self.advance(250 * MS);
        if options.bench.is_none() {
            self.bench.apply(ModuleId(0), Setting::LoadTorqueNm(LOAD_NM));
            self.advance(400 * MS);
            self.bench.apply(ModuleId(0), Setting::LoadTorqueNm(0.0));
            self.advance(250 * MS);
        }
        self.move_to(0.0, options)?;
        self.advance(250 * MS);
        self.progress.finish_and_clear();
        Ok(())
    }

    fn set(&mut self, parameter: AxisParameter, value: f64) -> Result<(), Failure> {
        let value = value.round().clamp(1.0, f64::from(i32::MAX)) as i32;
        self.send(Request::new(Command::SetAxisParameter, parameter.number(), 0, value)).map(|_| ())
    }

    /// Starts a move and waits until the module says that it arrived.
    fn move_to(&mut self, position: f64, options: &Demo) -> Result<(), Failure> {
        self.send(Request::new(Command::MoveToPosition, 0, 0, position.round() as i32))?;
        let latest_ns = self.bench.time_ns() + move_ns(options) + PATIENCE_NS;
        let reached = Request::new(Command::GetAxisParameter, AxisParameter::PositionReached.number(), 0, 0);
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

    fn summary(&self, elapsed: Duration) -> Summary {
        let largest = |name: &str| {
            self.recorder.values(name).into_iter().fold(0.0_f64, |most, value| most.max(value.abs()))
        };
        let now = self.bench.physical(ModuleId(0));
        let commanded = self.recorder.commanded_turns(&self.bench);
        let physical = self.recorder.values("physical.rotor_turns");
        let apart = commanded.iter().zip(&physical).map(|(commanded, physical)| (commanded - physical).abs());
        let virtual_s = self.bench.time_ns() as f64 / 1e9;
        let commanded_turns = commanded.last().copied().unwrap_or(0.0);
        Summary {
            virtual_time_s: virtual_s,
            times_real_time: (virtual_s / elapsed.as_secs_f64()).round(),
            commanded_turns,
            physical_turns: now.rotor_turns,
            // Adding zero makes a plain one of a negative one.
            lost_full_steps: ((commanded_turns - now.rotor_turns) * self.full_steps).round() + 0.0,
            largest_deviation_full_steps: apart.fold(0.0, f64::max) * self.full_steps,
            largest_load_angle_deg: largest("physical.load_angle_deg"),
            largest_motor_torque_nm: largest("physical.torque_nm"),
            largest_coil_current_a: largest("physical.coil_a_a").max(largest("physical.coil_b_a")),
            winding_temperature_c: now.winding_temperature_c,
        }
    }
}

fn refusal(request: &Request, status: Status) -> String {
    let Request { command, kind, value, .. } = request;
    format!("the module refused command {command}, type {kind}, value {value}: {status:?}")
}

/// How long a move should take.
fn move_ns(options: &Demo) -> u64 {
    ((options.turns.abs() / (options.rpm / 60.0) + 2.0 * RAMP_S) * 1e9) as u64
}

fn planned_ns(options: &Demo) -> u64 {
    2 * move_ns(options) + 1250 * MS
}

/// What the run came to.
#[derive(Serialize)]
struct Summary {
    virtual_time_s: f64,
    times_real_time: f64,
    commanded_turns: f64,
    physical_turns: f64,
    lost_full_steps: f64,
    largest_deviation_full_steps: f64,
    largest_load_angle_deg: f64,
    largest_motor_torque_nm: f64,
    largest_coil_current_a: f64,
    winding_temperature_c: f64,
}

impl Summary {
    fn rows(&self) -> [[String; 3]; 10] {
        let row = |name: &str, value: f64, digits: usize, unit: &str| {
            [name.to_owned(), format!("{value:.digits$}"), unit.to_owned()]
        };
        [
            row("virtual time", self.virtual_time_s, 2, "s"),
            row("speed", self.times_real_time, 0, "× real time"),
            row("commanded position at the end", self.commanded_turns, 4, "turn"),
            row("physical position at the end", self.physical_turns, 4, "turn"),
            row("full steps lost", self.lost_full_steps, 0, ""),
            row("largest deviation", self.largest_deviation_full_steps, 2, "full steps"),
            row("largest load angle", self.largest_load_angle_deg, 1, "°"),
            row("largest motor torque", self.largest_motor_torque_nm, 3, "Nm"),
            row("largest coil current", self.largest_coil_current_a, 2, "A"),
            row("winding temperature", self.winding_temperature_c, 1, "°C"),
        ]
    }
}
