//! What the parts of an expectation are read as.

use tmcl_tables::tmcm_1311::AxisParameter;

use super::super::Expectation;
use super::super::condition::{Comparison, Condition, Edge, Operand, Reference, Relation};
use super::super::expectation::{Rule, Timing, Window};
use super::{one, two};
use crate::{Bench, ModuleId, Probe, Quantity};

const WHOLE_RUN: Timing = Timing::During(Window { after_ns: 0, within_ns: None, hold_ns: 0 });

const STATUS_WORD: Quantity = Quantity::Parameter(AxisParameter::StatusWord.number());
const POSITION: Quantity = Quantity::Parameter(AxisParameter::ActualPosition.number());

fn read_on(text: &str, bench: &Bench) -> (Rule, Condition, Timing) {
    match Expectation::parse(text, bench) {
        Ok(expectation) => {
            assert_eq!(expectation.text(), text.trim());
            (expectation.rule, expectation.condition, expectation.timing)
        }
        Err(error) => panic!("{}", error.report(text)),
    }
}

fn read(text: &str) -> (Rule, Condition, Timing) {
    read_on(text, &one())
}

fn timing(clauses: &str) -> Timing {
    read(&format!("actual_velocity == 0 {clauses}")).2
}

fn operand(name: &str, quantity: Quantity, mask: Option<u32>) -> Operand {
    Operand { name: name.to_owned(), probe: Probe { module: ModuleId(0), quantity }, mask }
}

fn comparison(text: &str) -> Comparison {
    match read(text) {
        (Rule::Eventually, Condition::Comparisons(comparisons), WHOLE_RUN) if comparisons.len() == 1 => {
            comparisons[0].clone()
        }
        other => panic!("{text} is {other:?}"),
    }
}

#[test]
fn a_quantity_against_a_number() {
    let left = operand("actual_position", POSITION, None);
    for (symbol, relation) in [
        ("==", Relation::Equal),
        ("!=", Relation::NotEqual),
        ("<", Relation::Less),
        ("<=", Relation::AtMost),
        (">", Relation::Greater),
        (">=", Relation::AtLeast),
    ] {
        let right = Reference::Number(-200.0);
        let wanted = Comparison { left: left.clone(), relation, right, tolerance: 0.0 };
        for text in [
            "actual_position @ -200",
            "actual_position@-200",
            " actual_position  @ -2e2 ",
            "actual_position@ -0xC8",
        ] {
            assert_eq!(comparison(&text.replace('@', symbol)), wanted, "{text}");
        }
    }
}

#[test]
fn masks() {
    let left = operand("status_word", STATUS_WORD, Some(0x200));
    let zero = Reference::Number(0.0);
    let any = Comparison { left: left.clone(), relation: Relation::NotEqual, right: zero, tolerance: 0.0 };
    for text in ["status_word & 0x200", "status_word&$200", "status_word & 512"] {
        assert_eq!(comparison(text), any, "{text}");
    }
    let all = Comparison { left, relation: Relation::Equal, right: Reference::Number(512.0), tolerance: 0.0 };
    assert_eq!(comparison("status_word & 0x200 == 0x200"), all);
    let right = operand("status_word", STATUS_WORD, Some(4));
    assert_eq!(comparison("status_word & 0x200 == status_word & 4").right, Reference::Operand(right));
}

#[test]
fn two_quantities_and_tolerances() {
    for text in [
        "encoder_counter == actual_position +- 2",
        "encoder_counter == actual_position ± 2",
        "encoder_counter==actual_position+/-2",
    ] {
        let Comparison { right, tolerance, .. } = comparison(text);
        let actual_position = operand("actual_position", POSITION, None);
        assert_eq!((right, tolerance), (Reference::Operand(actual_position), 2.0), "{text}");
    }
    assert_eq!(comparison("physical.rotor_turns != 1 +- 0.5").tolerance, 0.5);
}

