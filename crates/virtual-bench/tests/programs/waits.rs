//! WAIT for events of the motor and its switches, with and without timeout (TMCM-1311 §5.7.22; decisions 3.5, 3.7, 2a.18,
//! 5.10).

use crate::common::program::*;
use crate::common::{Module, VARIABLES};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter as Gp, Status};
use tmcl_wire::Request;

/// Stop switches that only a fault opens.
const SWITCHES: &str = "[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\nleft = { at_turns = -100.0 }\nright = { at_turns = 100.0 }\n";

/// Waits and then raises OUT0; with ETO also OUT1.
fn waiter(wait: Request) -> [Request; 5] {
    [wait, sio(0, 1), jc(kind::ETO, 4), STOP, sio(1, 1)]
}

fn outputs(module: &Module) -> (bool, bool) {
    (module.read("output.0") == 1.0, module.read("output.1") == 1.0)
}

/// Runs a program that waits; what ends the wait happens after `ms`.
#[track_caller]
fn assert_waits(
    mut module: Module,
    kind: u8,
    ticks: i32,
    ms: u64,
    happens: impl FnOnce(&mut Module),
) -> Module {
    module.download(&waiter(wait(kind, ticks)));
    module.run_from(0);
    module.run_ms(ms);
    assert_eq!(outputs(&module), (false, false), "it waits");
    assert_eq!(module.status_of_program(), (1, 0), "the program counter is held");
    happens(&mut module);
    module.run_ticks(4);
    assert!(outputs(&module).0, "it goes on at once");
    module.run_to_stop(10);
    assert_eq!(outputs(&module), (true, false), "no timeout");
    module
}

#[track_caller]
fn assert_does_not_wait(mut module: Module, kind: u8, ticks: i32) {
    module.download(&waiter(wait(kind, ticks)));
    module.run_from(0);
    assert!(module.run_to_stop(10) <= 4);
    assert_eq!(outputs(&module), (true, false));
}

#[test]
fn wait_pos_ends_with_the_move() {
    for ticks in [0, 200] {
        let go = [mvp_abs(20_000), wait(kind::POS, ticks), sio(0, 1), jc(kind::ETO, 5), STOP, sio(1, 1)];
        let mut module = Module::with_program(&go);
        module.run_from(0);
        let mut arrived = 0;
        let raised = loop {
            module.run_ticks(1);
            let now = module.bench.time_ns() / virtual_bench::TICK_NS;
            if arrived == 0
                && module.gap(Ap::PositionReached) == 1
                && module.gap(Ap::ActualPosition) == 20_000
            {
                arrived = now;
            }
            if outputs(&module).0 {
                break now;
            }
        };
        assert!(arrived > 1000 && raised - arrived <= 2, "reached at {arrived}, noticed at {raised}");
        module.run_to_stop(5);
        assert!(!outputs(&module).1);
    }
}

#[test]
fn wait_pos_at_the_target_is_no_wait() {
    assert_does_not_wait(Module::new(), kind::POS, 0);
}

/// "Waits for the position-reached flag, whatever the mode" (decisions 2a.18): in velocity mode it waits for ever.
#[test]
fn wait_pos_in_velocity_mode_waits_for_the_flag() {
    let mut module = Module::new();
    module.ok(Command::RotateRight, 0, 0, 5000);
    module.run_ms(500);
    let module = assert_waits(module, kind::POS, 0, 3000, |module| {
        let here = module.gap(Ap::ActualPosition);
        module.ok(Command::MoveToPosition, 0, 0, here + 10_000);
        module.arrive();
    });
    assert_eq!(module.read("position_reached"), 1.0);
}

/// Exactly as long as it says; the move goes on (§5.7.22).
#[test]
fn a_timeout_is_exact_and_sets_eto() {
    for ticks in [1, 5, 50] {
        let go =
            [mvp_abs(100_000), wait(kind::POS, ticks), sio(0, 1), jc(kind::ETO, 5), STOP, sio(1, 1), STOP];
        let mut module = Module::with_program(&go);
        module.run_from(0);
        let passed = module.run_to_stop(20_000);
        // MVP, WAIT, SIO, JC, SIO, STOP; of WAIT its time alone.
        assert_eq!(passed, ticks as u64 * WAIT_TICK + 5);
        assert_eq!(outputs(&module), (true, true));
        module.arrive();
        assert_eq!(module.gap(Ap::ActualPosition), 100_000);
    }
}

