//! What the tests of the assembler share.
#![allow(dead_code, missing_docs, reason = "each test file uses a part of it")]

use std::collections::BTreeMap;
use std::fmt::Write;

use tmcl_lang::{
    Assembly, Diagnostic, Instruction, NoIncludes, Resolved, Resolver, Severity, SourceFile, Span, assemble,
};
use tmcl_tables::{ModuleSpec, module_by_id};

/// Files in memory.
#[derive(Default)]
pub(crate) struct Files(pub(crate) BTreeMap<&'static str, &'static str>);

impl Resolver for Files {
    fn resolve(&mut self, _includer: &str, name: &str) -> Result<Option<Resolved>, String> {
        if name == "locked.inc" {
            return Err("permission denied".to_owned());
        }
        let found = self.0.get(name);
        Ok(found.map(|text| Resolved { name: name.to_owned(), bytes: text.as_bytes().to_vec() }))
    }
}

pub(crate) fn module(name: &str) -> &'static ModuleSpec {
    module_by_id(name).unwrap()
}

pub(crate) fn source(text: &str) -> SourceFile {
    SourceFile { name: "main.tmc".to_owned(), bytes: text.as_bytes().to_vec(), builtin: false }
}

/// Assembles a text that stands alone for the module it names, or the TMCM-1311.
pub(crate) fn alone(text: &str) -> Assembly {
    assemble(source(text), None, &mut NoIncludes)
}

pub(crate) fn alone_for(name: &str, text: &str) -> Assembly {
    assemble(source(text), Some(module(name)), &mut NoIncludes)
}

/// The instructions of a text without findings, but for the STOP that was appended.
pub(crate) fn clean(text: &str) -> Vec<Instruction> {
    let assembly = alone(text);
    assert_eq!(render(&assembly), "", "{text}");
    written(&assembly)
}

/// The instructions that the text has.
pub(crate) fn written(assembly: &Assembly) -> Vec<Instruction> {
    let mut instructions = assembly.program.instructions.clone();
    assert_eq!(instructions.len(), assembly.program.origins.len());
    if assembly.program.appended_stop {
        assert_eq!(instructions.pop(), Some(Instruction::STOP));
    }
    instructions
}

pub(crate) fn instruction(command: u8, kind: u8, motor: u8, value: i32) -> Instruction {
    Instruction { command, kind, motor, value }
}

/// The ids of what is to be said of a text, in order.
pub(crate) fn codes(assembly: &Assembly) -> Vec<&'static str> {
    assembly.diagnostics.iter().map(|diagnostic| diagnostic.code.id()).collect()
}

/// All that is to be said, plainly.
pub(crate) fn render(assembly: &Assembly) -> String {
    let mut text = String::new();
    for diagnostic in &assembly.diagnostics {
        render_one(&mut text, assembly, diagnostic);
    }
    text
}

fn render_one(text: &mut String, assembly: &Assembly, diagnostic: &Diagnostic) {
    let severity = match diagnostic.severity() {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    writeln!(text, "{severity}[{}]: {}", diagnostic.code, diagnostic.message).unwrap();
    let place = |span: Span, label: &str| {
        let position = assembly.sources.position(span);
        let quoted = String::from_utf8_lossy(assembly.sources.bytes(span)).into_owned();
        let label = if label.is_empty() { String::new() } else { format!(": {label}") };
        format!("{}:{}:{} `{quoted}`{label}", assembly.sources.name(span), position.line, position.column)
    };
    writeln!(text, "  at   {}", place(diagnostic.primary.span, &diagnostic.primary.text)).unwrap();
    for label in &diagnostic.secondary {
        writeln!(text, "  also {}", place(label.span, &label.text)).unwrap();
    }
    for note in &diagnostic.notes {
        writeln!(text, "  note {note}").unwrap();
    }
    if let Some(suggestion) = &diagnostic.suggestion {
        let place = place(suggestion.span, "");
        writeln!(text, "  help {}: {place} -> `{}`", suggestion.text, suggestion.replacement).unwrap();
    }
}