#[test]
fn values_by_name() {
    let named = comparison("ramp_mode == velocity").right;
    assert_eq!(named, comparison("ramp_mode == 1").right);
    assert_eq!(comparison("application_status == run").right, Reference::Number(1.0));
    // Not with a mask: some bits of a value are another value.
    assert!(Expectation::parse("ramp_mode & 1 == velocity", &one()).is_err());
}

#[test]
fn edges_and_rules() {
    let output = || operand("output.3", Quantity::Port(2, 3), None);
    for (word, edge) in [("rises", Edge::Rises), ("falls", Edge::Falls), ("changes", Edge::Changes)] {
        let wanted = Condition::Edge(output(), edge);
        assert_eq!(read(&format!("output.3 {word}")), (Rule::Eventually, wanted.clone(), WHOLE_RUN));
        assert_eq!(read(&format!("never output.3 {word}")), (Rule::Never, wanted, WHOLE_RUN));
    }
    let bit = operand("status_word", STATUS_WORD, Some(1));
    assert_eq!(read("status_word & 1 rises").1, Condition::Edge(bit, Edge::Rises));
    assert_eq!(read("always output.3 == 0").0, Rule::Always);
}

#[test]
fn several_comparisons() {
    let (_, condition, _) = read("output.3 == 1 and status_word & 2 and variable.7 < variable.8 within 1s");
    let Condition::Comparisons(comparisons) = condition else { panic!("{condition:?}") };
    let quantities: Vec<_> = comparisons.iter().map(|comparison| comparison.left.probe.quantity).collect();
    assert_eq!(quantities, [Quantity::Port(2, 3), STATUS_WORD, Quantity::Global(2, 7)]);
}

#[test]
fn timings() {
    let window = |after_ns, within_ns, hold_ns| Timing::During(Window { after_ns, within_ns, hold_ns });
    assert_eq!(timing(""), WHOLE_RUN);
    assert_eq!(timing("within 2s"), window(0, Some(2_000_000_000), 0));
    assert_eq!(timing("within 2 s"), window(0, Some(2_000_000_000), 0));
    assert_eq!(timing("for 100ms within 3s"), window(0, Some(3_000_000_000), 100_000_000));
    assert_eq!(timing("within 3s for 100 ms"), timing("for 100ms within 3s"));
    assert_eq!(timing("after 500us for 1ms within 1.5ms"), window(500_000, Some(1_500_000), 1_000_000));
    assert_eq!(timing("at 2min"), Timing::At(120_000_000_000));
    assert_eq!(timing("at end"), Timing::AtEnd);
    assert_eq!(read("output.3 rises after 1s within 2s").2, window(1_000_000_000, Some(2_000_000_000), 0));
    let never = read("never actual_velocity == 0 for 1ms after 1s");
    assert_eq!((never.0, never.2), (Rule::Never, window(1_000_000_000, None, 1_000_000)));
}

#[test]
fn modules_by_name() {
    let (_, condition, _) =
        read_on("lift-1.output.0 == 1 and door.actual_position == lift-1.actual_position", &two());
    let Condition::Comparisons(comparisons) = condition else { panic!("{condition:?}") };
    let modules: Vec<_> = comparisons.iter().map(|comparison| comparison.left.probe.module).collect();
    assert_eq!(modules, [ModuleId(0), ModuleId(1)]);
}

/// No quantity is called by a word of the grammar, on any module.
#[test]
fn keywords_are_no_quantities() {
    for spec in tmcl_tables::MODULES {
        let globals = spec.global_parameters.iter().map(|entry| entry.parameter.id);
        for id in spec.axis_parameters.iter().map(|parameter| parameter.id).chain(globals) {
            assert!(!super::super::parser::KEYWORDS.contains(&id), "{id}");
        }
    }
}

/// The examples in the documentation.
#[test]
fn documented_examples_are_read() {
    let page = include_str!("../../../../../docs/expectations.md");
    let block = page.split("```").nth(1).expect("a block of examples");
    let examples: Vec<_> = block.lines().filter_map(|line| line.split_once("   ")).collect();
    assert_eq!(examples.len(), block.trim().lines().count(), "each has an explanation");
    for (example, _) in examples {
        read(example);
    }
}
