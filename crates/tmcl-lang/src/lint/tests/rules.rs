//! Rules about single instructions and names.

use crate::code::Code;
use crate::program::ConstantDefinition;
use crate::source::{SourceFile, Sources, Span};

use super::builder::{codes, findings, program, readable};
use crate::lint::lint;

#[test]
fn a_division_by_a_constant_zero() {
    insta::assert_snapshot!(readable("CALC DIV, 0\nCALC MOD, 0\nCALC ADD, 0\nCALC DIV, 1"), @r#"
    W0009: division by zero
      1:1 `CALC DIV, 0`: 
      note: the module has no error for it: the accumulator becomes 0
    W0009: remainder of a division by zero
      2:1 `CALC MOD, 0`: 
      note: the module has no error for it: the accumulator stays as it is
    "#);
}

#[test]
fn x_is_followed_along_a_straight_line_only() {
    insta::assert_snapshot!(readable("CALC LOAD, 0\nCALCX LOAD\nGAP 1, 0\nCALCX DIV"), @r#"
    W0009: division by zero
      4:1 `CALCX DIV`: X is 0 here
      1:1 `CALC LOAD, 0`: 0 is loaded here
      note: the module has no error for it: the accumulator becomes 0
    "#);
    assert_eq!(codes("CALC LOAD, 0\nCALCX SWAP\nGAP 1, 0\nCALCX MOD"), ["W0009"]);
    assert_eq!(codes("CALC LOAD, 5\nCALCX LOAD\nCALCX DIV"), [""; 0]);
    assert_eq!(codes("CALC LOAD, 0\nCALCX LOAD\nCALCX NOT\nCALCX DIV"), [""; 0]);
    assert_eq!(codes("CALC LOAD, 0\nGAP 1, 0\nCALCX LOAD\nCALCX DIV"), [""; 0]);
    let jumped_into = "CALC LOAD, 0\nCALCX LOAD\nHere: CALCX DIV\nCALC LOAD, 2\nCALCX LOAD\nJA Here";
    assert_eq!(codes(jumped_into), [""; 0]);
    let after_a_call =
        "CALC LOAD, 0\nCALCX LOAD\nCSUB Two\nCALCX DIV\nSTOP\nTwo: CALC LOAD, 2\nCALCX LOAD\nRSUB";
    assert_eq!(codes(after_a_call), [""; 0]);
}

#[test]
fn a_wait_without_a_timeout_is_off_by_default() {
    let text = "WAIT POS, 0, 0\nWAIT LIMSW, 0, 100\nWAIT TICKS, 0, 0";
    insta::assert_snapshot!(readable(text), @r#"
    W0010: WAIT POS has no timeout
      1:1 `WAIT POS, 0, 0`: the program stands here for as long as it takes, even for ever
      note: the value is a timeout in ticks of 10 ms, 0 for none; JC ETO tells whether it ran out (TMCM-1311 §5.7.22)
    "#);
    assert_eq!(codes(text), [""; 0]);
}

#[test]
fn jumps_beyond_the_program() {
    insta::assert_snapshot!(readable("JC ZE, 5\nCSUB -1\nVECT 0, 40\nJA 2048"), @r#"
    W0013: JC names address 5, where the program has no instruction
      1:1 `JC ZE, 5`: the last instruction is at address 3
      note: erased program memory reads as STOP: there the program ends
    W0013: CSUB names address -1, where the program has no instruction
      2:1 `CSUB -1`: the last instruction is at address 3
      note: the program memory ends at address 2047; the module skips this CSUB
    W0013: VECT names address 40, where the program has no instruction
      3:1 `VECT 0, 40`: the last instruction is at address 3
      note: erased program memory reads as STOP: there the interrupt ends the program
    W0002: the program can run past its last instruction
      4:1 `JA 2048`: the program goes on behind this
      note: behind the program lies what the program memory held before; erased memory reads as STOP
      note: end the program with STOP, or go back with JA
    W0013: JA names address 2048, where the program has no instruction
      4:1 `JA 2048`: the last instruction is at address 3
      note: the program memory ends at address 2047; the module skips this JA
    "#);
    assert_eq!(codes("JA 1"), ["W0013"]);
}

#[test]
fn a_label_at_the_end_names_the_appended_stop() {
    assert_eq!(codes("GIO 0, 0\nJC ZE, End\nSIO 0, 2, 1\nEnd:"), [""; 0]);
}

#[test]
fn labels_that_nothing_names() {
    insta::assert_snapshot!(readable("Start: MST 0\nLoop: JA Loop"), @r#"
    W0011: no instruction names the label `Start`
      1:1 `Start`: never used
    "#);
    assert_eq!(codes("Only: JA Start\nStart: STOP"), [""; 0], "for a host, TMCM-1311 §11.6");
}

#[test]
fn names_of_other_files_are_left_alone() {
    let (mut program, mut sources) = program("Start: STOP");
    let included =
        sources.add(SourceFile { name: "a.inc".to_owned(), bytes: b"A = 1".to_vec(), builtin: false });
    let builtin = sources.add(SourceFile { name: "b.inc".to_owned(), bytes: b"L:".to_vec(), builtin: true });
    let constant = |name: &str, file, uses| ConstantDefinition {
        name: name.to_owned(),
        span: Span::new(file, 0..1),
        value: 1,
        uses,
    };
    program.constants.push(constant("Included", included, 0));
    program.constants.push(constant("Used", Sources::ROOT, 1));
    program.constants.push(constant("Unused", Sources::ROOT, 0));
    program.labels[0].span = Span::new(builtin, 0..1);
    let found = lint(&program, &sources);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].code, Code::UnusedConstant);
    assert!(found[0].message.contains("`Unused`"));
}

#[test]
fn findings_are_in_the_order_of_addresses() {
    let text = "A: CALC DIV, 0\nEI 0\nCSUB Sub\nSTOP\nMST 0\nSub: CALC MOD, 0\nRSUB\nB: RSUB";
    let codes: Vec<_> = findings(text).iter().map(|it| it.code.id()).collect();
    assert_eq!(codes, ["W0009", "W0011", "W0007", "W0008", "W0001", "W0009", "W0001", "W0011"]);
}
