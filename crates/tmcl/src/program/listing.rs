//! The listing: every line of the program's files beside the instructions that came of it.

use std::fmt::Write;

use tmcl_lang::{Assembly, FileId, SourceFile, Span};

/// The listing of a program.
pub(crate) fn listing(assembly: &Assembly) -> String {
    let mut text = String::new();
    for (file, source) in assembly.sources.iter().filter(|(_, source)| !source.builtin) {
        let _ = writeln!(text, "{}{}", if text.is_empty() { "" } else { "\n" }, source.name);
        add_file(&mut text, assembly, file, source);
    }
    if assembly.program.appended_stop
        && let Some((address, stop)) = assembly.program.instructions.iter().enumerate().next_back()
    {
        let _ = writeln!(text, "{address:>4}  {}        (appended)", hexadecimal(stop.to_bytes()));
    }
    text
}

fn add_file(text: &mut String, assembly: &Assembly, file: FileId, source: &SourceFile) {
    // What follows the last line feed is a line only if there is something.
    let text_of_lines = source.bytes.strip_suffix(b"\n").unwrap_or(&source.bytes);
    let lines = text_of_lines.split(|byte| *byte == b'\n');
    let mut start = 0;
    for (index, line) in lines.enumerate() {
        let span = Span::new(file, start..start + line.len());
        start += line.len() + 1;
        let mut instructions = instructions_in(assembly, span);
        let line = String::from_utf8_lossy(line);
        let line = line.trim_end();
        let first = instructions.next().map_or_else(|| " ".repeat(26), shown);
        let _ = writeln!(text, "{}", format!("{first}  {:>5}  {line}", index + 1).trim_end());
        for further in instructions {
            let _ = writeln!(text, "{}", shown(further));
        }
    }
}

type Placed = (usize, [u8; 7]);

/// What was written within `line`; the appended STOP was not written anywhere.
fn instructions_in(assembly: &Assembly, line: Span) -> impl Iterator<Item = Placed> {
    let program = &assembly.program;
    let written = program.instructions.len() - usize::from(program.appended_stop);
    let placed = program.instructions.iter().zip(&program.origins).take(written).enumerate();
    placed
        .filter(move |(_, (_, origin))| {
            origin.file == line.file && origin.start >= line.start && origin.start <= line.end
        })
        .map(|(address, (instruction, _))| (address, instruction.to_bytes()))
}

fn shown((address, bytes): Placed) -> String {
    format!("{address:>4}  {}", hexadecimal(bytes))
}

fn hexadecimal(bytes: [u8; 7]) -> String {
    bytes.map(|byte| format!("{byte:02X}")).join(" ")
}
