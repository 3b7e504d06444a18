//! Labels and constants that nothing names.

use crate::code::Code;
use crate::diagnostic::Diagnostic;
use crate::program::Program;
use crate::source::Sources;

use super::Findings;
use super::flow::Graph;

/// Reports labels; those of a jump table at the top of the program are for a host (TMCM-1311 §11.6).
pub(super) fn report_labels(graph: &Graph, program: &Program, sources: &Sources, found: &mut Findings) {
    for label in program.labels.iter().filter(|label| label.uses == 0) {
        let address = usize::from(label.address);
        let builtin = sources.get(label.span.file).is_some_and(|file| file.builtin);
        if builtin || graph.is_in_jump_table(address) {
            continue;
        }
        let message = format!("no instruction names the label `{}`", label.name);
        found.push(address, Diagnostic::new(Code::UnusedLabel, label.span, message).label("never used"));
    }
}

/// The constants of the program's own file; include files define more than one program needs.
pub(super) fn unused_constants(program: &Program) -> impl Iterator<Item = Diagnostic> + '_ {
    let own = program.constants.iter().filter(|constant| constant.span.file == Sources::ROOT);
    own.filter(|constant| constant.uses == 0).map(|constant| {
        let message = format!("nothing names the constant `{}`", constant.name);
        let label = format!("never used; its value is {}", constant.value);
        Diagnostic::new(Code::UnusedConstant, constant.span, message).label(label)
    })
}
