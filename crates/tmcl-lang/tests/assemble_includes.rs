//! Included files: where they are found, in what order they count, and how they cannot get out of hand.

mod assemble_support;

use std::collections::BTreeMap;

use assemble_support::{Files, alone, alone_for, codes, instruction, module, render, source, written};
use insta::assert_snapshot;
use tmcl_lang::{Assembly, BUILTIN_INCLUDES, Resolved, Resolver, assemble, builtin_include};
use tmcl_tables::MODULES;

fn with_files<const N: usize>(text: &str, files: [(&'static str, &'static str); N]) -> Assembly {
    assemble(source(text), None, &mut Files(BTreeMap::from(files)))
}

#[test]
fn files_are_inlined_where_they_stand() {
    let assembly = with_files(
        "Speed = 1\n#include \"a.inc\"\nCOMP Speed\nJA Inner\n",
        [
            ("a.inc", "COMP Speed\nSpeed = 2\n#include b.inc\nCOMP 9"),
            ("b.inc", "Inner: COMP Speed\nSpeed = 3\n"),
        ],
    );
    assert_eq!(render(&assembly), "");
    let values = [1, 2, 9, 3].map(|value| instruction(20, 0, 0, value));
    assert_eq!(written(&assembly), [&values[..], &[instruction(22, 0, 0, 1)]].concat());
    let places: Vec<_> = assembly
        .program
        .origins
        .iter()
        .map(|origin| {
            format!("{}:{}", assembly.sources.name(*origin), assembly.sources.position(*origin).line)
        })
        .collect();
    assert_eq!(places, ["a.inc:1", "b.inc:1", "a.inc:4", "main.tmc:3", "main.tmc:4"]);
}

#[test]
fn a_file_beside_the_program_wins_over_the_built_in_one() {
    let assembly =
        with_files("#include Interrupts.inc\nEI TI_TIMER0\n", [("Interrupts.inc", "TI_TIMER0 = 15\n")]);
    assert_eq!(written(&assembly), [instruction(25, 15, 0, 0)]);
    let builtin = alone("#include INTERRUPTS.INC\nEI TI_TIMER2\n");
    assert_eq!(written(&builtin), [instruction(25, 2, 0, 0)]);
    assert!(builtin.sources.iter().any(|(_, file)| file.builtin && file.name == "Interrupts.inc"));
}

#[test]
fn e0301_missing_and_unreadable() {
    let text = "#include Interupts.inc\n#include nowhere.inc\n#include \"locked.inc\"\n#include nowhere.inc\nMST 0\n";
    assert_snapshot!(render(&with_files(text, [])));
}

#[test]
fn e0302_cycle() {
    let files = [
        ("a.inc", "MST 0\n#include b.inc\n"),
        ("b.inc", "#include c.inc\n"),
        ("c.inc", "\n  #include a.inc\nMST 0\n"),
    ];
    let assembly = with_files("#include a.inc\nSTOP\n", files);
    assert_snapshot!(render(&assembly));
    // What does not belong to the circle is there.
    assert_eq!(written(&assembly).len(), 3);
    assert_snapshot!(
        "e0302_the_program_itself",
        render(&with_files("#include main.tmc\n", [("main.tmc", "")]))
    );
}

#[test]
fn a_file_may_be_included_twice() {
    let files = [("set.inc", "SAP 4, 0, Speed\nFactor = Speed\n")];
    let assembly =
        with_files("Speed = 1\n#include set.inc\nSpeed = 2\n#include set.inc\nCOMP Factor\n", files);
    assert_eq!(render(&assembly), "");
    assert_eq!(written(&assembly).len(), 3);
    assert_eq!(assembly.sources.iter().count(), 2);
    let factor: Vec<_> =
        assembly.program.constants.iter().filter(|constant| constant.name == "Factor").collect();
    assert_eq!((factor.len(), factor[0].uses), (1, 1));
    // Its mistakes are told once, its labels cannot be.
    let files = [("bad.inc", "FOO\nL: MST 0\nSCO, 0\n")];
    assert_snapshot!(render(&with_files("#include bad.inc\n#include bad.inc\n", files)));
}

/// Every file includes the next one twice.
struct Doubling {
    calls: usize,
    lines: usize,
}

impl Resolver for Doubling {
    fn resolve(&mut self, _includer: &str, name: &str) -> Result<Option<Resolved>, String> {
        self.calls += 1;
        let depth: usize = name.parse().map_err(|_| name.to_owned())?;
        let next =
            if depth < 40 { format!("#include {0}\n#include {0}\n", depth + 1) } else { String::new() };
        Ok(Some(Resolved {
            name: name.to_owned(),
            bytes: (next + &"MST 0\n".repeat(self.lines)).into_bytes(),
        }))
    }
}

