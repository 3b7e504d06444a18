//! `tmcl run`: a program on a virtual module, or a bench by itself, in virtual time, with expectations for CI.
//!
//! It does what a host does: sends commands, assembles, downloads over the wire protocol, starts the program, and looks on.

mod report;

use std::path::Path;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use tmcl_client::{Client, ClientError, Settings};
use tmcl_lang::{Assembly, Severity};
use tmcl_server::State;
use tmcl_tables::{GlobalParameter, ModuleSpec};
use virtual_bench::expect::{Expectation, Monitor, Outcome as Verdict};
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, ProgramMode};

use super::asm::counted;
use crate::arguments::Run;
use crate::connection::told;
use crate::direct::{self, Answer, Prepared};
use crate::exit::{Code, Failure, Outcome};
use crate::program::{Checked, diagnostics, files};
use crate::recording::Recorder;
use crate::virtual_link::{VirtualLink, address};
use crate::{bench_file, module_name, print, state};
use report::{Ended, Report};

const MS: u64 = 1_000_000;

/// Time between samples when nothing is said.
const SAMPLE_NS: u64 = MS;

/// Virtual time between two looks at the progress.
const PROGRESS_NS: u64 = 20 * MS;

/// The module that runs the program: the bench's first.
const MODULE: ModuleId = ModuleId(0);

/// Runs it.
pub(crate) fn run(options: &Run) -> Outcome {
    let config = options.bench.as_deref().map(|file| bench_file::load(None, Some(file))).transpose()?;
    let on_bench = config.as_ref().and_then(|config| config.modules.first()).map(|module| module.kind.spec());
    let checked = options.file.as_deref().map(|file| checked(file, options, on_bench)).transpose()?;
    if let Some(checked) = &checked {
        report_errors(checked, options)?;
    }
    let assembly = checked.as_ref().map(|checked| &checked.assembly);
    let module = match assembly {
        Some(assembly) => assembly.program.module,
        None => alone(options, on_bench)?,
    };
    let config = match config {
        Some(config) => config,
        None => BenchConfig::default_for(virtual_kind(module)?),
    };
    if assembly.is_some() && module.program_memory == 0 {
        let message = format!("a {} has no program memory: it runs no programs; leave FILE out", module.name);
        return Err(Failure::new(Code::Usage, message).into());
    }
    let commands = direct::understood(&direct::lines(&options.exec)?, module)?;
    let mut session = Session::new(&config, module, assembly, options)?;
    let accepted = session.execute(commands).and_then(|()| session.start());
    // A program that was refused halfway is there by half.
    session.save()?;
    accepted?;
    let started = Instant::now();
    let ended = session.play()?;
    let elapsed = started.elapsed();
    session.finish(options)?;
    let report = Report::new(&session.bench, checked.as_ref(), &session.monitor, ended, elapsed);
    if options.json {
        print::json(&report)?;
    } else {
        report.print()?;
    }
    report.code().map_or(Ok(()), |code| Err(code.into()))
}

/// Prints what is wrong with the program; it is not run with an error.
fn report_errors(checked: &Checked, options: &Run) -> Outcome {
    if !options.json {
        diagnostics::print(checked);
    }
    match checked.count(Severity::Error) {
        0 => Ok(()),
        _ if options.json => {
            print::json(&diagnostics::report(std::slice::from_ref(checked)))?;
            Err(Code::Findings.into())
        }
        errors => Err(Failure::new(Code::Findings, format!("not run, {}", counted(errors, "error"))).into()),
    }
}

