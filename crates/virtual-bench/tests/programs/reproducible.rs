//! Programs on a bench that goes through quiet time at once, or is copied in mid-run: nobody can tell.

use crate::common::program::*;
use crate::common::{Module, TURN, VARIABLES};
use proptest::prelude::*;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp};
use tmcl_wire::Request;
use virtual_bench::TICK_NS;

/// Timers, edges and moves, with long waits between.
fn busy() -> Vec<Request> {
    vec![
        vect(0, 20), // 0
        vect(3, 26),
        vect(41, 30),
        sgp(0, 3, 333),
        sgp(41, 3, 3),
        ei(0),
        ei(3),
        ei(41),
        ei(ALL),
        mvp_abs(3000), // 9
        wait(kind::POS, 0),
        wait(kind::TICKS, 33),
        mvp_abs(0),
        wait(kind::POS, 7),
        wait(kind::TICKS, 71),
        wait(kind::LIMSW, 5),
        ggp(133, 0),
        keep(9),
        ja(9), // 18
        STOP,
        gio(0, 2), // 20
        jc(kind::NZ, 24),
        sio(0, 1),
        RETI,
        sio(0, 0), // 24
        RETI,
        ggp(1, VARIABLES), // 26
        calc(kind::ADD, 1),
        keep(1),
        RETI,
        wait(kind::TICKS, 2), // 30
        sio(1, 1),
        sio(1, 0),
        op(Command::StoreGlobalParameter, 1, VARIABLES, 0),
        RETI,
    ]
}

fn started(instructions_per_tick: u16) -> Module {
    let mut module = Module::on(&format!(
        "[[module]]\nkind = \"tmcm-1311\"\ninstructions_per_tick = {instructions_per_tick}"
    ));
    module.download(&busy());
    module.run_from(0);
    module
}

/// A tick at a time leaves no room for resting.
fn step_to(module: &mut Module, ns: u64) {
    while module.bench.time_ns() < ns {
        module.run_ticks(1);
    }
}

/// The same inputs at the same instants, resting and not; all state is the same at each of them and at the end.
#[track_caller]
fn assert_resting_is_stepping(
    mut resting: Module,
    until_ms: u64,
    at_ms: &[u64],
    mut act: impl FnMut(&mut Module, u64),
) {
    let mut stepping = resting.clone();
    for &now_ms in at_ms.iter().chain([&until_ms]) {
        resting.bench.advance_to(now_ms * 1_000_000);
        step_to(&mut stepping, now_ms * 1_000_000);
        assert!(stepping.state() == resting.state(), "at {now_ms} ms");
        act(&mut resting, now_ms);
        act(&mut stepping, now_ms);
    }
}

#[test]
fn resting_is_stepping_with_a_program_that_waits() {
    for instructions_per_tick in [1, 5] {
        let act = |module: &mut Module, now_ms| match now_ms {
            700 | 2100 => module.set("input.2", 1),
            1333 => module.set("input.2", 0),
            1500 => module.sgp(Gp::Timer0Period, 17),
            1700 => module.stop(),
            1900 => _ = module.ok(Command::ApplicationRun, 0, 0, 0),
            2500 => module.sgp(Gp::Timer0Period, 0),
            _ => (),
        };
        let at_ms = [1, 700, 1333, 1500, 1700, 1900, 2100, 2500];
        assert_resting_is_stepping(started(instructions_per_tick), 4000, &at_ms, act);
    }
}

/// A deviation that a host's setting makes while everything rests interrupts at once, not when something else happens.
#[test]
fn resting_is_stepping_when_a_deviation_comes_out_of_nowhere() {
    for limit in [100, -100] {
        let mut module = Module::new();
        module.download(&[
            vect(21, 6),
            ei(21),
            ei(ALL),
            wait(kind::TICKS, 30_000),
            ja(3),
            STOP,
            sio(0, 1),
            RETI,
        ]);
        module.run_from(0);
        assert_resting_is_stepping(module, 3300, &[3037, 3050], |module, now_ms| {
            if now_ms == 3037 {
                module.sap(Ap::EncoderCounter, 5000);
                module.sap(Ap::MaxEncoderDeviation, limit);
            } else {
                assert_eq!(module.read("output.0"), 1.0, "AP 212 = {limit}");
            }
        });
    }
}

/// Steps, downloads and restarts while the module rests.
#[test]
fn resting_is_stepping_while_a_host_steps() {
    let mut module = Module::new();
    module.download(&[wait(kind::TICKS, 40), sio(2, 1), wait(kind::POS, 30), wait(kind::LIMSW, 0), STOP]);
    assert_resting_is_stepping(module, 2000, &[10, 500, 510, 520, 1900], |module, now_ms| match now_ms {
        10 | 500 | 510 | 520 => module.step(),
        _ => module.reset(),
    });
}

#[test]
fn auto_start_after_power_rests_too() {
    let mut module = started(1);
    module.sgp(Gp::AutoStart, 1);
    assert_resting_is_stepping(module, 2500, &[800, 1200, 1900], |module, now_ms| match now_ms {
        800 => module.set("power", "off"),
        1200 => module.set("power", "on"),
        _ => module.power_cycle(),
    });
}

