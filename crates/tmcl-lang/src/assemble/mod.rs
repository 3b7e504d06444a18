//! Text to program.
//!
//! 1. `header` finds the line that names the module.
//! 2. `load` inlines the included files where they stand.
//! 3. `names` collects the labels of all lines, so that jumps forward find theirs.
//! 4. `builder` goes through the lines once, defines constants and makes the instructions: `count` looks at how many
//!    operands there are, `operand` at what each stands for, `check` at what the module takes.
//!
//! One mistake is one diagnostic: whatever was complained about is not looked at again. What the commands take comes from
//! `tmcl-tables` alone. This module must never know where a program goes, nor what it does when it runs.

mod builder;
mod check;
mod count;
mod data;
mod header;
mod load;
mod names;
mod operand;
mod suggest;
mod words;

use tmcl_tables::{Mode, ModuleSpec};

use crate::diagnostic::{Diagnostic, Severity};
use crate::program::Program;
use crate::resolver::Resolver;
use crate::source::{SourceFile, Sources};
use crate::syntax::{Parse, parse};

use builder::Builder;
use header::Target;
use names::Names;

/// What became of a text.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// Every file that was read, the program's own first.
    pub sources: Sources,
    /// The program; with errors, what could be made of it.
    pub program: Program,
    /// What is wrong or hardly meant, file by file in the order of their lines; lints are not among it.
    pub diagnostics: Vec<Diagnostic>,
    /// Whether the module was named, by the caller or by a line `//! module: …`.
    pub module_is_named: bool,
}

impl Assembly {
    /// Whether there is anything that keeps the program from being used.
    #[must_use]
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|diagnostic| diagnostic.severity() == Severity::Error)
    }
}

/// Assembles a file for `module`, or for the one that its line `//! module: …` names, or else for the TMCM-1311.
pub fn assemble(
    root: SourceFile,
    module: Option<&'static ModuleSpec>,
    resolver: &mut dyn Resolver,
) -> Assembly {
    let parsed = parse(Sources::ROOT, &root.bytes);
    let target = header::target(module, &parsed.file, &root.bytes);
    finish(root, parsed, target, resolver)
}

/// Assembles commands as a host sends them, one a line: what only a program can hold is complained about, no STOP is appended,
/// and any number of them will do.
///
/// A complaint with a code from E0202 to E0210 or E0213 is the tables' opinion of a command that is nevertheless the one that
/// was written, unless its value does not fit 32 bits: a module may be newer than the tables.
pub fn assemble_commands(
    root: SourceFile,
    module: &'static ModuleSpec,
    resolver: &mut dyn Resolver,
) -> Assembly {
    let parsed = parse(Sources::ROOT, &root.bytes);
    let target = header::Target {
        module,
        mode: Mode::Direct,
        is_named: true,
        is_known: true,
        appends_stop: false,
        diagnostic: None,
    };
    finish(root, parsed, target, resolver)
}

fn finish(root: SourceFile, parsed: Parse, mut target: Target, resolver: &mut dyn Resolver) -> Assembly {
    let mut loaded = load::inline(root, parsed, target.module, resolver);
    let mut diagnostics = core::mem::take(&mut loaded.diagnostics);
    diagnostics.extend(target.diagnostic.take());

    let (names, complaints) = Names::collect(&loaded);
    diagnostics.extend(complaints);
    let (program, complaints) = Builder::new(&loaded, &target, names).build();
    diagnostics.extend(complaints);

    // A file that is included twice is complained about once.
    diagnostics.sort_by_key(|diagnostic| {
        (diagnostic.primary.span.file, diagnostic.primary.span.start, diagnostic.code)
    });
    diagnostics.dedup();
    Assembly { sources: loaded.sources, program, diagnostics, module_is_named: target.is_named }
}
