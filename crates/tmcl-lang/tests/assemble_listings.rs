//! The program listings of the manuals, as printed.

mod assemble_support;

use assemble_support::{alone, codes, render, written};
use tmcl_lang::Assembly;

macro_rules! listing {
    ($name:literal) => {
        alone(include_str!(concat!("listings/", $name, ".tmc")))
    };
}

const ABS: u8 = 0;
const POS: u8 = 1;
const TICKS: u8 = 0;

fn fields(assembly: &Assembly) -> Vec<(u8, u8, u8, i32)> {
    let instructions = written(assembly);
    instructions.iter().map(|at| (at.command, at.kind, at.motor, at.value)).collect()
}

/// The fields of the instructions of a listing without findings that ends without an appended STOP.
fn complete(assembly: &Assembly) -> Vec<(u8, u8, u8, i32)> {
    assert_eq!(render(assembly), "");
    assert!(!assembly.program.appended_stop);
    assert!(assembly.module_is_named);
    fields(assembly)
}

#[test]
fn the_simple_program() {
    let expected = [
        (2, 0, 0, 50_000),
        (27, TICKS, 0, 500),
        (3, 0, 0, 0),
        (1, 0, 0, 50_000),
        (27, TICKS, 0, 500),
        (3, 0, 0, 0),
        (5, 4, 0, 50_000),
        (5, 5, 0, 50_000),
        (4, ABS, 0, 10_000),
        (27, POS, 0, 0),
        (4, ABS, 0, -100_000),
        (27, POS, 0, 0),
        (22, 0, 0, 8),
    ];
    assert_eq!(complete(&listing!("tmcm_1311_3_3_2")), expected);
}

#[test]
fn the_timer_interrupt_in_both_forms() {
    let expected = [
        (37, 0, 0, 9),
        (9, 0, 3, 1000),
        (25, 0, 0, 0),
        (25, 255, 0, 0),
        (14, 3, 2, 1),
        (27, TICKS, 0, 50),
        (14, 3, 2, 0),
        (27, TICKS, 0, 50),
        (22, 0, 0, 4),
        (15, 0, 2, 0),
        (21, 1, 0, 13),
        (14, 0, 2, 1),
        (38, 0, 0, 0),
        (14, 0, 2, 0),
        (38, 0, 0, 0),
    ];
    assert_eq!(complete(&listing!("tmcm_1311_5_6_5")), expected);
    let by_name = listing!("tmcm_1311_5_6_5_names");
    assert_eq!(complete(&by_name), expected);
    let used: Vec<_> =
        by_name.program.constants.iter().map(|constant| (constant.name.as_str(), constant.uses)).collect();
    assert_eq!(used, [("TI_TIMER0", 3), ("TI_GLOBAL", 1)]);
}

#[test]
fn outputs_follow_inputs() {
    assert_eq!(complete(&listing!("tmcm_1311_5_7_14")), [(15, 255, 0, 0), (14, 255, 2, -1), (22, 0, 0, 0)]);
}

#[test]
fn the_comparison_with_its_slips() {
    let assembly = listing!("tmcm_1311_5_7_17");
    assert_eq!(codes(&assembly), ["E0210", "W0015", "E0105"]);
    assert_eq!(fields(&assembly)[1], (20, 0, 0, 1000));
    let assembly = listing!("tmcm_1640_4_6_15");
    assert_eq!(codes(&assembly), ["W0015", "E0105"]);
    assert_eq!(fields(&assembly), [(6, 1, 0, 0), (20, 0, 0, 1000), (21, 5, 0, 0)]);
}

#[test]
fn the_conditional_jump() {
    for assembly in [listing!("tmcm_1311_5_7_18"), listing!("tmcm_1640_4_6_16")] {
        assert_eq!(codes(&assembly), ["W0015"]);
        assert!(assembly.program.appended_stop);
        assert_eq!(fields(&assembly), [(6, 1, 0, 0), (20, 0, 0, 1000), (21, 5, 0, 3), (2, 0, 0, 1000)]);
    }
}

#[test]
fn the_infinite_loop() {
    let expected = [(4, ABS, 0, 10_000), (27, POS, 0, 0), (4, ABS, 0, 0), (27, POS, 0, 0), (22, 0, 0, 0)];
    assert_eq!(complete(&listing!("tmcm_1311_5_7_19")), expected);
    assert_eq!(complete(&listing!("tmcm_1640_4_6_17")), expected);
}

#[test]
fn the_subroutine() {
    let expected = [
        (4, ABS, 0, 10_000),
        (23, 0, 0, 4),
        (4, ABS, 0, 0),
        (22, 0, 0, 0),
        (27, POS, 0, 0),
        (27, TICKS, 0, 50),
        (24, 0, 0, 0),
    ];
    assert_eq!(complete(&listing!("tmcm_1311_5_7_20")), expected);
    assert_eq!(complete(&listing!("tmcm_1640_4_6_18")), expected);
}

