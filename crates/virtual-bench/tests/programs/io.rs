//! What programs do with inputs, outputs and parameters, and what a host sees of it (TMCM-1311 §5.5, §5.7.14, §5.7.22,
//! §5.7.29, §10, §11.4, §11.6; decisions §3).

use crate::common::program::*;
use crate::common::{Module, VARIABLES};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::Request;

const FAST: &str = "[[module]]\nkind = \"tmcm-1311\"\ninstructions_per_tick = ";

/// An instruction that keeps the program where it is.
fn idle(address: i32) -> [Request; 2] {
    [wait(kind::TICKS, 1000), ja(address)]
}

/// §5.7.14: the states of the inputs on the outputs.
#[test]
fn outputs_follow_inputs() {
    let mut module = Module::with_program(&[gio(255, 0), sio(255, -1), ja(0)]);
    module.run_from(0);
    let mut inputs = 0;
    for (input, level) in [(1, 1), (7, 1), (3, 1), (1, 0), (2, 1), (5, 1), (6, 1), (7, 0), (3, 0)] {
        module.set(&format!("input.{input}"), level);
        inputs = (inputs & !(1 << input)) | (level << input);
        module.run_ticks(6);
        let outputs = (0..8).map(|number| module.ok(Command::GetInput, number, 2, 0) << number);
        assert_eq!(outputs.sum::<i32>(), inputs);
    }
    for (input, level) in [(0, 4095), (4, 4095), (0, 0)] {
        module.set(&format!("ain.{input}"), level);
        inputs = (inputs & !(1 << input)) | (i32::from(level > 0) << input);
        module.run_ticks(6);
        let outputs = (0..8).map(|number| module.ok(Command::GetInput, number, 2, 0) << number);
        assert_eq!(outputs.sum::<i32>(), inputs);
    }
}

#[test]
fn sio_255_takes_the_low_byte_of_the_accumulator() {
    for (a, outputs) in [(0x1234_56A5, 0xA5), (-1, 0xFF), (0x100, 0)] {
        let mut module = Module::with_program(&[calc(kind::LOAD, a), sio(255, 0x0F), sio(255, -1), STOP]);
        module.run_from(0);
        module.run_to_stop(10);
        let read = (0..8).map(|number| module.ok(Command::GetInput, number, 2, 0) << number);
        assert_eq!(read.sum::<i32>(), outputs);
        assert_eq!(module.ok(Command::Calculate, kind::ADD, 0, 0), a, "it stays");
    }
}

/// §5.7.29: a motor that follows a potentiometer.
#[test]
fn the_potentiometer_example() {
    let example = [gio(0, 1), calc(kind::MUL, 4), op(Command::AccumulatorToAxisParameter, 0, 0, 0), ja(0)];
    let mut module = Module::with_program(&example);
    module.sap(Ap::MaxAcceleration, 512_000);
    module.run_from(0);
    for reading in [1000, 4095, 0, 1, 2048] {
        module.set("ain.0", reading);
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::TargetPosition), 4 * reading);
        assert_eq!(module.gap(Ap::ActualPosition), 4 * reading);
        let turns = f64::from(4 * reading) / f64::from(crate::common::TURN);
        assert!((module.turns() - turns).abs() < crate::common::motion::SLACK, "{} turns", module.turns());
    }
}

/// One instruction each 50 µs; WAIT lasts its ticks of 10 ms and nothing more (§5.7.22, decisions 3.10).
#[test]
fn waits_are_exact_to_the_control_period() {
    let blink = [sio(0, 1), wait(kind::TICKS, 5), sio(0, 0), wait(kind::TICKS, 3), ja(0)];
    for (instructions_per_tick, high, low) in
        [(1, 5 * WAIT_TICK + 1, 3 * WAIT_TICK + 2), (10, 5 * WAIT_TICK, 3 * WAIT_TICK)]
    {
        let mut module = Module::on(&format!("{FAST}{instructions_per_tick}"));
        module.download(&blink);
        module.run_from(0);
        let edges = module.edges(0, 20_000);
        assert!(edges.len() > 20 && edges[0].1);
        for pair in edges.windows(2) {
            let [(from, level), (to, _)] = pair else { unreachable!() };
            assert_eq!(to - from, if *level { high } else { low }, "{instructions_per_tick} a tick");
        }
    }
}

#[test]
fn a_bench_may_execute_faster() {
    for instructions_per_tick in [1, 7, 100, 1000] {
        let mut module = Module::on(&format!("{FAST}{instructions_per_tick}"));
        module.download(&[calc(kind::ADD, 1), calc(kind::ADD, 1), calc(kind::ADD, 1), ja(0)]);
        module.run_from(0);
        module.run_ticks(200);
        let executed = 200 * instructions_per_tick;
        assert_eq!(module.ok(Command::Calculate, kind::ADD, 0, 0), executed / 4 * 3 + executed % 4);
    }
}

