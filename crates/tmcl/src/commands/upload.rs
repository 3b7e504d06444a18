//! `tmcl upload`: a module's program memory as text.

use std::path::{Path, PathBuf};

use clap::Args;
use tmcl_lang::{Instruction, disassemble, image};
use tmcl_tables::Command;

use super::application::needs_program_memory;
use super::asm::counted;
use super::download::{explained, is_compiled};
use crate::connection::ConnectionOptions;
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
    #[command(flatten)]
    connection: ConnectionOptions,
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
    files::write(&options.out, &bytes)?;
    if options.out != Path::new(files::STANDARD) {
        print::note(&format!(
            "{} written to {}",
            counted(program.len(), "instruction"),
            options.out.display()
        ));
    }
    Ok(())
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
}
