//! What must hold for any text.

mod assemble_support;

use assemble_support::{alone, codes, instruction, render, written};
use proptest::prelude::*;
use tmcl_lang::{Instruction, NoIncludes, SourceFile, assemble};
use tmcl_tables::{
    CommandSpec, Direction, ModuleCommand, ModuleSpec, MotorField, Operand, TypeField, ValueField, ValueSet,
    tmcm_1311,
};

const MODULE: &ModuleSpec = &tmcm_1311::SPEC;

/// An instruction as text and as it must come out.
#[derive(Clone, Debug)]
struct Line {
    text: String,
    expected: Instruction,
}

/// A value of a set.
fn value_in(set: ValueSet) -> impl Strategy<Value = i64> {
    prop::sample::select(set.intervals.to_vec()).prop_flat_map(move |(low, high)| {
        (low..=high).prop_map(move |value| {
            let down = value - value.rem_euclid(set.step);
            if down < low { down + set.step } else { down }
        })
    })
}

/// A number as people write it.
fn number(value: i64, hexadecimal: bool) -> String {
    if hexadecimal && value >= 0 { format!("${value:x}") } else { value.to_string() }
}

/// As 32 bits, where the sign may be a bit of the value.
fn wrapped(value: i64) -> i32 {
    i32::try_from(value).unwrap_or_else(|_| u32::try_from(value).unwrap().cast_signed())
}

/// Type, motor and value of a valid instruction, the type with its text.
fn fields(entry: &'static ModuleCommand) -> BoxedStrategy<(u8, String, u8, i64)> {
    let spec = entry.spec;
    match spec.type_field {
        TypeField::AxisParameter => {
            let allowed = MODULE.axis_parameters.iter().filter(move |parameter| match spec.mnemonic {
                "SAP" | "AAP" => parameter.access.write,
                "GAP" => parameter.access.read,
                _ => parameter.access.store,
            });
            let allowed: Vec<_> = allowed.collect();
            let any = prop::sample::select(allowed)
                .prop_flat_map(|parameter| (Just(parameter.number), value_in(parameter.write_range)));
            any.prop_map(|(number, value)| (number, number.to_string(), 0, value)).boxed()
        }
        TypeField::GlobalParameter => {
            let any = (0_u8..=55, any::<i32>());
            any.prop_map(|(number, value)| (number, number.to_string(), 2, i64::from(value))).boxed()
        }
        TypeField::Port => {
            let sets = spec.value_field == ValueField::PortValue;
            let ports = MODULE.ports.iter().filter(move |port| !sets || port.direction == Direction::Output);
            let any = (prop::sample::select(ports.collect::<Vec<_>>()), 0_i64..=1);
            any.prop_map(|(port, value)| (port.number, port.number.to_string(), port.bank, value)).boxed()
        }
        TypeField::Coordinate => {
            let any = (0..MODULE.coordinates, any::<i32>());
            any.prop_map(|(number, value)| (number, number.to_string(), 0, i64::from(value))).boxed()
        }
        TypeField::Interrupt => {
            let any = (prop::sample::select(MODULE.interrupts), 0_i64..2048);
            any.prop_map(|(interrupt, value)| (interrupt.number, interrupt.number.to_string(), 0, value))
                .boxed()
        }
        TypeField::Named => {
            let types: Vec<_> = entry.named_types().collect();
            let any = (prop::sample::select(types), any::<bool>(), value(spec));
            any.prop_map(|(named, by_keyword, value)| {
                let text = if by_keyword { named.keyword.to_owned() } else { named.value.to_string() };
                let value = if named.id == "coordinate" { value.rem_euclid(21) } else { value };
                (named.value, text, 0, value)
            })
            .boxed()
        }
        TypeField::Unused => {
            let is_user = spec.motor_field == MotorField::Unused && spec.operands.len() == 3;
            let byte = if is_user { 0..=255_u8 } else { 0..=0 };
            (byte.clone(), byte, value(spec))
                .prop_map(|(kind, motor, value)| (kind, kind.to_string(), motor, value))
                .boxed()
        }
    }
}

fn value(spec: &CommandSpec) -> BoxedStrategy<i64> {
    match spec.value_field {
        ValueField::Address => (0_i64..2048).boxed(),
        ValueField::Ticks => (0..=i64::from(i32::MAX)).boxed(),
        ValueField::Velocity => value_in(MODULE.axis_parameter(2).unwrap().write_range).boxed(),
        _ => any::<i32>().prop_map(i64::from).boxed(),
    }
}

