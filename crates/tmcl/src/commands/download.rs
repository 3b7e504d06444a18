//! `tmcl download`: a program into a module's memory.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use tmcl_client::{ClientError, Described};
use tmcl_lang::{Instruction, Severity, image};
use tmcl_tables::{GlobalParameter, ModuleSpec, Status};
use tmcl_wire::Request;

use super::application::needs_program_memory;
use super::asm::counted;
use crate::connection::{AnyClient, ConnectionOptions, told};
use crate::exit::{Code, Failure, Outcome};
use crate::print;
use crate::program::lints::LintOptions;
use crate::program::{Checked, diagnostics, files};

/// `tmcl download`.
#[derive(Args)]
#[command(
    after_help = "A file that ends in .bin is a compiled one (`tmcl asm`); anything else is text, assembled for the module that \
    answers. A running program is stopped first; the motor moves on. What lies behind the program in the memory stays."
)]
pub(crate) struct Download {
    /// The program; - is stdin
    file: PathBuf,
    /// Start it then, from its beginning
    #[arg(long)]
    run: bool,
    /// Read it back and compare
    #[arg(long)]
    verify: bool,
    #[command(flatten)]
    lints: LintOptions,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: ConnectionOptions,
}

/// What was done.
#[derive(Serialize)]
struct Report {
    module: &'static str,
    instructions: usize,
    memory: u16,
    verified: bool,
    running: bool,
}

/// Downloads it.
pub(crate) fn run(options: &Download) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    needs_program_memory(module)?;
    let program = program(options, module)?;
    client.stop_program().map_err(|error| told(&client, &error))?;
    let bar = print::progress(program.len(), "instructions stored");
    let downloaded = client.download(&program, &mut |count| bar.set_position(count as u64));
    bar.finish_and_clear();
    downloaded.map_err(|error| explained(&mut client, &error))?;
    if options.verify {
        let bar = print::progress(program.len(), "instructions read back");
        let verified = client.verify(&program, &mut |count| bar.set_position(count as u64));
        bar.finish_and_clear();
        verified.map_err(|error| differs(&mut client, &error))?;
    }
    if options.run {
        client.reset_program().and_then(|()| client.run(None)).map_err(|error| told(&client, &error))?;
    }
    let report = Report {
        module: module.id,
        instructions: program.len(),
        memory: module.program_memory,
        verified: options.verify,
        running: options.run,
    };
    if options.json {
        return Ok(print::json(&report)?);
    }
    print::note(&report.text());
    Ok(())
}

impl Report {
    fn text(&self) -> String {
        let verified = if self.verified { ", read back and the same" } else { "" };
        let running = if self.running { "; the program runs" } else { "" };
        let count = counted(self.instructions, "instruction");
        format!("{count} of {} stored{verified}{running}", self.memory)
    }
}

/// The instructions, as the module keeps them.
fn program(options: &Download, module: &'static ModuleSpec) -> Result<Vec<[u8; 7]>, Failure> {
    let instructions = if is_compiled(&options.file) {
        compiled(&options.file, module)?
    } else {
        assembled(options, module)?
    };
    if instructions.is_empty() {
        let message = format!("{} holds no instructions; nothing was stored", files::name(&options.file));
        return Err(Failure::new(Code::Usage, message));
    }
    Ok(instructions.iter().map(|instruction| instruction.to_bytes()).collect())
}

/// By the end of its name.
pub(crate) fn is_compiled(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("bin"))
}

fn compiled(file: &Path, module: &ModuleSpec) -> Result<Vec<Instruction>, Failure> {
    let name = files::name(file);
    let usage = |message: String| Failure::new(Code::Usage, message);
    let instructions = image::decode(&files::read(file)?)
        .map_err(|error| usage(format!("{name} is no compiled program: {error}")))?;
    let (count, memory) = (instructions.len(), module.program_memory);
    if count > usize::from(memory) {
        let message = format!("{name} has {count} instructions; the {} has room for {memory}", module.name);
        return Err(usage(message));
    }
    Ok(instructions)
}

/// With diagnostics, as `tmcl check` prints them.
fn assembled(options: &Download, module: &'static ModuleSpec) -> Result<Vec<Instruction>, Failure> {
    let source = files::root(&options.file)?;
    let named = Checked::of(source.clone(), None, &options.lints);
    let wanted = named.assembly.program.module;
    if named.assembly.module_is_named && wanted.number != module.number {
        let message = format!("the program is for a {}, but a {} answers", wanted.id, module.id);
        return Err(Failure::new(Code::Usage, message));
    }
    let checked = Checked::of(source, Some(module), &options.lints);
    diagnostics::print(&checked);
    match checked.count(Severity::Error) {
        0 => Ok(checked.assembly.program.instructions),
        errors => {
            Err(Failure::new(Code::Findings, format!("nothing was stored, {}", counted(errors, "error"))))
        }
    }
}

/// Where the two programs differ, in words.
fn differs(client: &mut AnyClient, error: &ClientError) -> Failure {
    match error {
        ClientError::Differs { expected, found, .. } => {
            let text = |bytes: &[u8; 7]| Described(Request::from_bytes(*bytes)).to_string();
            crate::connection::failure(error).and_says(&format!(" ({} and {})", text(expected), text(found)))
        }
        error => explained(client, error),
    }
}

/// A refusal that may come of the protection of the program.
pub(crate) fn explained(client: &mut AnyClient, error: &ClientError) -> Failure {
    let refused = told(client, error);
    if !is_not_available(error) {
        return refused;
    }
    let (bank, number) = GlobalParameter::CodeProtection.address();
    match client.get_global_parameter(bank, number) {
        Ok(protection @ 1..=3) => {
            let against = ["disassembly", "overwriting", "disassembly and overwriting"];
            let against = against.get(protection.unsigned_abs() as usize - 1).unwrap_or(&"it");
            refused.and_says(&format!(
                ". The program is protected against {against} (global parameter 81 is {protection}); setting that to 0 \
                 lifts the protection, and erases a program that must not be read"
            ))
        }
        _ => refused,
    }
}

fn is_not_available(error: &ClientError) -> bool {
    match error {
        ClientError::Status { status, .. } => *status == Status::NotAvailable,
        ClientError::Download { source, .. } | ClientError::DownloadEnd { source, .. } => {
            is_not_available(source)
        }
        _ => false,
    }
}
