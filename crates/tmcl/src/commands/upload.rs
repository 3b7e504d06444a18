//! `tmcl upload`: a module's program memory as text.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use tmcl_client::Described;
use tmcl_lang::{Instruction, disassemble, image};
use tmcl_tables::Command;
use tmcl_wire::Request;

use super::application::needs_program_memory;
use super::asm::counted;
use super::download::{explained, is_compiled};
use crate::connection::ConnectionOptions;
use crate::direct::hexadecimal;
use crate::exit::Outcome;
use crate::print;
use crate::program::files;

/// `tmcl upload`.
#[derive(Args)]
#[command(
    after_help = "The whole memory is read. Erased memory reads as STOP: what is behind the program is left out, but for the \
    STOP that ends it."
)]
pub(crate) struct Upload {
    /// Where the program goes: text, or compiled if the name ends in .bin; without it, and for -, stdout
    #[arg(short, long, value_name = "FILE", default_value = "-", hide_default_value = true)]
    out: PathBuf,
    /// Print JSON; a file is written as ever
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: ConnectionOptions,
}

/// What was read, as JSON has it.
#[derive(Serialize)]
struct Report {
    module: &'static str,
    instructions: usize,
    memory: u16,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    program: Vec<Row>,
}

/// An instruction.
#[derive(Serialize)]
struct Row {
    address: usize,
    command: String,
    bytes: String,
}

/// Uploads it.
pub(crate) fn run(options: &Upload) -> Outcome {
    let (mut client, module) = options.connection.connect()?;
    needs_program_memory(module)?;
    let memory = usize::from(module.program_memory);
    let bar = print::progress(memory, "instructions read");
    let read = client.read_program(memory, &mut |count| bar.set_position(count as u64));
    bar.finish_and_clear();
    let read = read.map_err(|error| explained(&mut client, &error))?;
    let memory: Vec<_> = read.into_iter().map(Instruction::from_bytes).collect();
    let program = without_erased(&memory);
    if program.is_empty() {
        print::note("the program memory is erased: it holds nothing but STOP");
    }
    let bytes = if is_compiled(&options.out) {
        image::encode(program)
    } else {
        disassemble(program, module).into_bytes()
    };
    let to_stdout = options.out == Path::new(files::STANDARD);
    if !(to_stdout && options.json) {
        files::write(&options.out, &bytes)?;
    }
    if options.json {
        return Ok(print::json(&Report {
            module: module.id,
            instructions: program.len(),
            memory: module.program_memory,
            file: (!to_stdout).then(|| options.out.display().to_string()),
            program: program.iter().enumerate().map(|(address, it)| Row::new(address, *it)).collect(),
        })?);
    }
    if !to_stdout {
        print::note(&format!(
            "{} written to {}",
            counted(program.len(), "instruction"),
            options.out.display()
        ));
    }
    Ok(())
}

impl Row {
    fn new(address: usize, instruction: Instruction) -> Self {
        let bytes = instruction.to_bytes();
        let command = Described(Request::from_bytes(bytes)).to_string();
        Self { address, command, bytes: hexadecimal(&bytes) }
    }
}

/// Up to the last instruction that is no STOP, and the STOP behind it where execution runs into it.
fn without_erased(memory: &[Instruction]) -> &[Instruction] {
    let Some(last) = memory.iter().rposition(|instruction| *instruction != Instruction::STOP) else {
        return &[];
    };
    let ends = memory.get(last).is_some_and(|last| {
        use Command::{Jump, ReturnFromInterrupt, ReturnFromSubroutine};
        matches!(last.known_command(), Some(Jump | ReturnFromInterrupt | ReturnFromSubroutine))
    });
    memory.get(..last + if ends { 1 } else { 2 }).unwrap_or(memory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erased_memory_is_left_out() {
        let stop = Instruction::STOP;
        let of = |command: Command| Instruction { command: command.number(), ..stop };
        let (jump, motor_stop) = (of(Command::Jump), of(Command::MotorStop));
        assert_eq!(without_erased(&[stop; 4]), []);
        assert_eq!(without_erased(&[motor_stop, stop, stop]), [motor_stop, stop]);
        assert_eq!(without_erased(&[motor_stop, stop, jump, stop]), [motor_stop, stop, jump]);
        assert_eq!(without_erased(&[stop, motor_stop]), [stop, motor_stop], "the memory is full");
    }

    #[test]
    fn an_instruction_for_machines() {
        let wait = Instruction::from_bytes([27, 1, 0, 0, 0, 0, 100]);
        let row = serde_json::to_string(&Row::new(3, wait)).expect("it is plain data");
        assert_eq!(row, r#"{"address":3,"command":"WAIT POS, 0, 100","bytes":"1b 01 00 00 00 00 64"}"#);
    }
}
