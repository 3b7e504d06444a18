//! The manuals' listings: what they deserve, and no more.

use super::builder::codes;

#[test]
fn the_first_program() {
    // TMCM-1311 §3.3.2.
    let text = "ROL 0, 50000\nWAIT TICKS, 0, 500\nMST 0\nROR 0, 50000\nWAIT TICKS, 0, 500\nMST 0\nSAP 4, 0, 50000\n\
                SAP 5, 0, 50000\nLoop: MVP ABS, 0, 10000\nWAIT POS, 0, 0\nMVP ABS, 0, -100000\nWAIT POS, 0, 0\nJA Loop\n";
    assert_eq!(codes(text), [""; 0]);
}

#[test]
fn the_timer_interrupt() {
    // TMCM-1311 §5.6.5.
    let text = "VECT 0, TimeroIrq\nSGP 0, 3, 1000\nEI 0\nEI 255\nLoop:\nSIO 3, 2, 1\nWAIT TICKS, 0, 50\nSIO 3, 2, 0\n\
                WAIT TICKS, 0, 50\nJA Loop\nTimeroIrq:\nGIO 0, 2\nJC NZ, OutoOff\nSIO 0, 2, 1\nRETI\nOutoOff:\n\
                SIO 0, 2, 0\nRETI\n";
    assert_eq!(codes(text), [""; 0]);
}

#[test]
fn closed_loop_with_a_stop_behind_the_loop() {
    // TMCM-1311 §8.11.1.
    let text = "SAP 129, 0, 1\nClWait: GAP 133, 0\nJC ZE, ClWait\nLoop: MVP ABS, 0, 512000\nWAIT POS, 0, 0\n\
                WAIT TICKS, 0, 100\nMVP ABS, 0, 0\nWAIT POS, 0, 0\nWAIT TICKS, 0, 100\nJA Loop\nSTOP\n";
    assert_eq!(codes(text), ["W0001"]);
}

#[test]
fn position_interrupts_that_take_turns() {
    // TMCM-1311 §8.11.2.
    let text = "SAP 6, 0, 128\nSAP 132, 0, 1\nDetect: GAP 132, 0\nCOMP 2\nJC NE, Detect\nSAP 129, 0, 1\n\
                Init: GAP 133, 0\nJC ZE, Init\nVECT 3, PosReached1\nEI 3\nEI 255\nMVP ABS, 0, 51200\n\
                Loop: WAIT TICKS, 0, 1000\nJA Loop\nPosReached1: VECT 3, PosReached2\nMVP ABS, 0, 0\nRETI\n\
                PosReached2: VECT 3, PosReached1\nMVP ABS, 0, 51200\nRETI\n";
    assert_eq!(codes(text), [""; 0]);
}

#[test]
fn three_routines_for_a_host() {
    // TMCM-1311 §11.6.
    let text = "Func1: JA Func1Start\nFunc2: JA Func2Start\nFunc3: JA Func3Start\nFunc1Start: MVP ABS, 0, 1000\n\
                WAIT POS, 0, 0\nMVP ABS, 0, 0\nWAIT POS, 0, 0\nSTOP\nFunc2Start: ROL 0, 500\nWAIT TICKS, 0, 100\n\
                MST 0\nSTOP\nFunc3Start:\nROR 0, 1000\nWAIT TICKS, 0, 700\nMST 0\nSTOP\n";
    assert_eq!(codes(text), [""; 0]);
}

#[test]
fn outputs_that_follow_inputs() {
    // TMCM-1311 §5.7.14.
    assert_eq!(codes("Loop: GIO 255, 0\nSIO 255, 2, -1\nJA Loop\n"), [""; 0]);
}

#[test]
fn a_subroutine() {
    // TMCM-1311 §5.7.20.
    let text = "Loop: MVP ABS, 0, 10000\nCSUB SubW\nMVP ABS, 0, 0\nJA Loop\nSubW: WAIT POS, 0, 0\nWAIT TICKS, 0, 50\nRSUB\n";
    assert_eq!(codes(text), [""; 0]);
}
