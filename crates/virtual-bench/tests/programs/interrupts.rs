//! Interrupts of inputs, stop switches and arrivals: what raises them, when, and in which order (TMCM-1311 §5.6, §10.4,
//! §8.11.2; decisions 3.8, 2a.17, 5.10).

use crate::common::program::*;
use crate::common::{Module, VARIABLES};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp};
use virtual_bench::TICK_NS;

const TIMER_0: u8 = 0;
const POSITION_REACHED: u8 = 3;
const STOP_LEFT: u8 = 27;
const STOP_RIGHT: u8 = 28;
const INPUT_0: u8 = 39;

/// A position-reached interrupt comes on arrival, once; not for standing on the target when it is enabled, nor for a move
/// to where the motor is.
#[test]
fn position_reached_comes_once_on_arrival() {
    let mut module = listening(Module::new(), &[POSITION_REACHED], &[]);
    module.run_ms(100);
    assert_eq!(module.variable(0), 0);
    for (moves, position) in [(1, 1000), (2, -500), (3, -499)] {
        module.ok(Command::MoveToPosition, 0, 0, position);
        module.run_ticks(1);
        while module.gap(Ap::PositionReached) == 0 {
            assert_eq!(module.variable(0), moves - 1);
            module.run_ticks(1);
        }
        module.run_ticks(5);
        assert_eq!(module.variable(0), moves, "at {position}");
        module.run_ms(50);
        module.ok(Command::MoveToPosition, 0, 0, position);
        module.run_ms(50);
        assert_eq!(module.variable(0), moves, "it stands there already");
    }
}

/// §8.11.2's motion, in open loop.
#[test]
fn position_reached_drives_a_ping_pong() {
    let instructions = [
        vect(POSITION_REACHED, 6),
        ei(POSITION_REACHED),
        ei(ALL),
        mvp_abs(5120),
        wait(kind::TICKS, 1000),
        ja(4),
        vect(POSITION_REACHED, 9), // PosReached1
        mvp_abs(0),
        RETI,
        vect(POSITION_REACHED, 6), // PosReached2
        mvp_abs(5120),
        RETI,
    ];
    let mut module = Module::with_program(&instructions);
    module.run_from(0);
    let mut turns = Vec::new();
    let mut direction = 1;
    for _ in 0..20_000 * 5 {
        module.run_ticks(1);
        let velocity = module.read("actual_velocity");
        if velocity * f64::from(direction) < 0.0 {
            turns.push(module.bench.time_ns() / TICK_NS);
            direction = -direction;
        }
        let position = module.read("actual_position");
        assert!((0.0..=5120.0).contains(&position), "{position}");
    }
    assert!(turns.len() >= 6, "{turns:?}");
    let legs: Vec<_> = turns.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(legs.iter().all(|leg| *leg == legs[0]), "each leg takes as long as the other: {legs:?}");
}

/// 0 = off, 1 = low to high, 2 = high to low, 3 = both, for each of the inputs.
#[test]
fn inputs_interrupt_on_the_edges_they_are_set_to() {
    for input in 0..8_u8 {
        for (edge, expected) in [(0, [0, 0, 0, 0]), (1, [1, 1, 2, 2]), (2, [0, 1, 1, 2]), (3, [1, 2, 3, 4])] {
            let interrupt = INPUT_0 + input;
            let mut module = listening(Module::new(), &[interrupt], &[sgp(interrupt, 3, edge)]);
            let (name, high) = if input % 4 == 0 { ("ain", 4095) } else { ("input", 1) };
            for (level, counted) in [high, 0, high, 0].into_iter().zip(expected) {
                module.set(&format!("{name}.{input}"), level);
                module.run_ticks(10);
                assert_eq!(module.variable(0), counted, "input {input}, edge {edge}, now {level}");
            }
            // Other inputs are not its business.
            for other in [1, 2, 3, 5, 6, 7].into_iter().filter(|other| *other != input) {
                module.set(&format!("input.{other}"), 1);
            }
            module.run_ticks(10);
            assert_eq!(module.variable(0), expected[3]);
        }
    }
}

/// An input that is high already when its interrupt is enabled is no edge.
#[test]
fn enabling_is_no_edge() {
    let mut module = Module::new();
    module.set("input.2", 1);
    module.run_ms(1);
    let mut module = listening(module, &[INPUT_0 + 2], &[sgp(INPUT_0 + 2, 3, 3)]);
    assert_eq!(module.variable(0), 0);
    module.set("input.2", 0);
    module.run_ms(1);
    assert_eq!(module.variable(0), 1);
}