#[test]
fn the_potentiometer() {
    let expected = [(15, 0, 1, 0), (19, 2, 0, 4), (34, 0, 0, 0), (22, 0, 0, 0)];
    assert_eq!(complete(&listing!("tmcm_1311_5_7_29")), expected);
    assert_eq!(complete(&listing!("tmcm_1640_4_6_22")), expected);
}

#[test]
fn closed_loop_example_1() {
    let expected = [
        (5, 6, 0, 128),
        (5, 202, 0, 200),
        (5, 210, 0, 40_000),
        (5, 4, 0, 398_105),
        (5, 5, 0, 3_981_070),
        (5, 126, 0, 1_023_950),
        (5, 129, 0, 1),
        (6, 133, 0, 0),
        (21, 0, 0, 7),
        (4, ABS, 0, 512_000),
        (27, POS, 0, 0),
        (27, TICKS, 0, 100),
        (4, ABS, 0, 0),
        (27, POS, 0, 0),
        (27, TICKS, 0, 100),
        (22, 0, 0, 9),
        (28, 0, 0, 0),
    ];
    assert_eq!(complete(&listing!("tmcm_1311_8_11_1")), expected);
}

#[test]
fn closed_loop_example_2() {
    let expected = [
        (5, 6, 0, 128),
        (5, 132, 0, 1),
        (6, 132, 0, 0),
        (20, 0, 0, 2),
        (21, 3, 0, 2),
        (5, 129, 0, 1),
        (6, 133, 0, 0),
        (21, 0, 0, 6),
        (37, 3, 0, 14),
        (25, 3, 0, 0),
        (25, 255, 0, 0),
        (4, ABS, 0, 51_200),
        (27, TICKS, 0, 1000),
        (22, 0, 0, 12),
        (37, 3, 0, 17),
        (4, ABS, 0, 0),
        (38, 0, 0, 0),
        (37, 3, 0, 14),
        (4, ABS, 0, 51_200),
        (38, 0, 0, 0),
    ];
    assert_eq!(complete(&listing!("tmcm_1311_8_11_2")), expected);
}

#[test]
fn the_main_loop_with_numbers_and_with_names() {
    let expected = [
        (5, 4, 0, 500),
        (5, 5, 0, 100),
        (4, ABS, 0, 5000),
        (27, POS, 0, 0),
        (4, ABS, 0, 0),
        (27, POS, 0, 0),
        (22, 0, 0, 2),
    ];
    assert_eq!(complete(&listing!("tmcm_1311_11_2")), expected);
    assert_eq!(complete(&listing!("tmcm_1311_11_3")), expected);
}

#[test]
fn variables_with_the_slip_and_as_suggested() {
    let assembly = listing!("tmcm_1311_11_4");
    assert_eq!(codes(&assembly), ["E0210"]);
    let suggestion = assembly.diagnostics[0].suggestion.clone().unwrap();
    let mut text = include_str!("listings/tmcm_1311_11_4.tmc").to_owned();
    text.replace_range(suggestion.span.range(), &suggestion.replacement);
    let mended = alone(&text);
    assert_eq!(render(&mended), "");
    assert_eq!(fields(&mended), [(9, 42, 2, 1234), (10, 42, 2, 0), (19, 2, 0, 2), (35, 42, 2, 0)]);
    assert_eq!(mended.program.constants[0].uses, 3);
}

#[test]
fn routines_for_a_host() {
    let assembly = listing!("tmcm_1311_11_6");
    let expected = [
        (22, 0, 0, 3),
        (22, 0, 0, 8),
        (22, 0, 0, 12),
        (4, ABS, 0, 1000),
        (27, POS, 0, 0),
        (4, ABS, 0, 0),
        (27, POS, 0, 0),
        (28, 0, 0, 0),
        (2, 0, 0, 500),
        (27, TICKS, 0, 100),
        (3, 0, 0, 0),
        (28, 0, 0, 0),
        (1, 0, 0, 1000),
        (27, TICKS, 0, 700),
        (3, 0, 0, 0),
        (28, 0, 0, 0),
    ];
    assert_eq!(complete(&assembly), expected);
    let labels: Vec<_> = assembly
        .program
        .labels
        .iter()
        .map(|label| (label.name.as_str(), label.address, label.uses))
        .collect();
    let (entries, starts) = labels.split_at(3);
    assert_eq!(entries, [("Func1", 0, 0), ("Func2", 1, 0), ("Func3", 2, 0)]);
    assert_eq!(starts, [("Func1Start", 3, 1), ("Func2Start", 8, 1), ("Func3Start", 12, 1)]);
}