#[test]
fn eto_stays_until_cle() {
    let go = [
        wait(kind::LIMSW, 1),
        wait(kind::POS, 5), // ends well
        jc(kind::ETO, 4),
        STOP,
        op(Command::ClearErrorFlags, 3, 0, 0), // EDV: another flag
        jc(kind::ETO, 7),
        STOP,
        op(Command::ClearErrorFlags, 1, 0, 0), // ETO
        jc(kind::ETO, 10),
        sgp(7, VARIABLES, 77),
        STOP,
    ];
    let mut module = Module::with_program(&go);
    module.run_from(0);
    module.run_to_stop(1000);
    assert_eq!((module.variable(7), module.ggp(Gp::ProgramCounter)), (77, 10));
}

/// The home switch is IN_1's, normally closed: active while the input is high, unless GP 79 reverses it.
#[test]
fn wait_refsw() {
    for (reversed, idle, active) in [(0, 0, 1), (1, 1, 0)] {
        let module = || {
            let mut module = Module::new();
            module.set("input.1", idle);
            module.sgp(Gp::EndSwitchPolarity, reversed);
            module.run_ticks(5);
            assert_eq!(module.gap(Ap::HomeSwitch), 0);
            module
        };
        for ticks in [0, 50] {
            assert_waits(module(), kind::REFSW, ticks, 450, |module| module.set("input.1", active));
        }
        let mut active_already = module();
        active_already.set("input.1", active);
        active_already.run_ticks(5);
        assert_eq!(active_already.gap(Ap::HomeSwitch), 1);
        assert_does_not_wait(active_already, kind::REFSW, 5);
    }
}

#[test]
fn wait_limsw_waits_for_either_stop_switch() {
    for (reversed, idle, active) in [(0, "closed", "open"), (1, "open", "closed")] {
        for switch in ["fault.switch_left", "fault.switch_right"] {
            let mut module = Module::on(SWITCHES);
            module.set("fault.switch_left", idle);
            module.set("fault.switch_right", idle);
            module.sgp(Gp::EndSwitchPolarity, reversed);
            module.run_ticks(5);
            let mut module = assert_waits(module, kind::LIMSW, 0, 450, |module| module.set(switch, active));
            let left = i32::from(switch == "fault.switch_left");
            assert_eq!((module.gap(Ap::LeftLimitSwitch), module.gap(Ap::RightLimitSwitch)), (left, 1 - left));
            module.set("input.1", 1);
            assert_does_not_wait(module.clone(), kind::LIMSW, 5);
        }
    }
}

/// A switch that the shaft itself runs into.
#[test]
fn wait_limsw_ends_where_the_switch_is() {
    let bench = "[[module]]\nkind = \"tmcm-1311\"\n[module.switches]\nright = { at_turns = 0.5 }\n";
    let mut module = Module::on(bench);
    module.sap(Ap::RightLimitSwitchDisable, 1);
    module.download(&[op(Command::RotateRight, 0, 0, 20_000), wait(kind::LIMSW, 0), sio(0, 1), STOP]);
    module.run_from(0);
    module.run_to_stop(100_000);
    assert!((module.turns() - 0.5).abs() < 0.002, "{} turns", module.turns());
}

/// No search runs, so none is waited for (decisions 2a.18).
#[test]
fn wait_rfs_without_a_search_is_no_wait() {
    for ticks in [0, 100] {
        assert_does_not_wait(Module::new(), kind::RFS, ticks);
    }
}

#[test]
fn there_is_no_motor_1_to_wait_for() {
    for kind in [kind::POS, kind::REFSW, kind::LIMSW, kind::RFS] {
        let mut module = Module::with_program(&[op(Command::Wait, kind, 1, 5), STOP]);
        module.run_from(0);
        module.run_to_stop(5);
        assert_eq!(module.refused(), [(0, Status::InvalidValue, 1)]);
    }
    // With TICKS the motor means nothing.
    let mut module = Module::with_program(&[op(Command::Wait, kind::TICKS, 99, 1), STOP]);
    module.run_from(0);
    assert_eq!(module.run_to_stop(1000), WAIT_TICK + 1);
}

/// -1 takes the ticks from A; nothing and less than nothing are no wait.
#[test]
fn wait_ticks_minus_1_takes_the_accumulator() {
    for (a, ticks, expected) in [(7, -1, 7), (0, -1, 0), (-4, -1, 0), (7, 3, 3), (7, 0, 0), (7, -2, 0)] {
        let mut module = Module::with_program(&[calc(kind::LOAD, a), wait(kind::TICKS, ticks), STOP]);
        module.run_from(0);
        let passed = module.run_to_stop(5000);
        let instructions = if expected == 0 { 3 } else { 2 };
        assert_eq!(passed, expected * WAIT_TICK + instructions, "A = {a}, WAIT TICKS {ticks}");
    }
}
