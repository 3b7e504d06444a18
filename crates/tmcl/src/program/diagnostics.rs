//! Diagnostics for people, in the style of rustc, and for machines.

use std::io::IsTerminal;

use annotate_snippets::{AnnotationKind, Group, Level, Patch, Renderer, Snippet};
use serde::Serialize;
use tmcl_lang::{Diagnostic, Severity, Sources, Span};

use super::Checked;

/// Prints diagnostics to stderr.
pub(crate) fn print(checked: &Checked) {
    let text: String =
        checked.diagnostics.iter().map(|diagnostic| render(diagnostic, &checked.assembly.sources)).collect();
    anstream::eprint!("{text}");
    if !checked.assembly.module_is_named && checked.diagnostics.iter().any(depends_on_module) {
        let module = checked.assembly.program.module;
        crate::print::note(&format!(
            "checked for the {}, since neither --module nor a first line such as `//! module: {}` names one",
            module.name, module.id
        ));
    }
}

/// What one module refuses another may take.
fn depends_on_module(diagnostic: &Diagnostic) -> bool {
    diagnostic.code.id().starts_with("E02")
}

/// A diagnostic for people.
pub(crate) fn render(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let level = match diagnostic.severity() {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(diagnostic.message.as_str()).id(diagnostic.code.id());
    let mut group = title.elements(snippets(diagnostic, sources));
    for note in &diagnostic.notes {
        group = group.element(Level::NOTE.message(note.as_str()));
    }
    let mut report = vec![group];
    report.extend(suggestion(diagnostic, sources));
    let width =
        terminal_size::terminal_size_of(std::io::stderr()).map_or(140, |(width, _)| usize::from(width.0));
    let renderer = if std::io::stderr().is_terminal() { Renderer::styled() } else { Renderer::plain() };
    format!("{}\n\n", renderer.term_width(width).render(&report))
}

/// One snippet a file, that of the primary place first.
fn snippets<'a>(
    diagnostic: &'a Diagnostic,
    sources: &'a Sources,
) -> Vec<Snippet<'a, annotate_snippets::Annotation<'a>>> {
    let mut files = vec![diagnostic.primary.span.file];
    files.extend(diagnostic.secondary.iter().map(|label| label.span.file));
    let mut seen = std::collections::BTreeSet::new();
    files.retain(|file| seen.insert(*file));
    let labels = std::iter::once((AnnotationKind::Primary, &diagnostic.primary))
        .chain(diagnostic.secondary.iter().map(|label| (AnnotationKind::Context, label)));
    let labels: Vec<_> = labels.collect();
    let snippet = |file| {
        let source = sources.get(file)?;
        let text = String::from_utf8_lossy(&source.bytes);
        let annotations = labels.iter().filter(|(_, label)| label.span.file == file).map(|(kind, label)| {
            let annotation = kind.span(in_text(label.span, &source.bytes));
            if label.text.is_empty() { annotation } else { annotation.label(label.text.as_str()) }
        });
        Some(Snippet::source(text).path(source.name.as_str()).annotations(annotations.collect::<Vec<_>>()))
    };
    files.into_iter().filter_map(snippet).collect()
}

fn suggestion<'a>(diagnostic: &'a Diagnostic, sources: &'a Sources) -> Option<Group<'a>> {
    let suggestion = diagnostic.suggestion.as_ref()?;
    let source = sources.get(suggestion.span.file)?;
    let text = String::from_utf8_lossy(&source.bytes);
    let patch = Patch::new(in_text(suggestion.span, &source.bytes), suggestion.replacement.as_str());
    let title = Level::HELP.secondary_title(suggestion.text.as_str());
    Some(title.element(Snippet::source(text).path(source.name.as_str()).patch(patch)))
}

/// Where a span is once bytes that are no UTF-8 are replaced, which changes their number.
fn in_text(span: Span, bytes: &[u8]) -> core::ops::Range<usize> {
    let offset = |offset: u32| {
        let before = bytes.get(..offset as usize).unwrap_or(bytes);
        String::from_utf8_lossy(before).len()
    };
    offset(span.start)..offset(span.end)
}

/// A place in a file, for machines; lines and columns count from 1.
#[derive(Serialize)]
struct Place<'a> {
    file: &'a str,
    line: u32,
    column: u32,
    end_line: u32,
    end_column: u32,
}

#[derive(Serialize)]
struct LabelJson<'a> {
    #[serde(flatten)]
    place: Place<'a>,
    text: &'a str,
}

#[derive(Serialize)]
struct SuggestionJson<'a> {
    #[serde(flatten)]
    place: Place<'a>,
    replacement: &'a str,
    text: &'a str,
}

/// A diagnostic for machines.
#[derive(Serialize)]
pub(crate) struct DiagnosticJson<'a> {
    code: &'static str,
    severity: &'static str,
    message: &'a str,
    #[serde(flatten)]
    place: Place<'a>,
    label: &'a str,
    secondary: Vec<LabelJson<'a>>,
    notes: &'a [String],
    suggestion: Option<SuggestionJson<'a>>,
}

/// The diagnostics of some files for machines.
#[derive(Serialize)]
pub(crate) struct Report<'a> {
    errors: usize,
    warnings: usize,
    diagnostics: Vec<DiagnosticJson<'a>>,
}

/// The diagnostics of some files for machines.
pub(crate) fn report(files: &[Checked]) -> Report<'_> {
    let total = |severity| files.iter().map(|checked| checked.count(severity)).sum();
    Report {
        errors: total(Severity::Error),
        warnings: total(Severity::Warning),
        diagnostics: files.iter().flat_map(json).collect(),
    }
}

/// A file's diagnostics for machines.
pub(crate) fn json(checked: &Checked) -> Vec<DiagnosticJson<'_>> {
    let sources = &checked.assembly.sources;
    checked.diagnostics.iter().map(|diagnostic| diagnostic_json(diagnostic, sources)).collect()
}

fn diagnostic_json<'a>(diagnostic: &'a Diagnostic, sources: &'a Sources) -> DiagnosticJson<'a> {
    let label =
        |label: &'a tmcl_lang::Label| LabelJson { place: place(label.span, sources), text: &label.text };
    DiagnosticJson {
        code: diagnostic.code.id(),
        severity: match diagnostic.severity() {
            Severity::Error => "error",
            Severity::Warning => "warning",
        },
        message: &diagnostic.message,
        place: place(diagnostic.primary.span, sources),
        label: &diagnostic.primary.text,
        secondary: diagnostic.secondary.iter().map(label).collect(),
        notes: &diagnostic.notes,
        suggestion: diagnostic.suggestion.as_ref().map(|suggestion| SuggestionJson {
            place: place(suggestion.span, sources),
            replacement: &suggestion.replacement,
            text: &suggestion.text,
        }),
    }
}

fn place(span: Span, sources: &Sources) -> Place<'_> {
    let start = sources.position(span);
    let end = sources.position(Span { start: span.end, ..span });
    Place {
        file: sources.name(span),
        line: start.line,
        column: start.column,
        end_line: end.line,
        end_column: end.column,
    }
}
