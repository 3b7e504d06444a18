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
    program: String,
    module: &'static str,
    instructions: usize,
    #[serde(skip)]
    virtual_time_ns: u64,
    virtual_time_s: f64,
    times_real_time: f64,
    ended: Ended,
    /// Whether the program runs on.
    running: bool,
    /// Whether the module says that its motor moves.
    moving: bool,
    /// The instruction that is executed, or would be next.
    address: u16,
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
        checked: &'a Checked,
        monitor: &Monitor,
        ended: Ended,
        elapsed: Duration,
    ) -> Self {
        let assembly = &checked.assembly;
        let vm = bench.program(MODULE);
        let address = vm.map_or(0, virtual_bench::Vm::address);
        let virtual_time_s = seconds(bench.time_ns());
        Self {
            program: assembly
                .sources
                .iter()
                .next()
                .map_or_else(String::new, |(_, source)| source.name.clone()),
            module: assembly.program.module.id,
            instructions: assembly.program.instructions.len(),
            virtual_time_ns: bench.time_ns(),
            virtual_time_s,
            times_real_time: virtual_time_s / elapsed.as_secs_f64().max(1e-9),
            ended,
            running: vm.is_some_and(|vm| vm.mode() == ProgramMode::Run),
            moving: is_moving(bench),
            address,
            at: place(assembly, address),
            held: count(monitor, |outcome| matches!(outcome, Verdict::Held { .. })),
            failed: count(monitor, |outcome| matches!(outcome, Verdict::Failed { .. })),
            undecided: count(monitor, |outcome| matches!(outcome, Verdict::Undecided { .. })),
            expectations: monitor.verdicts().iter().map(expectation).collect(),
            refused: bench.refused_instructions(MODULE).map(|refused| refusal(assembly, refused)).collect(),
            diagnostics: diagnostics::json(checked),
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
        let place = match &self.at {
            Some(at) => format!("{}:{}", at.file, at.line),
            None => format!("address {}", self.address),
        };
        let program = if self.running { "still runs at" } else { "stopped at" };
        let why = match self.ended {
            Ended::Decided => "every expectation is decided; ",
            Ended::ProgramStopped => "",
            Ended::TimeUp => "the time is up; ",
        };
        let motor = if self.moving && !self.running { "; the motor moves on" } else { "" };
        let time = shown_time(self.virtual_time_ns);
        format!("{time} of virtual time on the {}: {why}the program {program} {place}{motor}\n", self.module)
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

fn refusal(assembly: &Assembly, refused: RefusedInstruction) -> RefusalReport {
    let spec = STATUSES.iter().find(|spec| spec.status == refused.status);
    RefusalReport {
        address: refused.address,
        place: place(assembly, refused.address),
        status: refused.status.number(),
        status_name: spec.map_or("", |spec| spec.name),
        count: refused.count,
        first_s: seconds(refused.first_ns),
    }
}

/// By its actual velocity, which every module has.
fn is_moving(bench: &Bench) -> bool {
    let parameters = bench.spec(MODULE).map_or(&[][..], |spec| spec.axis_parameters);
    let velocity = parameters.iter().find(|parameter| parameter.id == "actual_velocity");
    velocity.is_some_and(|velocity| {
        bench.read(Probe { module: MODULE, quantity: Quantity::Parameter(velocity.number) }) != 0.0
    })
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}
