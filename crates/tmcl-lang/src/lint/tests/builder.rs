//! Programs for tests, without the assembler: a line is labels and one instruction, made with the tables.

use tmcl_tables::{Command, ModuleSpec, Operand, TypeField, tmcm_1311};

use crate::code::Code;
use crate::diagnostic::{Diagnostic, Severity};
use crate::instruction::Instruction;
use crate::lint::lint;
use crate::program::{LabelDefinition, Program};
use crate::source::{SourceFile, Sources, Span};

/// A program for the TMCM-1311; as the assembler does, a STOP is appended where the last instruction does not end it.
pub(super) fn program(text: &str) -> (Program, Sources) {
    let mut sources = Sources::default();
    let file = sources.add(SourceFile { name: "test.tmc".to_owned(), bytes: text.into(), builtin: false });
    let mut program = Program {
        module: &tmcm_1311::SPEC,
        instructions: Vec::new(),
        origins: Vec::new(),
        appended_stop: false,
        labels: Vec::new(),
        constants: Vec::new(),
    };
    let mut statements = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let mut rest = line.split("//").next().unwrap_or_default();
        while let Some((name, after)) = rest.split_once(':') {
            let at = start + line.find(name.trim()).unwrap();
            let span = Span::new(file, at..at + name.trim().len());
            let address = u16::try_from(statements.len()).unwrap();
            program.labels.push(LabelDefinition { name: name.trim().to_owned(), span, address, uses: 0 });
            rest = after;
        }
        if !rest.trim().is_empty() {
            let at = start + line.find(rest.trim()).unwrap();
            program.origins.push(Span::new(file, at..at + rest.trim().len()));
            statements.push(rest.trim().to_owned());
        }
        start += line.len();
    }
    for statement in &statements {
        let instruction = instruction(statement, program.module, &mut program.labels);
        program.instructions.push(instruction);
    }
    append_stop(&mut program, Span::new(file, text.len()..text.len()));
    (program, sources)
}

fn append_stop(program: &mut Program, end: Span) {
    let last = program.instructions.last().and_then(|last| last.known_command());
    let ends = [Command::Stop, Command::Jump, Command::ReturnFromSubroutine, Command::ReturnFromInterrupt];
    if !last.is_some_and(|last| ends.contains(&last)) {
        program.instructions.push(Instruction::STOP);
        program.origins.push(end);
        program.appended_stop = true;
    }
}

fn instruction(statement: &str, module: &ModuleSpec, labels: &mut [LabelDefinition]) -> Instruction {
    let (mnemonic, operands) = statement.split_once(' ').unwrap_or((statement, ""));
    let entry = module.commands.iter().find(|entry| entry.spec.mnemonic == mnemonic).expect(mnemonic);
    let mut made = Instruction { command: entry.spec.number, ..Instruction::default() };
    let operands = operands.split(',').map(str::trim).filter(|operand| !operand.is_empty());
    for (operand, field) in operands.zip(entry.spec.operands) {
        let label = labels.iter_mut().find(|label| label.name == operand);
        let named = entry.named_types().find(|named| named.keyword == operand);
        let value = match (label, named) {
            (_, Some(named)) if entry.spec.type_field == TypeField::Named => i32::from(named.value),
            (Some(label), _) => {
                label.uses += 1;
                i32::from(label.address)
            }
            _ => operand.parse().expect(statement),
        };
        match field {
            Operand::Type => made.kind = u8::try_from(value).unwrap(),
            Operand::Motor => made.motor = u8::try_from(value).unwrap(),
            Operand::Value => made.value = value,
        }
    }
    made
}

/// What lint says about a program, those included that are off by default.
pub(super) fn findings(text: &str) -> Vec<Diagnostic> {
    let (program, sources) = program(text);
    let found = lint(&program, &sources);
    assert!(found.iter().all(|diagnostic| diagnostic.severity() == Severity::Warning));
    found
}

/// The codes that are on by default.
pub(super) fn codes(text: &str) -> Vec<&'static str> {
    findings(text).iter().map(|it| it.code).filter(|code| code.is_on_by_default()).map(Code::id).collect()
}

/// Everything lint says, with the text of the places.
pub(super) fn readable(text: &str) -> String {
    use core::fmt::Write;
    let mut sources = Sources::default();
    sources.add(SourceFile { name: "test.tmc".to_owned(), bytes: text.into(), builtin: false });
    let mut out = String::new();
    for it in findings(text) {
        let place = |span: Span| {
            let position = sources.position(span);
            format!(
                "{}:{} `{}`",
                position.line,
                position.column,
                String::from_utf8_lossy(sources.bytes(span))
            )
        };
        writeln!(out, "{}: {}\n  {}: {}", it.code, it.message, place(it.primary.span), it.primary.text)
            .unwrap();
        for label in &it.secondary {
            writeln!(out, "  {}: {}", place(label.span), label.text).unwrap();
        }
        for note in &it.notes {
            writeln!(out, "  note: {note}").unwrap();
        }
    }
    out
}
