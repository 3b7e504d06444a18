//! Any bytes through lexer, parser, formatter, assembler and lints, and what comes of them through the disassembler and
//! back: no panic, formatting twice is the same as once, and the same instructions come back.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tmcl_lang::{NoIncludes, SourceFile, assemble, assemble_commands, disassemble, format, lint};

fn source(bytes: Vec<u8>) -> SourceFile {
    SourceFile { name: "fuzz.tmc".to_owned(), bytes, builtin: false }
}

fuzz_target!(|bytes: &[u8]| {
    let formatted = format(bytes);
    assert_eq!(format(&formatted), formatted);
    let assembly = assemble(source(bytes.to_vec()), None, &mut NoIncludes);
    let _ = assemble_commands(source(bytes.to_vec()), assembly.program.module, &mut NoIncludes);
    if assembly.has_errors() {
        return;
    }
    let program = &assembly.program;
    lint::lint(program, &assembly.sources);
    assert_eq!(assemble(source(formatted), None, &mut NoIncludes).program.instructions, program.instructions);
    let text = disassemble(&program.instructions, program.module);
    let again = assemble(source(text.into_bytes()), None, &mut NoIncludes);
    assert!(!again.has_errors(), "{:?}", again.diagnostics);
    assert_eq!(again.program.instructions, program.instructions);
});
