//! The interpreter knows the types of flow control and arithmetic by number; here they are held against the tables.

use tmcl_tables::Command;

fn ids(command: Command) -> Vec<(u8, &'static str)> {
    command.spec().types.iter().map(|named| (named.value, named.id)).collect()
}

fn numbered<const N: usize>(ids: [&'static str; N]) -> Vec<(u8, &'static str)> {
    (0..).zip(ids).collect()
}

#[test]
fn the_numbers_are_those_of_the_tables() {
    let arithmetic = ["add", "subtract", "multiply", "divide", "modulo", "and", "or", "xor", "not", "load"];
    assert_eq!(ids(Command::Calculate), numbered(arithmetic));
    assert_eq!(ids(Command::CalculateX), [&numbered(arithmetic)[..], &[(10, "swap")]].concat());
    let comparisons =
        ["zero", "not_zero", "equal", "not_equal", "greater", "greater_or_equal", "less", "less_or_equal"];
    let errors = ["timeout_error", "external_alarm", "deviation_error", "position_error", "shutdown_error"];
    let conditions: Vec<_> = (0..).zip(comparisons.into_iter().chain(errors)).collect();
    assert_eq!(ids(Command::JumpConditional), conditions);
    let flags: Vec<_> = (0..).zip(["all"].into_iter().chain(errors)).collect();
    assert_eq!(ids(Command::ClearErrorFlags), flags);
    let waits = ["ticks", "position", "reference_switch", "limit_switch", "reference_search"];
    assert_eq!(ids(Command::Wait), numbered(waits));
    assert_eq!(ids(Command::ReferenceSearch), numbered(["start", "stop", "status"]));
}
