//! The listings' files, assembled and linted.

use std::path::PathBuf;

use tmcl_lang::{Assembly, NoIncludes, SourceFile, assemble, lint::lint};

/// Where the listings are.
pub(crate) fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tmcl-lang/tests/listings")
}

/// The text of a listing.
#[track_caller]
pub(crate) fn text(name: &str) -> String {
    std::fs::read_to_string(folder().join(format!("{name}.tmc"))).expect("a listing of that name")
}

/// A program text, assembled for the module that its first line names.
pub(crate) fn assembled(name: &str, text: &str) -> Assembly {
    let source = SourceFile { name: format!("{name}.tmc"), bytes: text.as_bytes().to_vec(), builtin: false };
    assemble(source, None, &mut NoIncludes)
}

/// A listing, assembled.
#[track_caller]
pub(crate) fn listing(name: &str) -> Assembly {
    assembled(name, &text(name))
}

/// The codes of all that `tmcl check` says of a program, in its order.
pub(crate) fn codes(assembly: &Assembly) -> Vec<&'static str> {
    let mut found = assembly.diagnostics.clone();
    if !assembly.has_errors() {
        found.extend(lint(&assembly.program, &assembly.sources));
    }
    found.retain(|diagnostic| diagnostic.code.is_on_by_default());
    found.iter().map(|diagnostic| diagnostic.code.id()).collect()
}

/// The seven bytes of every instruction.
pub(crate) fn instructions(assembly: &Assembly) -> Vec<[u8; 7]> {
    assembly.program.instructions.iter().map(|instruction| instruction.to_bytes()).collect()
}

/// A text with the first suggestion that the assembler makes for it.
#[track_caller]
pub(crate) fn as_suggested(text: &str) -> String {
    let assembly = assembled("slip", text);
    let suggestion = assembly.diagnostics.iter().find_map(|found| found.suggestion.clone());
    let suggestion = suggestion.expect("a suggestion");
    let mut mended = text.to_owned();
    mended.replace_range(suggestion.span.range(), &suggestion.replacement);
    mended
}
