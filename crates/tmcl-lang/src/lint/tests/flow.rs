//! Rules about flow outside interrupts.

use super::builder::{codes, program, readable};
use crate::lint::lint;

#[test]
fn what_is_never_reached() {
    insta::assert_snapshot!(readable("Loop: MST 0\nJA Loop\nMST 0\nDead: ROR 0, 5\nJA Dead"), @r#"
    W0001: 3 instructions are never reached
      3:1 `MST 0`: from here, address 2
      5:1 `JA Dead`: to here
      2:1 `JA Loop`: the program goes on at `Loop`
      note: a host can start a program at any address (command 129, TMCM-1311 §11.6); JA instructions at the top of the program are taken for such starts
    "#);
    assert_eq!(codes("Loop: JA Loop\nMST 0"), ["W0001"]);
}

#[test]
fn the_appended_stop_is_no_dead_code() {
    assert_eq!(codes("CSUB Sub\nSTOP\nSub: GIO 0, 0\nJC ZE, Sub\nRSUB"), [""; 0]);
    // Not the assembler's STOP alone, but what stands before it.
    insta::assert_snapshot!(readable("Loop: MST 0\nJC ZE, Loop\nJA Loop\nMST 0"), @r#"
    W0001: this instruction is never reached
      4:1 `MST 0`: 
      3:1 `JA Loop`: the program goes on at `Loop`
      note: a host can start a program at any address (command 129, TMCM-1311 §11.6); JA instructions at the top of the program are taken for such starts
    "#);
}

#[test]
fn behind_a_subroutine_that_never_returns() {
    insta::assert_snapshot!(readable("CSUB Run\nMST 0\nSTOP\nRun: WAIT TICKS, 0, 1\nJA Run"), @r#"
    W0001: 2 instructions are never reached
      2:1 `MST 0`: from here, address 1
      3:1 `STOP`: to here
      1:1 `CSUB Run`: `Run` never returns
      note: a host can start a program at any address (command 129, TMCM-1311 §11.6); JA instructions at the top of the program are taken for such starts
    "#);
}

#[test]
fn behind_a_subroutine_that_may_return() {
    assert_eq!(codes("CSUB Run\nMST 0\nSTOP\nRun: GIO 0, 0\nJC ZE, Run\nRSUB"), [""; 0]);
    let through_another = "CSUB Outer\nMST 0\nSTOP\nOuter: CSUB Inner\nJA End\nInner: RSUB\nEnd: RSUB";
    assert_eq!(codes(through_another), [""; 0]);
}

#[test]
fn tables_of_jumps_need_no_labels() {
    assert_eq!(codes("JA One\nJA Two\nOne: STOP\nTwo: STOP"), [""; 0]);
}

#[test]
fn a_subroutine_that_the_program_runs_into() {
    insta::assert_snapshot!(readable("CSUB Sub\nMST 0\nSub: WAIT TICKS, 0, 1\nRSUB"), @r#"
    W0002: the program can run past its last instruction
      4:1 `RSUB`: where this is ignored, the program goes on behind it
      note: behind the program lies what the program memory held before; erased memory reads as STOP
      note: end the program with STOP, or go back with JA
    W0006: RSUB can be reached without a CSUB
      4:1 `RSUB`: ignored when no call is open
      2:1 `MST 0`: from here the program runs on into the subroutine `Sub`
      note: the module then goes on with the next instruction
    "#);
}

#[test]
fn only_the_first_of_returns_that_follow_from_one_another() {
    assert_eq!(codes("CSUB One\nCSUB Two\nOne: MST 0\nRSUB\nTwo: MST 0\nRSUB\n"), ["W0006", "W0002"]);
}

#[test]
fn what_follows_an_ignored_return_is_reached() {
    assert_eq!(codes("MST 0\nRSUB\nROR 0, 5\nSTOP"), ["W0006"]);
    assert_eq!(codes("MST 0\nRETI\nROR 0, 5\nSTOP"), ["W0005"]);
}

#[test]
fn without_a_stop_the_program_runs_off() {
    let (mut program, sources) = program("MST 0\nROR 0, 5");
    program.instructions.pop();
    program.origins.pop();
    program.appended_stop = false;
    let found = lint(&program, &sources);
    assert_eq!(found.len(), 1);
    insta::assert_debug_snapshot!(found[0], @r#"
    Diagnostic {
        code: RunsOff,
        message: "the program can run past its last instruction",
        primary: Label {
            span: Span {
                file: FileId(
                    0,
                ),
                start: 6,
                end: 14,
            },
            text: "the program goes on behind this",
        },
        secondary: [],
        notes: [
            "behind the program lies what the program memory held before; erased memory reads as STOP",
            "end the program with STOP, or go back with JA",
        ],
        suggestion: None,
    }
    "#);
}

/// A program whose calls nest `depth` deep.
fn nested(depth: usize) -> String {
    let mut text = String::from("CSUB S1\nSTOP\n");
    for level in 1..depth {
        text += &format!("S{level}: CSUB S{}\nRSUB\n", level + 1);
    }
    text + &format!("S{depth}: MST 0\nRSUB\n")
}

#[test]
fn eight_calls_may_be_open_but_not_nine() {
    assert_eq!(codes(&nested(8)), [""; 0]);
    assert_eq!(codes(&nested(9)), ["W0003"]);
    assert_eq!(codes(&nested(12)), ["W0003"], "what is deeper follows from the ninth");
    insta::assert_snapshot!(readable(&nested(9)), @r#"
    W0003: calls can nest 9 deep here; the module keeps 8
      17:5 `CSUB S9`: `S9` is not called when 8 calls are open
      1:1 `CSUB S1`: call 1
      3:5 `CSUB S2`: call 2
      5:5 `CSUB S3`: call 3
      7:5 `CSUB S4`: call 4
      9:5 `CSUB S5`: call 5
      11:5 `CSUB S6`: call 6
      13:5 `CSUB S7`: call 7
      15:5 `CSUB S8`: call 8
      note: the module keeps 8 calls (TMCM-1311 §11.5): a CSUB beyond that is ignored, and the program goes on behind it
    "#);
}

#[test]
fn calls_one_after_the_other_do_not_nest() {
    let text = "CSUB A\n".repeat(20) + "STOP\nA: CSUB B\nCSUB B\nRSUB\nB: RSUB\n";
    assert_eq!(codes(&text), [""; 0]);
}

#[test]
fn subroutines_that_call_themselves() {
    insta::assert_snapshot!(readable("CSUB Sub\nSTOP\nSub: GIO 0, 0\nJC ZE, End\nCSUB Sub\nEnd: RSUB"), @r#"
    W0004: `Sub` can call itself
      5:1 `CSUB Sub`: `Sub` may not have returned yet
      note: the module keeps 8 calls (TMCM-1311 §11.5): a CSUB beyond that is ignored, and the program goes on behind it
    "#);
    insta::assert_snapshot!(readable("CSUB A\nSTOP\nA: CSUB B\nRSUB\nB: MST 0\nCSUB C\nRSUB\nC: CSUB A\nRSUB"), @r#"
    W0004: `B` can call `C`, which can call `A`, which can call `B`
      3:4 `CSUB B`: `B` may not have returned yet
      6:1 `CSUB C`: `C` is called here
      8:4 `CSUB A`: `A` is called here
      note: the module keeps 8 calls (TMCM-1311 §11.5): a CSUB beyond that is ignored, and the program goes on behind it
    "#);
}

#[test]
fn a_subroutine_that_goes_back_to_the_main_loop_calls_itself() {
    assert_eq!(codes("Loop: CSUB Sub\nJA Loop\nSub: GIO 0, 0\nJC ZE, Loop\nRSUB"), ["W0004"]);
}

#[test]
fn what_follows_a_call_that_recursion_makes_ignored_is_reached() {
    assert_eq!(codes("CSUB Sub\nMST 0\nSTOP\nSub: CSUB Sub\nRSUB"), ["W0004"]);
}

#[test]
fn unreached_calls_neither_nest_nor_recur() {
    assert_eq!(codes("Loop: JA Loop\nSub: CSUB Sub\nRSUB"), ["W0001"]);
}
