//! Timer interrupts, to the control period (TMCM-1311 §5.6.5, §10.4; decisions 2a.17, 3.8).

use crate::common::program::*;
use crate::common::{Module, VARIABLES};
use tmcl_tables::GlobalParameter as Gp;
use tmcl_wire::Request;
use virtual_bench::TICK_NS;

const TIMER_0: u8 = 0;
const TIMER_1: u8 = 1;
const TIMER_2: u8 = 2;

/// Control periods in a millisecond.
const MS: u64 = crate::common::TICKS_PER_MS;

/// A routine of six instructions at `address` that toggles an output.
fn toggle(output: u8, address: i32) -> [Request; 6] {
    [gio(output, 2), jc(kind::NZ, address + 4), sio(output, 1), RETI, sio(output, 0), RETI]
}

/// §5.6.5, to the letter.
fn example() -> Vec<Request> {
    vec![
        vect(0, 9),
        sgp(0, 3, 1000),
        ei(0),
        ei(ALL),
        sio(3, 1),
        wait(kind::TICKS, 50),
        sio(3, 0),
        wait(kind::TICKS, 50),
        ja(4),
        gio(0, 2),
        jc(kind::NZ, 13),
        sio(0, 1),
        RETI,
        sio(0, 0),
        RETI,
    ]
}

/// OUT0 toggles each second, counted from SGP, to the control period; OUT3 each half second and however long the routine
/// takes.
#[test]
fn the_timer_example_of_5_6_5() {
    let mut module = Module::with_program(&example());
    module.run_from(0);
    let from = module.bench.time_ns() / TICK_NS;
    let mut other = module.clone();
    let out_0 = module.edges(0, 6 * 20_000 + 100);
    // SGP ends with the second control period; GIO, JC and SIO follow the timer.
    let expected: Vec<_> = (1..=6).map(|second| (from + 2 + second * 20_000 + 2, second % 2 == 1)).collect();
    assert_eq!(out_0, expected);

    let out_3 = other.edges(3, 6 * 20_000 + 100);
    assert_eq!(out_3[0], (from + 5, true));
    assert!(out_3.len() >= 11);
    for pair in out_3.windows(2) {
        let [(at, level), (next, _)] = pair else { unreachable!() };
        let undisturbed = 50 * WAIT_TICK + if *level { 1 } else { 2 };
        let interrupted = out_0.iter().any(|(irq, _)| (*at..*next).contains(irq));
        // The routine's four instructions, one of which may overlap with the WAIT.
        let allowed = if interrupted { undisturbed + 3..=undisturbed + 4 } else { undisturbed..=undisturbed };
        assert!(allowed.contains(&(next - at)), "{} from {at} to {next}", next - at);
    }
}

#[test]
fn timers_keep_their_beat_to_the_control_period() {
    for (timer, ms) in [(TIMER_0, 1), (TIMER_1, 7), (TIMER_2, 250), (TIMER_1, 1000)] {
        let mut instructions =
            vec![vect(timer, 6), sgp(timer, 3, ms), ei(timer), ei(ALL), wait(kind::TICKS, 100), ja(4)];
        instructions.extend(toggle(0, 6));
        let mut module = Module::with_program(&instructions);
        module.run_from(0);
        let from = module.bench.time_ns() / TICK_NS;
        let period = ms as u64 * MS;
        let edges = module.edges(0, 10 * period + 10);
        let instants: Vec<_> = edges.iter().map(|(at, _)| *at).collect();
        let expected: Vec<_> = (1..=10).map(|beat| from + 2 + beat * period + 2).collect();
        assert_eq!(instants, expected, "timer {timer}, {ms} ms");
    }
}

/// Three at once, in the order of their numbers.
#[test]
fn timers_run_side_by_side() {
    let setup = [sgp(TIMER_2, 3, 3), sgp(TIMER_0, 3, 10), sgp(TIMER_1, 3, 4)];
    let mut module = listening(Module::new(), &[TIMER_0, TIMER_1, TIMER_2], &setup);
    module.run_ms(600 - 1);
    let counted: Vec<_> = (0..3).map(|variable| module.variable(variable)).collect();
    assert_eq!(counted, [59, 149, 199], "the last ones are not over yet");
    module.run_ms(1);
    let counted: Vec<_> = (0..3).map(|variable| module.variable(variable)).collect();
    assert_eq!(counted, [60, 150, 200]);
}

/// SGP restarts the period, 0 ends it; a host may do so too.
#[test]
fn writing_a_period_restarts_it() {
    let mut module = listening(Module::new(), &[TIMER_1], &[sgp(TIMER_1, 3, 100)]);
    module.run_ms(149);
    assert_eq!(module.variable(0), 1);
    module.sgp(Gp::Timer1Period, 100);
    module.run_ms(99);
    assert_eq!(module.variable(0), 1, "200 ms after the first write, but 99 after the second");
    module.run_ms(2);
    assert_eq!(module.variable(0), 2);
    module.sgp(Gp::Timer1Period, 0);
    module.run_ms(1000);
    assert_eq!(module.variable(0), 2, "off");
    module.sgp(Gp::Timer1Period, 30);
    module.run_ms(100);
    assert_eq!(module.variable(0), 5);
    // The longest is 49 days.
    module.sgp(Gp::Timer1Period, -1);
    module.run_ms(10_000);
    assert_eq!((module.variable(0), module.ggp(Gp::Timer1Period)), (5, -1));
}

/// The period counts from SGP, not from EI (decisions 2a.17).
#[test]
fn a_timer_runs_before_it_is_enabled() {
    let mut instructions = vec![
        vect(0, 7),
        sgp(0, 3, 100),
        wait(kind::TICKS, 13),
        ei(0),
        ei(ALL),
        wait(kind::TICKS, 100),
        ja(5),
    ];
    instructions.extend(toggle(0, 7));
    let mut module = Module::with_program(&instructions);
    module.run_from(0);
    let from = module.bench.time_ns() / TICK_NS;
    let edges = module.edges(0, 350 * MS);
    let instants: Vec<_> = edges.iter().map(|(at, _)| *at).collect();
    assert_eq!(instants, [from + 4 + 200 * MS, from + 4 + 300 * MS], "that at 100 ms was nobody's");
}

/// "Events during an interrupt routine stay pending", each once (decisions 2a.17, 3.8).
#[test]
fn a_timer_faster_than_its_routine_is_remembered_once() {
    let instructions = [
        vect(0, 6),
        sgp(0, 3, 3),
        ei(0),
        ei(ALL),
        wait(kind::TICKS, 100),
        ja(4),
        wait(kind::TICKS, 1),
        ggp(0, VARIABLES),
        calc(kind::ADD, 1),
        keep(0),
        RETI,
    ];
    let mut module = Module::with_program(&instructions);
    module.run_from(0);
    module.run_ms(1000);
    // 10 ms and four instructions each, one after the other.
    let runs = module.variable(0);
    assert!((97..=99).contains(&runs), "{runs}");
    module.sgp(Gp::Timer0Period, 0);
    module.run_ms(1000);
    assert!(module.variable(0) <= runs + 2, "one that ran, one that was remembered");
}
