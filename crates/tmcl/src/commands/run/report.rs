//! What came of a run: the expectations, what the module refused, and where the program ended.

use std::io;
use std::time::Duration;

use serde::Serialize;
use tmcl_lang::Assembly;
use tmcl_tables::STATUSES;
use virtual_bench::expect::{Monitor, Outcome as Verdict, shown_time};
use virtual_bench::{Bench, Probe, ProgramMode, Quantity, RefusedInstruction};

use super::{MODULE, count};
use crate::exit::Code;
use crate::print;
use crate::program::diagnostics::DiagnosticJson;
use crate::program::{Checked, diagnostics};

/// The time between microsteps that a TMCM-1076 reads at standstill.
const STANDSTILL_TSTEP: f64 = 1_048_575.0;

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Ended {
    /// Every expectation is decided.
    Decided,
    /// The program stopped, and nothing was left to wait for.
    ProgramStopped,
    /// The time is up.
    TimeUp,
}

/// An instruction's place in the text.
#[derive(Serialize)]
pub(super) struct Place {
    pub(super) file: String,
    pub(super) line: u32,
    pub(super) text: String,
}

#[derive(Serialize)]
struct ExpectationReport {
    text: String,
    outcome: &'static str,
    at_s: Option<f64>,
    reason: String,
    /// The outcome for people.
    #[serde(skip)]
    shown: String,
}

#[derive(Serialize)]
struct RefusalReport {
    address: u16,
    #[serde(flatten)]
    place: Option<Place>,
    status: u8,
    status_name: &'static str,
    count: u64,
    first_s: f64,
}

/// The report of a run; its fields are the JSON's.
#[derive(Serialize)]
pub(super) struct Report<'a> {
    /// None where the bench ran by itself.
    program: Option<String>,
    module: &'static str,
    instructions: Option<usize>,
    #[serde(skip)]
    virtual_time_ns: u64,
    virtual_time_s: f64,
    times_real_time: f64,
    ended: Ended,
    /// Whether the program runs on.
    running: bool,
    /// Whether the module says that its motor moves.
    moving: bool,
    /// The instruction that is executed, or would be next; none without a program.
    address: Option<u16>,
    at: Option<Place>,
    held: usize,
    failed: usize,
    undecided: usize,
    expectations: Vec<ExpectationReport>,
    refused: Vec<RefusalReport>,
    /// The warnings of the program.
    diagnostics: Vec<DiagnosticJson<'a>>,
}

impl<'a> Report<'a> {
    pub(super) fn new(
        bench: &Bench,
        checked: Option<&'a Checked>,
        monitor: &Monitor,
        ended: Ended,
        elapsed: Duration,
    ) -> Self {
        let assembly = checked.map(|checked| &checked.assembly);
        let vm = bench.program(MODULE);
        let running = vm.is_some_and(|vm| vm.mode() == ProgramMode::Run);
        let address = vm.filter(|_| running || checked.is_some()).map(virtual_bench::Vm::address);
        let virtual_time_s = seconds(bench.time_ns());
        Self {
            program: assembly
                .and_then(|assembly| assembly.sources.iter().next())
                .map(|(_, source)| source.name.clone()),
            module: bench.spec(MODULE).map_or("", |spec| spec.id),
            instructions: assembly.map(|assembly| assembly.program.instructions.len()),
            virtual_time_ns: bench.time_ns(),
            virtual_time_s,
            times_real_time: virtual_time_s / elapsed.as_secs_f64().max(1e-9),
            ended,
            running,
            moving: is_moving(bench),
            address,
            at: assembly.zip(address).and_then(|(assembly, address)| place(assembly, address)),
            held: count(monitor, |outcome| matches!(outcome, Verdict::Held { .. })),
            failed: count(monitor, |outcome| matches!(outcome, Verdict::Failed { .. })),
            undecided: count(monitor, |outcome| matches!(outcome, Verdict::Undecided { .. })),
            expectations: monitor.verdicts().iter().map(expectation).collect(),
            refused: bench.refused_instructions(MODULE).map(|refused| refusal(assembly, refused)).collect(),
            diagnostics: checked.map(diagnostics::json).unwrap_or_default(),
        }
    }

    /// How the process ends: a failed expectation or a refused instruction is a finding; what is undecided when the time is
    /// up is a timeout.
    pub(super) fn code(&self) -> Option<Code> {
        if self.failed > 0 || !self.refused.is_empty() {
            Some(Code::Findings)
        } else if self.undecided > 0 {
            Some(Code::Timeout)
        } else {
            None
        }
    }