/// The levels of 27 and 28 are what AP 11 and AP 10 read: 1 = active, which GP 79 reverses (decisions 5.10).
#[test]
fn stop_switches_interrupt_on_the_edges_they_are_set_to() {
    const BENCH: &str = "[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\nleft = { at_turns = -100.0 }\nright = { at_turns = 100.0 }\n";
    for (interrupt, switch, parameter) in
        [(STOP_LEFT, "left", Ap::LeftLimitSwitch), (STOP_RIGHT, "right", Ap::RightLimitSwitch)]
    {
        for (reversed, active, idle) in [(0, "open", "closed"), (1, "closed", "open")] {
            for (edge, expected) in [(0, [0, 0, 0]), (1, [1, 1, 2]), (2, [0, 1, 1]), (3, [1, 2, 3])] {
                let name = format!("fault.switch_{switch}");
                let mut module = Module::on(BENCH);
                module.sgp(Gp::EndSwitchPolarity, reversed);
                module.set(&name, idle);
                module.run_ms(1);
                let mut module = listening(module, &[interrupt], &[sgp(interrupt, 3, edge)]);
                for (state, counted) in [active, idle, active].into_iter().zip(expected) {
                    module.set(&name, state);
                    module.run_ticks(10);
                    assert_eq!(module.gap(parameter), i32::from(state == active));
                    assert_eq!(module.variable(0), counted, "{switch}, edge {edge}, now {state}");
                }
            }
        }
    }
}

/// Two inputs at the same instant: the lower number first; what comes in a routine waits for its RETI.
#[test]
fn priority_and_no_nesting_over_the_wire() {
    let setup: Vec<_> = [40, 42, 45].map(|interrupt| sgp(interrupt, 3, 1)).to_vec();
    let loop_at = 3 + 6 + 1;
    let mut instructions = setup;
    for (place, interrupt) in (0..).zip([42, 40, 45]) {
        instructions.extend([vect(interrupt, loop_at + 2 + 4 * place), ei(interrupt)]);
    }
    instructions.extend([ei(ALL), wait(kind::TICKS, 100), ja(loop_at)]);
    // Each routine appends a digit to variable 0, by a subroutine of its own that takes 10 ms.
    for _ in 0..3 {
        instructions.extend([ggp(0, VARIABLES), csub(40), keep(0), RETI]);
    }
    let mut module = Module::with_program(&instructions);
    // 42 at 12, 40 at 16, 45 at 20.
    for (address, digit) in [(40, 2), (50, 0), (60, 5)] {
        module
            .download_at(address, &[calc(kind::MUL, 10), calc(kind::ADD, digit), wait(kind::TICKS, 1), RSUB]);
    }
    module.download_at(17, &[csub(50)]);
    module.download_at(21, &[csub(60)]);
    module.run_from(0);
    module.run_ms(1);
    module.set("input.6", 1); // 45
    module.run_ticks(5);
    module.set("input.3", 1); // 42
    module.run_ticks(5);
    module.set("input.1", 1); // 40
    module.run_ms(50);
    assert_eq!(module.variable(0), 502, "45 was being served, then 40 before 42");
}

/// A program that is started anew has no interrupts until it enables them.
#[test]
fn a_start_disables_interrupts() {
    let mut module = listening(Module::new(), &[TIMER_0], &[sgp(TIMER_0, 3, 10)]);
    module.run_ms(100);
    let counted = module.variable(0);
    assert!(counted >= 9);
    module.run_from(4); // behind the EI
    module.run_ms(100);
    assert_eq!(module.variable(0), counted);
}

/// While the program is stopped nothing interrupts it.
#[test]
fn a_stopped_program_is_not_interrupted() {
    let mut module = listening(Module::new(), &[TIMER_0], &[sgp(TIMER_0, 3, 10)]);
    module.run_ms(101);
    let counted = module.variable(0);
    module.stop();
    module.run_ms(1000);
    assert_eq!(module.variable(0), counted);
    module.ok(Command::ApplicationRun, 0, 0, 0);
    module.run_ms(100);
    assert!((counted + 9..=counted + 11).contains(&module.variable(0)), "the beat goes on");
}
