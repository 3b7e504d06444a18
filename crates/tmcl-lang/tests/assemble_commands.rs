//! Commands as a host sends them.

use tmcl_lang::{Code, Instruction, NoIncludes, SourceFile, assemble_commands};
use tmcl_tables::{MODULES, ModuleSpec, tmcm_1076, tmcm_1311, tmcm_1640};

fn assembled(text: &str, module: &'static ModuleSpec) -> (Vec<Instruction>, Vec<(Code, String)>) {
    let root = SourceFile { name: "here".to_owned(), bytes: text.as_bytes().to_vec(), builtin: false };
    let assembly = assemble_commands(root, module, &mut NoIncludes);
    let diagnostics = assembly.diagnostics.into_iter().map(|it| (it.code, it.message)).collect();
    (assembly.program.instructions, diagnostics)
}

#[test]
fn commands_stand_alone() {
    let (instructions, diagnostics) = assembled("MVP ABS, 0, 51200\nGAP 1, 0\n", &tmcm_1311::SPEC);
    let bytes: Vec<_> = instructions.iter().map(|it| it.to_bytes()).collect();
    assert_eq!(bytes, [[4, 0, 0, 0, 0, 200, 0], [6, 1, 0, 0, 0, 0, 0]], "without a STOP behind them");
    assert_eq!(diagnostics, []);
}

#[test]
fn what_only_programs_have_is_refused() {
    for module in MODULES {
        for entry in
            module.commands.iter().filter(|entry| !entry.spec.mnemonic.is_empty() && !entry.modes.direct)
        {
            let operands: Vec<String> = entry.spec.operands.iter().map(|_| "0".to_owned()).collect();
            let text = format!("{} {}", entry.spec.mnemonic, operands.join(", "));
            let (_, diagnostics) = assembled(&text, module);
            let message = format!("{} cannot be sent to a {}", entry.spec.mnemonic, module.name);
            assert_eq!(diagnostics.first(), Some(&(Code::CommandMissing, message)), "{text}");
        }
    }
}

/// A program of this module cannot be, but its tables hold for what a host sends.
#[test]
fn a_module_without_programs_has_commands() {
    let (instructions, diagnostics) =
        assembled("SAP 6, 0, 31\nSAP 6, 0, 32\nMVP ABS, 0, 1\n", &tmcm_1076::SPEC);
    assert_eq!(instructions.len(), 3);
    let codes: Vec<_> = diagnostics.iter().map(|(code, _)| *code).collect();
    assert_eq!(codes, [Code::ParameterRange, Code::CommandMissing]);
}

/// A program has to fit the memory; commands come one after the other.
#[test]
fn any_number_of_commands_will_do() {
    let text = "GAP 1, 0\n".repeat(3000);
    for module in [&tmcm_1311::SPEC, &tmcm_1640::SPEC] {
        let (instructions, diagnostics) = assembled(&text, module);
        assert_eq!((instructions.len(), diagnostics.len()), (3000, 0));
    }
}