    /// For people: the report is data, so it goes to stdout.
    pub(super) fn print(&self) -> io::Result<()> {
        if !self.expectations.is_empty() {
            print::table(
                ["", "expectation", "outcome"],
                self.expectations.iter().map(ExpectationReport::row),
            )?;
            print::text("\n")?;
        }
        if !self.refused.is_empty() {
            print::text("Refused by the module and skipped:\n")?;
            print::table(
                ["times", "line", "instruction", "status"],
                self.refused.iter().map(RefusalReport::row),
            )?;
            print::text("\n")?;
        }
        print::text(&self.summary())
    }

    fn summary(&self) -> String {
        let why = match self.ended {
            Ended::Decided => Some("every expectation is decided".to_owned()),
            Ended::ProgramStopped => None,
            Ended::TimeUp => Some("the time is up".to_owned()),
        };
        let motor = (self.moving && !self.running).then(|| "the motor moves on".to_owned());
        let said: Vec<String> = why.into_iter().chain(self.program_ended()).chain(motor).collect();
        let time = shown_time(self.virtual_time_ns);
        format!("{time} of virtual time on the {}: {}\n", self.module, said.join("; "))
    }

    /// Where the program is; without one, where one runs that the module had stored.
    fn program_ended(&self) -> Option<String> {
        if self.program.is_none() && !self.running {
            return None;
        }
        let place = match &self.at {
            Some(at) => format!("{}:{}", at.file, at.line),
            None => format!("address {}", self.address?),
        };
        let program = if self.running { "still runs at" } else { "stopped at" };
        Some(format!("the program {program} {place}"))
    }
}

impl ExpectationReport {
    fn row(&self) -> [String; 3] {
        let sign = match self.outcome {
            "held" => "ok",
            "failed" => "FAILED",
            _ => "?",
        };
        [sign.to_owned(), self.text.clone(), self.shown.clone()]
    }
}

impl RefusalReport {
    fn row(&self) -> [String; 4] {
        let (line, text) = match &self.place {
            Some(place) => (format!("{}:{}", place.file, place.line), place.text.clone()),
            None => (format!("address {}", self.address), String::new()),
        };
        [self.count.to_string(), line, text, format!("{} {}", self.status, self.status_name)]
    }
}

/// Where the instruction at an address was written.
pub(super) fn place(assembly: &Assembly, address: u16) -> Option<Place> {
    let origin = assembly.program.origin(address)?;
    let text = String::from_utf8_lossy(assembly.sources.bytes(origin));
    // The STOP that the assembler appended was not written anywhere.
    let text = if text.is_empty() { "STOP".into() } else { text };
    Some(Place {
        file: assembly.sources.name(origin).to_owned(),
        line: assembly.sources.position(origin).line,
        text: text.into_owned(),
    })
}

fn expectation(verdict: &virtual_bench::expect::Verdict) -> ExpectationReport {
    let (outcome, at_ns, reason) = match &verdict.outcome {
        Verdict::Held { at_ns } => ("held", Some(*at_ns), String::new()),
        Verdict::Failed { at_ns, reason } => ("failed", Some(*at_ns), reason.clone()),
        Verdict::Undecided { reason } => ("undecided", None, reason.clone()),
    };
    ExpectationReport {
        text: verdict.text.clone(),
        outcome,
        at_s: at_ns.map(seconds),
        reason,
        shown: verdict.outcome.to_string(),
    }
}

fn refusal(assembly: Option<&Assembly>, refused: RefusedInstruction) -> RefusalReport {
    let spec = STATUSES.iter().find(|spec| spec.status == refused.status);
    RefusalReport {
        address: refused.address,
        place: assembly.and_then(|assembly| place(assembly, refused.address)),
        status: refused.status.number(),
        status_name: spec.map_or("", |spec| spec.name),
        count: refused.count,
        first_s: seconds(refused.first_ns),
    }
}

/// By its actual velocity; where pulses move it, by the time between microsteps.
fn is_moving(bench: &Bench) -> bool {
    let value = |id: &str| {
        let parameter = bench.spec(MODULE)?.axis_parameters.iter().find(|parameter| parameter.id == id)?;
        Some(bench.read(Probe { module: MODULE, quantity: Quantity::Parameter(parameter.number) }))
    };
    match value("actual_velocity") {
        Some(velocity) => velocity != 0.0,
        None => value("tstep").is_some_and(|clocks| clocks < STANDSTILL_TSTEP),
    }
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}