/// The module whose bench runs without a program.
fn alone(options: &Run, on_bench: Option<&'static ModuleSpec>) -> Result<&'static ModuleSpec, Failure> {
    match (options.module, on_bench) {
        (Some(named), Some(found)) if named.number != found.number => {
            let message = format!("the first module on the bench is a {}, not a {}", found.id, named.id);
            Err(Failure::new(Code::Usage, message))
        }
        (_, Some(module)) | (Some(module), None) => Ok(module),
        (None, None) => {
            Err(Failure::new(Code::Usage, "there is nothing to run: name a program, a --bench or a --module"))
        }
    }
}

/// The program, assembled for the module on the bench, where there is a bench file.
fn checked(file: &Path, options: &Run, on_bench: Option<&'static ModuleSpec>) -> Result<Checked, Failure> {
    let source = files::root(file)?;
    let checked = Checked::of(source.clone(), options.module, &options.lints);
    let Some(found) = on_bench else { return Ok(checked) };
    if !checked.assembly.module_is_named {
        return Ok(Checked::of(source, Some(found), &options.lints));
    }
    let wanted = checked.assembly.program.module;
    if wanted.number != found.number {
        let message = format!(
            "the program is for a {}, but the first module on the bench is a {}",
            wanted.id, found.id
        );
        return Err(Failure::new(Code::Usage, message));
    }
    Ok(checked)
}

fn virtual_kind(module: &'static ModuleSpec) -> Result<ModuleKind, Failure> {
    ModuleKind::try_from(module).map_err(|unknown| {
        Failure::new(Code::Usage, format!("{unknown}; there are {}", module_name::virtual_modules()))
    })
}

/// A bench, the program on it if there is one, and those who look on.
struct Session<'a> {
    bench: Bench,
    state: Option<State>,
    module: &'static ModuleSpec,
    assembly: Option<&'a Assembly>,
    monitor: Monitor,
    /// Whether there are expectations.
    expects: bool,
    looks_on: LooksOn,
    recorder: Option<Recorder>,
    progress: ProgressBar,
    end_ns: u64,
}