/// A thousand seconds of waiting is gone through quickly; what counts them is exact.
#[test]
fn long_waits_are_gone_through_at_once() {
    let mut instructions = vec![vect(0, 8), sgp(0, 3, 10_000), ei(0), ei(ALL), wait(kind::TICKS, 30_000)];
    instructions.extend([sgp(2, VARIABLES, 1), ja(4), STOP]);
    instructions.extend(count(1));
    instructions.push(RETI);
    let mut module = Module::with_program(&instructions);
    module.run_from(0);
    let mut short = module.clone();
    module.bench.advance_to(1_000_000_000_000);
    assert_eq!((module.variable(1), module.variable(2)), (99, 1));
    module.run_ticks(10);
    assert_eq!(module.variable(1), 100);

    let mut stepping = short.clone();
    short.bench.advance_to(12_000_000_000);
    step_to(&mut stepping, 12_000_000_000);
    assert!(short.state() == stepping.state());
    assert_eq!(short.variable(1), 1);
}

/// A snapshot goes on as the original does: with a running program, in an interrupt routine, in a WAIT, in a download.
#[test]
fn a_snapshot_goes_on_as_the_original() {
    let mut module = started(1);
    module.set("input.2", 1);
    let mut snapshots = Vec::new();
    for ticks in [1, 200, 333, 4000, 6333, 6334, 6335, 9000] {
        step_to(&mut module, ticks * TICK_NS);
        let snapshot = module.clone();
        assert!(snapshot.state() == module.state());
        snapshots.push(snapshot);
    }
    module.bench.advance_to(1_500_000_000);
    for mut snapshot in snapshots {
        snapshot.bench.advance_to(1_500_000_000);
        assert!(snapshot.state() == module.state());
    }
    module.ok(Command::DownloadStart, 0, 0, 100);
    let mut snapshot = module.clone();
    for module in [&mut module, &mut snapshot] {
        module.load(ja(TURN));
        module.ok(Command::DownloadEnd, 0, 0, 0);
    }
    assert!(snapshot.state() == module.state());
    assert_eq!(snapshot.read_instruction(100), ja(TURN));
}

/// Instructions of programs that rest often: waits, timers, edges, short moves, and jumps between them.
fn instruction() -> impl Strategy<Value = Request> {
    let address = || 0..20_i32;
    let interrupt = || prop_oneof![0..4_u8, 40..43_u8, Just(21), Just(28)];
    prop_oneof![
        6 => (0..5_u8, 0..4_i32).prop_map(|(kind, ticks)| wait(kind, ticks)),
        3 => (interrupt(), address()).prop_map(|(number, to)| vect(number, to)),
        3 => prop_oneof![interrupt(), Just(ALL)].prop_map(ei),
        1 => prop_oneof![interrupt(), Just(ALL)].prop_map(di),
        2 => (0..3_u8, 0..30_i32).prop_map(|(timer, ms)| sgp(timer, 3, ms)),
        2 => (40..43_u8, 0..4_i32).prop_map(|(number, edge)| sgp(number, 3, edge)),
        2 => Just(RETI),
        2 => address().prop_map(ja),
        1 => (0..13_u8, address()).prop_map(|(condition, to)| jc(condition, to)),
        1 => address().prop_map(csub),
        1 => Just(RSUB),
        2 => (-40..40_i32).prop_map(mvp_abs),
        1 => Just(sap(Ap::MaxEncoderDeviation.number(), 100)),
        1 => (-300..300_i32).prop_map(|counts| sap(Ap::EncoderCounter.number(), counts)),
        1 => (0..2_i32).prop_map(|reversed| sgp(79, 0, reversed)),
        1 => (0..8_u8, 0..2_i32).prop_map(|(port, level)| sio(port, level)),
        1 => Just(STOP),
    ]
}

/// What a host or the surroundings do between two stretches of time.
fn act(module: &mut Module, what: u8) {
    match what {
        0..=5 => module.set(&format!("input.{}", what / 2 + 1), what % 2),
        6 => _ = module.ok(Command::ApplicationRun, 0, 0, 0),
        7 => module.step(),
        8 => module.stop(),
        9 => module.run_from(0),
        10 => _ = module.ok(Command::MoveToPosition, 0, 0, 25),
        11 => module.sap(Ap::EncoderCounter, 700),
        12 => module.sgp(Gp::Timer0Period, 5),
        13 => module.set("fault.dropped_steps", 4),
        _ => (),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn resting_is_stepping_for_any_program(
        program in prop::collection::vec(instruction(), 4..20),
        instructions_per_tick in prop_oneof![Just(1), Just(6)],
        acts in prop::collection::vec((0..20_u8, 1..800_u64), 1..12),
    ) {
        let text = format!("[[module]]\nkind = \"tmcm-1311\"\ninstructions_per_tick = {instructions_per_tick}");
        let mut resting = Module::on(&text);
        resting.run_ms(1500);
        resting.download(&program);
        resting.run_from(0);
        let mut stepping = resting.clone();
        for (what, ticks) in acts {
            resting.run_ticks(ticks);
            (0..ticks).for_each(|_| stepping.run_ticks(1));
            prop_assert!(resting.state() == stepping.state(), "after {} ns", resting.bench.time_ns());
            act(&mut resting, what);
            act(&mut stepping, what);
        }
    }
}
