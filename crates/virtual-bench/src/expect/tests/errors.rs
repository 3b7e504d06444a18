//! What is said about wrong texts, word for word.

use insta::assert_snapshot;

use super::super::Expectation;
use super::{one, two};
use crate::Bench;

fn reports(bench: &Bench, texts: &[&str]) -> String {
    let report = |text: &&str| match Expectation::parse(text, bench) {
        Ok(expectation) => panic!("{expectation:?}"),
        Err(error) => error.report(text),
    };
    texts.iter().map(report).collect::<Vec<_>>().join("\n\n")
}

#[test]
fn quantities() {
    let texts = [
        "",
        "  never ",
        "actual_positon == 3",
        "always output.9 == 1",
        "clear_i2t_flag == 1",
        "3 == actual_position",
        "never at end",
        "abs(position_error) < 3",
        "actual_position == target_positon",
    ];
    assert_snapshot!(reports(&one(), &texts));
}

#[test]
fn modules() {
    let texts = ["output.3 rises", "lift-2.output.3 rises", "door.outputs.3 rises"];
    assert_snapshot!(reports(&two(), &texts));
}

#[test]
fn comparisons() {
    let texts = [
        "actual_position",
        "actual_position = 3",
        "actual_position ! = 3",
        "actual_position == ",
        "actual_position == 3x",
        "actual_position == 1e999",
        "actual_position == 3 and",
        "actual_position == 3 and output.3 rises",
        "actual_position == 3 & 1",
        "actual_position == 3 or output.3 == 1",
        "ramp_mode == speed",
        "physical.torque_nm & 1",
        "status_word & ",
        "status_word & -1",
        "status_word & 0x1FFFFFFFF == 1",
        "actual_position < 3 +- 1",
        "actual_position == 3 ± -1",
        "actual_position == 3 +- ",
        "output.3 rises falls",
    ];
    assert_snapshot!(reports(&one(), &texts));
}

#[test]
fn timings() {
    let texts = [
        "output.3 == 1 within",
        "output.3 == 1 within 2",
        "output.3 == 1 within two s",
        "output.3 == 1 within -1s",
        "output.3 == 1 within 1e9s",
        "output.3 == 1 within end",
        "output.3 == 1 within 1 s within 2 s",
        "output.3 == 1 at end for 1s",
        "output.3 == 1 within 1s at 2s",
        "output.3 == 1 after 2s within 1s",
        "output.3 == 1 for 2s within 1s",
        "output.3 == 1 soon",
        "output.3 rises at 1s",
        "output.3 rises for 1s",
        "always output.3 rises",
        "never output.3 == 1 at end",
        "always output.3 == 1 for 1s",
    ];
    assert_snapshot!(reports(&one(), &texts));
}

/// Marks stand below characters, not bytes.
#[test]
fn marks() {
    assert_snapshot!(reports(&one(), &["\tµ == 3", "output.3 == 1 within 3µs2", "output.3\n== ±"]));
}
