//! Rules about interrupts.

use super::builder::{codes, readable};

const MAIN: &str = "VECT 0, Irq\nEI 0\nEI 255\nLoop: WAIT TICKS, 0, 1\nJA Loop\n";

fn with_routine(routine: &str) -> String {
    format!("{MAIN}{routine}")
}

#[test]
fn interrupts_that_cannot_come() {
    insta::assert_snapshot!(readable("EI 0\nEI 3\nLoop: JA Loop"), @r#"
    W0007: interrupt 0 (Timer 0) is enabled, but has no vector
      1:1 `EI 0`: no VECT 0 in the program
      note: an interrupt without a vector is ignored
    W0008: interrupts are enabled, but never as a whole
      1:1 `EI 0`: interrupt 0 (Timer 0) cannot come
      2:1 `EI 3`: nor can interrupt 3 (Target position reached)
      note: EI 255 switches interrupt processing on (TMCM-1311 §5.6.5)
    W0007: interrupt 3 (Target position reached) is enabled, but has no vector
      2:1 `EI 3`: no VECT 3 in the program
      note: an interrupt without a vector is ignored
    "#);
    assert_eq!(codes("EI 255\nEI 1\nVECT 1, Irq\nLoop: JA Loop\nIrq: RETI"), [""; 0]);
    assert_eq!(codes("EI 255\nLoop: JA Loop"), [""; 0]);
}

#[test]
fn reti_outside() {
    insta::assert_snapshot!(readable("VECT 0, Irq\nEI 0\nEI 255\nWAIT TICKS, 0, 100\nIrq: MST 0\nRETI"), @r#"
    W0002: the program can run past its last instruction
      6:1 `RETI`: where this is ignored, the program goes on behind it
      note: behind the program lies what the program memory held before; erased memory reads as STOP
      note: end the program with STOP, or go back with JA
    W0005: RETI can be reached outside an interrupt routine
      6:1 `RETI`: ignored when no interrupt is being handled
      4:1 `WAIT TICKS, 0, 100`: from here the program runs on into the interrupt routine `Irq`
      note: the module then goes on with the next instruction
    "#);
    insta::assert_snapshot!(readable("CSUB Irq\nVECT 0, Irq\nEI 0\nEI 255\nSTOP\nIrq: MST 0\nRETI"), @r#"
    W0002: the program can run past its last instruction
      7:1 `RETI`: where this is ignored, the program goes on behind it
      note: behind the program lies what the program memory held before; erased memory reads as STOP
      note: end the program with STOP, or go back with JA
    W0005: RETI can be reached outside an interrupt routine
      7:1 `RETI`: ignored when no interrupt is being handled
      1:1 `CSUB Irq`: the interrupt routine is called as a subroutine here
      note: the module then goes on with the next instruction
    "#);
}

#[test]
fn routines_that_end_wrongly() {
    insta::assert_snapshot!(readable(&with_routine("Irq: MST 0\nRSUB\n")), @r#"
    W0002: the program can run past its last instruction
      7:1 `RSUB`: where this is ignored, the program goes on behind it
      note: behind the program lies what the program memory held before; erased memory reads as STOP
      note: end the program with STOP, or go back with JA
    W0016: an interrupt routine can end with RSUB
      7:1 `RSUB`: RETI is what ends an interrupt routine
      1:1 `VECT 0, Irq`: the interrupt routine is named here
      note: RSUB takes the way back of a subroutine that the interrupt came upon, and is ignored where there is none
      note: until a RETI the interrupt is not over: no other one comes, and accumulator, X and flags are not restored
    "#);
    insta::assert_snapshot!(readable(&with_routine("Irq: MST 0\nSTOP\n")), @r#"
    W0016: an interrupt routine can end with STOP
      7:1 `STOP`: the whole program ends here
      1:1 `VECT 0, Irq`: the interrupt routine is named here
      note: RETI ends an interrupt routine; STOP ends the program and all that it was doing
    "#);
    insta::assert_snapshot!(readable(&with_routine("Irq: MST 0\nROR 0, 5\n")), @r#"
    W0016: an interrupt routine can run to the end of the program
      7:1 `ROR 0, 5`: the program ends behind this
      1:1 `VECT 0, Irq`: the interrupt routine is named here
      note: RETI ends an interrupt routine; STOP ends the program and all that it was doing
    "#);
    insta::assert_snapshot!(readable(&with_routine("Irq: MST 0\nHere: JA Here\n")), @r#"
    W0016: the interrupt routine `Irq` never returns
      6:6 `MST 0`: no RETI can be reached from here
      1:1 `VECT 0, Irq`: it becomes an interrupt routine here
      note: until a RETI the interrupt is not over: no other one comes, and the program does not go on
    "#);
}

#[test]
fn a_routine_that_goes_back_to_the_main_loop_never_returns() {
    assert_eq!(codes(&with_routine("Irq: MST 0\nJA Loop\n")), ["W0016"]);
}

#[test]
fn routines_that_end_well() {
    assert_eq!(codes(&with_routine("Irq: CSUB Sub\nRETI\nSub: MST 0\nRSUB\n")), [""; 0]);
    assert_eq!(codes(&with_routine("Irq: GIO 0, 0\nJC ZE, Irq\nRETI\n")), [""; 0]);
}

#[test]
fn a_routine_that_ends_in_its_subroutine_leaves_an_address_behind() {
    let routine = "Irq: CSUB Sub\nRETI\nSub: GIO 0, 0\nJC ZE, Out\nRSUB\nOut: RETI\n";
    insta::assert_snapshot!(readable(&with_routine(routine)), @r#"
    W0016: RETI can be reached in a subroutine of an interrupt routine
      11:6 `RETI`: the interrupt ends here, but the subroutine has not returned
      1:1 `VECT 0, Irq`: the interrupt routine is named here
      note: its return address stays on the stack; when 8 have gathered there, every CSUB is ignored
    "#);
}

#[test]
fn a_subroutine_of_both_may_be_shared() {
    let text = "VECT 0, Irq\nEI 0\nEI 255\nLoop: CSUB Sub\nJA Loop\nIrq: CSUB Sub\nRETI\nSub: MST 0\nRSUB\n";
    assert_eq!(codes(text), [""; 0]);
}

/// Main flow nests `main` deep and the interrupt routine `interrupt` deep.
fn nested(main: usize, interrupt: usize) -> String {
    let mut text = String::from("VECT 0, Irq\nEI 0\nEI 255\nCSUB M1\nSTOP\nIrq: CSUB I1\nRETI\n");
    for (letter, depth) in [('M', main), ('I', interrupt)] {
        for level in 1..depth {
            text += &format!("{letter}{level}: CSUB {letter}{}\nRSUB\n", level + 1);
        }
        text += &format!("{letter}{depth}: RSUB\n");
    }
    text
}

#[test]
fn an_interrupt_routine_shares_the_stack() {
    assert_eq!(codes(&nested(5, 3)), [""; 0]);
    assert_eq!(codes(&nested(5, 4)), ["W0003"]);
    insta::assert_snapshot!(readable(&nested(7, 2)), @r#"
    W0003: calls can nest 9 deep in this interrupt routine; the module keeps 8
      21:5 `CSUB I2`: `I2` is not called when 8 calls are open
      6:6 `CSUB I1`: this call is open
      note: the program can have 7 calls open when the interrupt comes, and shares its stack with it
      note: the module keeps 8 calls (TMCM-1311 §11.5): a CSUB beyond that is ignored, and the program goes on behind it
    "#);
}

#[test]
fn a_module_without_interrupts_skips_their_commands() {
    let (mut program, sources) = super::builder::program("EI 0\nRETI\nSTOP");
    program.module = &tmcl_tables::tmcm_1640::SPEC;
    assert_eq!(crate::lint::lint(&program, &sources), []);
}
