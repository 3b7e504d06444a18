//! `tmcl start`, `stop`, `step`, `reset` and `status`: the stored program of a module.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use tmcl_client::{ClientError, ProgramStatus};
use tmcl_tables::{MODULES, ModuleSpec, Status};

use crate::connection::{AnyClient, ConnectionOptions, told, told_with};
use crate::direct::addresses;
use crate::exit::{Code, Failure, Outcome};
use crate::print;
use crate::program::symbols::SymbolFile;

/// `tmcl start`.
#[derive(Args)]
#[command(
    after_help = "Without an address it goes on where its program counter stands: at the start after `tmcl reset`."
)]
pub(crate) struct Start {
    /// The address to start at
    #[arg(id = "start", value_name = "ADDRESS", value_parser = address)]
    address: Option<u32>,
    #[command(flatten)]
    options: Options,
}

/// `tmcl stop`, `step`, `reset` and `status`.
#[derive(Args)]
pub(crate) struct Options {
    /// The symbol file of the program (`tmcl asm --symbols`): names the line that comes next
    #[arg(long, value_name = "FILE")]
    symbols: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: ConnectionOptions,
}

/// What a module has room for is for the module to say; what none has is refused here.
fn address(text: &str) -> Result<u32, String> {
    let largest = MODULES.iter().map(|module| module.program_memory).max().unwrap_or(0);
    let fits = text.parse().ok().filter(|address| *address <= u32::from(u16::MAX));
    fits.ok_or_else(|| {
        format!(
            "an address in the program memory is expected, a number from 0 to {}",
            largest.saturating_sub(1)
        )
    })
}

/// Starts it.
pub(crate) fn start(options: &Start) -> Outcome {
    command(&options.options, |client| client.run(options.address))
}

/// Stops it.
pub(crate) fn stop(options: &Options) -> Outcome {
    command(options, AnyClient::stop_program)
}

/// Executes one instruction.
pub(crate) fn step(options: &Options) -> Outcome {
    command(options, AnyClient::step_program)
}

/// Sets it back.
pub(crate) fn reset(options: &Options) -> Outcome {
    command(options, AnyClient::reset_program)
}

/// Asks only.
pub(crate) fn status(options: &Options) -> Outcome {
    command(options, |_| Ok(()))
}

/// Sends something and prints what the program does then.
fn command(options: &Options, send: impl Fn(&mut AnyClient) -> Result<(), ClientError>) -> Outcome {
    let symbols = options.symbols.as_deref().map(SymbolFile::read).transpose()?;
    let (mut client, module) = options.connection.connect()?;
    needs_program_memory(module)?;
    send(&mut client).map_err(|error| told_with(&client, &error, &advice(&error, module)))?;
    let status = client.program_status().map_err(|error| told(&client, &error))?;
    let state = State::of(status, symbols.as_ref());
    if options.json {
        return Ok(print::json(&state)?);
    }
    Ok(print::text(&format!("{}\n", state.text()))?)
}

/// The only value that these commands carry is an address.
fn advice(error: &ClientError, module: &ModuleSpec) -> String {
    match error {
        ClientError::Status { status: Status::InvalidValue, .. } => format!("; {}", addresses(module)),
        _ => String::new(),
    }
}

/// A module that executes what a host sends, and nothing else.
pub(crate) fn needs_program_memory(module: &ModuleSpec) -> Result<(), Failure> {
    if module.program_memory > 0 {
        return Ok(());
    }
    let with = MODULES.iter().filter(|module| module.program_memory > 0).map(|module| module.name);
    let message = format!(
        "the {} has no program memory: it executes what a host sends, and nothing else; stand-alone programs run on the {}",
        module.name,
        with.collect::<Vec<_>>().join(" and the ")
    );
    Err(Failure::new(Code::TmclStatus, message))
}

/// What the program does.
#[derive(Serialize)]
struct State {
    mode: String,
    /// The address of the next instruction.
    address: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    label: Option<String>,
}

impl State {
    fn of(status: ProgramStatus, symbols: Option<&SymbolFile>) -> Self {
        let address = status.address;
        let place = symbols.and_then(|symbols| symbols.place(address));
        let label = symbols.and_then(|symbols| symbols.label(address));
        let (file, line) = place.unzip();
        Self { mode: status.mode.to_string(), address, file, line, label }
    }

    /// `stopped at 5, blink.tmc:12 (Loop + 2)`.
    fn text(&self) -> String {
        let place = match (&self.file, self.line) {
            (Some(file), Some(line)) => format!(", {file}:{line}"),
            _ => String::new(),
        };
        let label = self.label.as_ref().map_or_else(String::new, |label| format!(" ({label})"));
        format!("{} at {}{place}{label}", self.mode, self.address)
    }
}