/// §5.5, §11.6: whatever a host reads, A, X and the comparison of the program stay.
#[test]
fn direct_mode_does_not_disturb_a_program() {
    let check = [
        calc(kind::LOAD, 1234), // 0
        op(Command::CalculateX, kind::LOAD, 0, 0),
        calc(kind::LOAD, 99),
        comp(100),
        jc(kind::GE, 12), // 4: it is less
        comp(99),
        jc(kind::NE, 12),
        op(Command::CalculateX, 10, 0, 0), // 7: A is 1234, X is 99
        comp(1234),
        jc(kind::NE, 12),
        ggp(50, VARIABLES), // 10
        ja(0),
        sgp(51, VARIABLES, 1), // 12: disturbed
        STOP,
    ];
    let mut module = Module::with_program(&check);
    module.run_from(0);
    for round in 0..3000 {
        module.run_ticks(1);
        match round % 11 {
            0 => _ = module.gap(Ap::ActualPosition),
            1 => _ = module.ggp(Gp::TickTimer),
            2 => _ = module.ok(Command::GetInput, 8, 1, 0),
            3 => _ = module.coordinate(5),
            4 => _ = module.variable(50),
            5 => _ = module.ok(Command::GetInput, 255, 0, 0),
            6 => _ = module.ok(Command::ReferenceSearch, 2, 0, 0),
            7 => module.sap(Ap::MaxVelocity, round),
            8 => module.set_variable(49, round),
            9 => _ = module.status(Command::Compare, 0, 0, 5),
            _ => _ = module.ok(Command::SetCoordinate, 3, 0, round),
        }
    }
    assert_eq!((module.variable(51), module.ggp(Gp::ApplicationStatus)), (0, 1));
}

/// Decisions 3.9: CALC and its kin in direct mode work on the registers of the module, which are the program's.
#[test]
fn calc_in_direct_mode_works_on_the_programs_registers() {
    let mut module = Module::with_program(&[wait(kind::TICKS, 10), keep(7), STOP]);
    module.run_from(0);
    module.run_ms(50);
    module.ok(Command::Calculate, kind::LOAD, 0, 4321);
    module.run_ms(60);
    assert_eq!(module.variable(7), 4321);
}

/// §11.6: host and program talk through user variables.
#[test]
fn host_and_program_share_variables() {
    let double =
        [ggp(10, VARIABLES), jc(kind::ZE, 0), calc(kind::MUL, 2), keep(11), sgp(10, VARIABLES, 0), ja(0)];
    let mut module = Module::with_program(&double);
    module.run_from(0);
    for value in [21, -5, 1_000_000] {
        module.set_variable(10, value);
        module.run_ticks(10);
        assert_eq!((module.variable(10), module.variable(11)), (0, 2 * value));
    }
}

/// §10.1: a counter of milliseconds that can be set to anything.
#[test]
fn the_tick_timer_counts_milliseconds() {
    let mut module =
        Module::with_program(&[ggp(132, 0), keep(7), wait(kind::TICKS, 25), ggp(132, 0), keep(8), STOP]);
    module.run_ms(300);
    assert_eq!(module.ggp(Gp::TickTimer), 300);
    module.sgp(Gp::TickTimer, -2);
    for expected in [-2, -1, 0, 1] {
        assert_eq!(module.ggp(Gp::TickTimer), expected);
        module.run_ms(1);
    }
    module.run_from(0);
    module.run_to_stop(6000);
    assert_eq!(module.variable(8) - module.variable(7), 250);
    module.power_cycle();
    assert_eq!(module.ggp(Gp::TickTimer), 0);
}

/// §10.1: 0 to 2147483647; the same run gives the same numbers.
#[test]
fn random_numbers_are_random_and_repeatable() {
    let draw = |seed_ms| {
        let mut module = Module::with_program(&program(&[&[ggp(133, 0), keep(7)], &idle(0)]));
        module.run_ms(seed_ms);
        let mut numbers: Vec<_> = (0..500).map(|_| module.ggp(Gp::RandomNumber)).collect();
        module.run_from(0);
        module.run_ticks(5);
        numbers.push(module.variable(7));
        numbers
    };
    let numbers = draw(10);
    assert_eq!(numbers, draw(10));
    assert_ne!(numbers, draw(20), "the time of asking stirs it");
    assert!(numbers.iter().all(|number| *number >= 0));
    let distinct: std::collections::BTreeSet<_> = numbers.iter().collect();
    assert!(distinct.len() > 495);
    for bit in 0..31 {
        let ones = numbers.iter().filter(|number| *number >> bit & 1 == 1).count();
        assert!((180..=320).contains(&ones), "bit {bit} is 1 in {ones} of 501");
    }
    assert_eq!(Module::new().status(Command::SetGlobalParameter, 133, 0, 5), Status::WrongType, "read only");
}

/// Reads go to A, in a program only (§5.5), with JC right after (decisions 3.4).
#[test]
fn reads_go_to_the_accumulator() {
    let reads: [(Request, i32); 6] = [
        (gap(4), 51_200),
        (ggp(66, 0), 1),
        (ggp(9, VARIABLES), -9),
        (gio(8, 1), 480),
        (op(Command::GetCoordinate, 5, 0, 0), 50),
        (op(Command::ReferenceSearch, 2, 0, 0), 0),
    ];
    for (read, expected) in reads {
        let mut module = Module::with_program(&[calc(kind::LOAD, 7), read, keep(7), STOP]);
        module.set_variable(9, -9);
        module.ok(Command::SetCoordinate, 5, 0, 50);
        module.run_ms(1);
        module.run_from(0);
        module.run_to_stop(10);
        assert_eq!(module.variable(7), expected, "{read:?}");
    }
}