impl<'a> Session<'a> {
    fn new(
        config: &BenchConfig,
        module: &'static ModuleSpec,
        assembly: Option<&'a Assembly>,
        options: &Run,
    ) -> Result<Self, Failure> {
        let (bench, state) = state::bench(config, options.state.as_deref())?;
        let expectations = options.expect.iter().map(|text| {
            Expectation::parse(text, &bench)
                .map_err(|error| Failure::new(Code::Usage, format!("in --expect: {}", error.report(text))))
        });
        let expectations = expectations.collect::<Result<Vec<_>, _>>()?;
        let recording = &options.recording;
        let recorder = Recorder::wanted(&bench, recording, SAMPLE_NS)?;
        let looks_on = match (assembly, expectations.is_empty(), &recorder) {
            (None, is_empty, _) => LooksOn::Bench { expects: !is_empty },
            (_, false, _) => LooksOn::Expectations,
            (_, true, Some(_)) => LooksOn::Recorder,
            (_, true, None) => LooksOn::Nobody,
        };
        let expects = !expectations.is_empty();
        let monitor = Monitor::new(expectations, &bench);
        // Hidden where stderr is no terminal.
        let progress = ProgressBar::new((options.duration / MS).max(1));
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len} ms of virtual time  {wide_msg}");
        progress.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let end_ns = options.duration;
        Ok(Self { bench, state, module, assembly, monitor, expects, looks_on, recorder, progress, end_ns })
    }

    /// Sends what shall be set before anything runs.
    fn execute(&mut self, commands: Vec<Prepared>) -> Result<(), Failure> {
        let module = self.module;
        for Prepared { request, doubts } in commands {
            // A new address counts from the next request on (TMCM-1311 §10.1).
            let mut client = self.client();
            let answer = direct::ask(&mut client, request).map_err(|error| told(&client, &error))?;
            if let Answer::Refused(status) = answer {
                let message = direct::refusal(&client, request, status, module) + &direct::reason(&doubts);
                return Err(Failure::new(Code::TmclStatus, message));
            }
        }
        Ok(())
    }

    /// A host at the first port of the module.
    fn client(&mut self) -> Client<VirtualLink<&mut Bench>> {
        let settings = Settings {
            module_address: address(&self.bench, MODULE, GlobalParameter::SerialAddress),
            host_address: address(&self.bench, MODULE, GlobalParameter::HostAddress),
            ..Settings::default()
        };
        Client::with_settings(VirtualLink::new(&mut self.bench, MODULE), settings)
    }

    /// 132, the instructions, 133, 131, 129.
    fn start(&mut self) -> Result<(), Failure> {
        let Some(assembly) = self.assembly else { return Ok(()) };
        let mut client = self.client();
        let program: Vec<_> =
            assembly.program.instructions.iter().map(|instruction| instruction.to_bytes()).collect();
        let refused = |error: ClientError| Failure::new(Code::TmclStatus, error.to_string());
        client.download(&program, &mut |_| {}).map_err(refused)?;
        client.reset_program().map_err(refused)?;
        client.run(None).map_err(refused)
    }

    /// What the modules stored until now is in their files.
    fn save(&mut self) -> Result<(), Failure> {
        let Self { bench, state, .. } = self;
        state.as_mut().map_or(Ok(()), |state| state.save(bench)).map_err(state::failure)
    }

    /// Lets virtual time pass until there is nothing more to see.
    fn play(&mut self) -> Result<Ended, Failure> {
        loop {
            self.save()?;
            if let Some(recorder) = &mut self.recorder {
                recorder.sample_if_due(&self.bench);
            }
            if let Some(ended) = self.ended() {
                return Ok(ended);
            }
            self.show_progress();
            let next_ns = self.next_look_ns();
            let Self { bench, monitor, looks_on, .. } = self;
            bench.advance_observed(next_ns, &mut |bench| {
                monitor.observe(bench);
                // What was seen may have brought a nearer deadline, and what ends the run ends it at that instant.
                monitor.next_deadline_ns() >= next_ns && !is_over(bench, monitor, *looks_on)
            });
        }
    }

    fn ended(&self) -> Option<Ended> {
        if self.expects && self.monitor.is_decided() {
            Some(Ended::Decided)
        } else if is_over(&self.bench, &self.monitor, self.looks_on) {
            Some(Ended::ProgramStopped)
        } else if self.bench.time_ns() >= self.end_ns {
            Some(Ended::TimeUp)
        } else {
            None
        }
    }

    fn next_look_ns(&self) -> u64 {
        let sample_ns = self.recorder.as_ref().map_or(u64::MAX, Recorder::next_sample_ns);
        let progress_ns = (self.bench.time_ns() / PROGRESS_NS + 1) * PROGRESS_NS;
        let soonest_ns = sample_ns.min(progress_ns).min(self.monitor.next_deadline_ns()).min(self.end_ns);
        // A time that is no multiple of a control period is looked at after it.
        soonest_ns.next_multiple_of(virtual_bench::TICK_NS)
    }

    fn show_progress(&self) {
        self.progress.set_position(self.bench.time_ns() / MS);
        if !self.progress.is_hidden()
            && let Some(assembly) = self.assembly
            && let Some(place) =
                self.bench.program(MODULE).and_then(|vm| report::place(assembly, vm.address()))
        {
            self.progress.set_message(format!("{}:{}  {}", place.file, place.line, place.text));
        }
    }

    fn finish(&mut self, options: &Run) -> Result<(), Failure> {
        self.progress.finish_and_clear();
        self.monitor.finish(&self.bench);
        self.save()?;
        let Some(recorder) = &mut self.recorder else { return Ok(()) };
        let module = self.module.name;
        let title = match &options.file {
            Some(file) => format!("{} on the {module}", file.display()),
            None => format!("{module} on the virtual bench"),
        };
        recorder.finish(&options.recording, &title)?;
        for (what, path) in [("plot", &options.recording.plot), ("trace", &options.recording.trace)] {
            if let Some(path) = path {
                print::note(&format!("{what} written to {}", path.display()));
            }
        }
        Ok(())
    }
}

/// Whether there is nothing more to see: every expectation is decided, or the program has stopped, nothing that was expected
/// can still come true, and all stands still, so that what shall never or always be has been seen to the end.
fn is_over(bench: &Bench, monitor: &Monitor, looks_on: LooksOn) -> bool {
    let running = bench.program(MODULE).is_some_and(|vm| vm.mode() == ProgramMode::Run);
    match looks_on {
        LooksOn::Nobody => !running,
        LooksOn::Bench { expects } => expects && monitor.is_decided(),
        LooksOn::Expectations if monitor.is_decided() => true,
        LooksOn::Expectations | LooksOn::Recorder => {
            !running && bench.is_at_rest() && !monitor.awaits_something()
        }
    }
}

/// Who wants to see more than the end of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LooksOn {
    /// There is no program whose end could be seen.
    Bench { expects: bool },
    /// There is neither trace, plot nor expectation.
    Nobody,
    /// A trace or plot, and no expectation.
    Recorder,
    /// Expectations.
    Expectations,
}

/// How many of the verdicts are of some kind.
fn count(monitor: &Monitor, is_kind: impl Fn(&Verdict) -> bool) -> usize {
    monitor.verdicts().iter().filter(|verdict| is_kind(&verdict.outcome)).count()
}