#[test]
fn includes_that_double_come_to_an_end() {
    for lines in [0, 1] {
        let mut resolver = Doubling { calls: 0, lines };
        let assembly = assemble(source("#include 0\n"), None, &mut resolver);
        assert!(resolver.calls < 100);
        let told = codes(&assembly);
        assert_eq!(told.iter().filter(|code| **code == "E0301").count(), 1, "{told:?}");
        assert!(assembly.program.instructions.len() <= 100_001);
    }
}

/// Every file includes a new one.
struct Endless;

impl Resolver for Endless {
    fn resolve(&mut self, _includer: &str, name: &str) -> Result<Option<Resolved>, String> {
        Ok(Some(Resolved { name: name.to_owned(), bytes: format!("#include x{name}").into_bytes() }))
    }
}

#[test]
fn includes_that_never_end_come_to_an_end() {
    let assembly = assemble(source("#include x\n"), None, &mut Endless);
    assert_eq!(codes(&assembly), ["E0301"]);
    assert_eq!(assembly.sources.iter().count(), 66);
    assert!(assembly.diagnostics[0].message.contains("too deep"));
}

#[test]
fn built_in_files_assemble_for_every_module_without_findings() {
    for spec in MODULES.iter().filter(|spec| spec.program_memory > 0) {
        for file in BUILTIN_INCLUDES {
            let text = builtin_include(file, spec).unwrap();
            let assembly = assemble(source(&text), Some(spec), &mut Files::default());
            assert_eq!(render(&assembly), "", "{file} for the {}", spec.name);
            assert!(!assembly.program.constants.is_empty());
        }
    }
    assert_eq!(builtin_include("other.inc", module("1311")), None);
}

#[test]
fn built_in_names_have_one_value_each() {
    for spec in MODULES {
        let mut values = BTreeMap::new();
        for file in BUILTIN_INCLUDES {
            let text = builtin_include(file, spec).unwrap();
            let assembly = assemble(source(&text), Some(spec), &mut Files::default());
            for constant in assembly.program.constants {
                let before = values.insert(constant.name.to_lowercase(), constant.value);
                assert_eq!(before, None, "{} for the {}", constant.name, spec.name);
            }
        }
    }
}

#[test]
fn every_parameter_and_interrupt_has_a_built_in_name() {
    for spec in MODULES {
        let values = |file, prefix: &str| -> Vec<i64> {
            let text = builtin_include(file, spec).unwrap();
            let assembly = assemble(source(&text), Some(spec), &mut Files::default());
            let constants = assembly.program.constants.into_iter();
            constants
                .filter(|constant| constant.name.starts_with(prefix))
                .map(|constant| constant.value)
                .collect()
        };
        let axis = values("TMCLParam.tmc", "AP");
        assert!(spec.axis_parameters.iter().all(|parameter| axis.contains(&i64::from(parameter.number))));
        let global = values("tmclparam.TMC", "GP");
        let mut named = spec.global_parameters.iter().filter(|entry| entry.bank != 2);
        assert!(named.all(|entry| global.contains(&i64::from(entry.parameter.number))));
        let interrupts = values("Interrupts.inc", "TI_");
        assert!(spec.interrupts.iter().all(|interrupt| interrupts.contains(&i64::from(interrupt.number))));
        assert!(interrupts.contains(&255));
    }
}

#[test]
fn built_in_names_of_the_manuals() {
    let text = "#include TMCLParam.tmc\nSAP APMaxPositioningSpeed, Motor0, 5\nSAP APMaxAcceleration, 0, 5\nGAP APActualPosition, 0\n\
                SAP APMaxVelocity, 0, 5\nGGP GPTickTimer, 0\nSGP GPTimer0Period, 3, 10\nSAP API2tLimit, 0, 5\n";
    let assembly = alone(text);
    assert_eq!(render(&assembly), "");
    let kinds: Vec<_> = written(&assembly).iter().map(|instruction| instruction.kind).collect();
    assert_eq!(kinds, [4, 5, 1, 4, 132, 0, 26]);
    // Each module has its own.
    let text = "#include TMCLParam.tmc\nSAP APMaxAcceleration, 0, 5\n";
    assert_eq!(written(&alone_for("1640", text)), [instruction(5, 11, 0, 5)]);
}

#[test]
fn built_in_interrupts_read_well() {
    assert_snapshot!(builtin_include("interrupts.inc", module("1311")).unwrap());
    let parameters = builtin_include("TMCLParam.tmc", module("1640")).unwrap();
    assert_snapshot!(
        "built_in_parameters_read_well",
        parameters.lines().take(24).collect::<Vec<_>>().join("\n")
    );
}