fn line() -> impl Strategy<Value = Line> {
    let entries: Vec<&'static ModuleCommand> =
        MODULE.commands.iter().filter(|entry| !entry.spec.mnemonic.is_empty()).collect();
    let spaces = prop::sample::select(vec![" ", "\t", "  "]);
    let command = prop::sample::select(entries).prop_flat_map(|entry| (Just(entry.spec), fields(entry)));
    (command, any::<[bool; 2]>(), spaces).prop_map(
        |((spec, (kind, text, motor, value)), [lower, hexadecimal], space)| {
            let operands = spec.operands.iter().map(|operand| match operand {
                Operand::Type => text.clone(),
                Operand::Motor => motor.to_string(),
                Operand::Value => number(value, hexadecimal),
            });
            let text = format!("{space}{}{space}{}", spec.mnemonic, operands.collect::<Vec<_>>().join(","));
            let has = |operand| spec.operands.contains(&operand);
            let value = if has(Operand::Value) { wrapped(value) } else { 0 };
            let expected = instruction(
                spec.number,
                if has(Operand::Type) { kind } else { 0 },
                if has(Operand::Motor) { motor } else { 0 },
                value,
            );
            Line { text: if lower { text.to_lowercase() } else { text }, expected }
        },
    )
}

/// Words that come up in programs, so that texts of them get beyond the parser.
fn soup() -> impl Strategy<Value = String> {
    let words = [
        "SAP",
        "GAP",
        "MVP",
        "JA",
        "JC",
        "WAIT",
        "CALC",
        "STOP",
        "VECT",
        "GCO",
        "UF0",
        "ABS",
        "COORD",
        "TICKS",
        "EQ",
        "Loop",
        "Loop:",
        "X",
        "X =",
        "-",
        ",",
        ":",
        "=",
        "0",
        "1",
        "255",
        "256",
        "-1",
        "4294967295",
        "$FFFFFFFF",
        "\n",
        "\r\n",
        " ",
        "#include TMCLParam.tmc\n",
        "#include x\n",
        "APMaxAcceleration",
        "// c",
        "; c",
        "//! module: 1640\n",
        "é",
    ];
    prop::collection::vec(prop::sample::select(words.to_vec()), 0..60).prop_map(|words| words.join(" "))
}

fn holds_together(bytes: Vec<u8>) -> Result<(), TestCaseError> {
    let root = SourceFile { name: "any".to_owned(), bytes, builtin: false };
    let assembly = assemble(root, None, &mut NoIncludes);
    let program = &assembly.program;
    prop_assert_eq!(program.instructions.len(), program.origins.len());
    prop_assert!(!program.instructions.is_empty());
    for label in &program.labels {
        prop_assert!(usize::from(label.address) <= program.instructions.len());
    }
    let places: Vec<_> = assembly.diagnostics.iter().map(|diagnostic| diagnostic.primary.span).collect();
    prop_assert!(places.is_sorted_by_key(|span| (span.file, span.start)));
    for span in places.iter().chain(&program.origins) {
        let file = assembly.sources.get(span.file);
        prop_assert!(
            file.is_some_and(|file| span.start <= span.end && span.end as usize <= file.bytes.len())
        );
    }
    Ok(())
}

proptest! {
    #[test]
    fn any_bytes_are_assembled_or_complained_about(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        holds_together(bytes)?;
    }

    #[test]
    fn any_words_are_assembled_or_complained_about(text in soup()) {
        holds_together(text.into_bytes())?;
    }

    #[test]
    fn valid_text_assembles_to_its_instructions(lines in prop::collection::vec(line(), 1..30)) {
        let text: Vec<&str> = lines.iter().map(|line| line.text.as_str()).collect();
        let assembly = alone(&format!("{}\n", text.join("\n")));
        prop_assert_eq!(render(&assembly), "");
        let expected: Vec<Instruction> = lines.iter().map(|line| line.expected).collect();
        prop_assert_eq!(written(&assembly), expected);
    }

    /// A constant, a label and a number of the same value are the same.
    #[test]
    fn names_stand_for_their_values(value in any::<i32>(), before in 0_usize..20) {
        let text = format!("{}Here: X = {value}\nCOMP X\nCOMP {value}\nJA Here\nJA {before}\n", "MST 0\n".repeat(before));
        let assembly = alone(&text);
        prop_assert_eq!(codes(&assembly), [""; 0]);
        let instructions = written(&assembly).split_off(before);
        prop_assert_eq!(instructions[0], instructions[1]);
        prop_assert_eq!(instructions[2], instructions[3]);
    }
}
