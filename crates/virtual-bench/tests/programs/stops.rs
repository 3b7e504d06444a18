//! What a program hears of a motor that was stopped: interrupts 15 and 21, ESD and EDV (TMCM-1311 §5.6.3, §6, §7; decisions
//! 3.5, 5.5, 5.12).

use crate::common::program::*;
use crate::common::{Module, TURN, VARIABLES};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_wire::Request;

const STALL: u8 = 15;
const DEVIATION: u8 = 21;

/// The stall of `tests/open_loop/stallguard.rs`: it turns twice a second with AP 181 set, then something jams.
fn about_to_stall() -> Module {
    let mut module = Module::new();
    module.run_ms(200);
    module.sap(Ap::MaxVelocity, 20 * TURN);
    module.sap(Ap::MaxAcceleration, 10 * TURN);
    module.ok(Command::RotateRight, 0, 0, 2 * TURN);
    module.run_ms(1200);
    module.sap(Ap::StopOnStallVelocity, TURN);
    module.run_ms(100);
    module
}

/// Counts in the variable of its place, and then notes in variable 10 whether an error flag is set, and clears it.
fn with_flag(interrupt: u8, condition: u8, cle: u8) -> Vec<Request> {
    let mut instructions = vec![vect(interrupt, 5), ei(interrupt), ei(ALL), wait(kind::TICKS, 100), ja(3)];
    instructions.extend(count(0));
    instructions.extend([
        jc(condition, 10),
        RETI,
        sgp(10, VARIABLES, 1), // 10
        op(Command::ClearErrorFlags, cle, 0, 0),
        jc(condition, 14),
        sgp(11, VARIABLES, 1),
        RETI, // 14
    ]);
    instructions
}

/// Stop on stall: ESD, and interrupt 15 (decisions 5.5).
#[test]
fn a_stall_stop_interrupts_and_sets_esd() {
    let mut module = about_to_stall();
    module.download(&with_flag(STALL, kind::ESD, 5));
    module.run_from(0);
    module.run_ms(200);
    assert_eq!((module.variable(0), module.gap(Ap::ActualVelocity)), (0, 2 * TURN));
    module.set("load.friction_nm", 1.0);
    while module.gap(Ap::ActualVelocity) != 0 {
        assert_eq!(module.variable(0), 0);
        module.run_ticks(1);
    }
    module.run_ticks(12);
    assert_eq!([0, 10, 11].map(|variable| module.variable(variable)), [1, 1, 1]);
    assert_eq!(module.gap(Ap::TargetPosition), module.gap(Ap::ActualPosition));
    module.run_ms(500);
    assert_eq!(module.variable(0), 1, "one stop, one interrupt");
}

/// Turning while the encoder is dead.
fn deviating(limit: i32) -> Module {
    let mut module = Module::new();
    module.run_ms(200);
    module.sap(Ap::MaxEncoderDeviation, limit);
    module.download(&with_flag(DEVIATION, kind::EDV, 3));
    module.run_from(0);
    module.ok(Command::RotateRight, 0, 0, TURN / 2);
    module.run_ms(1500);
    assert_eq!((module.variable(0), module.gap(Ap::EncoderDeviationFlag)), (0, 0));
    assert_eq!(module.gap(Ap::ActualVelocity), TURN / 2);
    module.set("fault.encoder_line", "a");
    module
}

/// AP 212: positive stops the motor, negative switches the current off too; AP 207, EDV and interrupt 21 (decisions 5.12).
#[test]
fn a_deviation_stops_interrupts_and_sets_edv() {
    for limit in [512, 2000, -2000] {
        let mut module = deviating(limit);
        let dead_at = module.gap(Ap::ActualPosition);
        while module.gap(Ap::EncoderDeviationFlag) == 0 {
            assert_eq!(module.gap(Ap::ActualVelocity), TURN / 2);
            module.run_ticks(1);
        }
        // Beyond the limit, by no more than it moves in a tick or two; the load angle lets the encoder lag a little.
        let deviated = module.gap(Ap::ActualPosition) - dead_at;
        assert!(
            (limit.abs() - 60..=limit.abs() + 10).contains(&deviated),
            "{deviated} µsteps, AP 212 = {limit}"
        );
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        module.run_ticks(12);
        assert_eq!([0, 10, 11].map(|variable| module.variable(variable)), [1, 1, 1], "AP 212 = {limit}");
        module.run_ms(500);
        assert_eq!(module.variable(0), 1, "one stop, one interrupt");
        assert_eq!(module.gap(Ap::EncoderDeviationFlag), 1, "CLE does not clear it");
        let current = module.physical().coil_a_a.hypot(module.physical().coil_b_a);
        assert_eq!(current > 0.5, limit > 0, "{current} A");

        // The next motion command ends it (decisions 2a.7, 5.12).
        module.sap(Ap::MaxEncoderDeviation, 0);
        let here = module.gap(Ap::ActualPosition);
        module.ok(Command::MoveToPosition, 0, 0, here + 1000);
        assert_eq!(module.gap(Ap::EncoderDeviationFlag), 0);
        module.arrive();
        module.run_ms(100);
        assert_eq!(module.gap(Ap::ActualPosition), here + 1000);
        let current = module.physical().coil_a_a.hypot(module.physical().coil_b_a);
        assert!(current > 0.5, "{current} A");
    }
}

/// AP 212 counts 1/256 full steps whatever AP 140 makes of a µstep (decisions 5.3); the default encoder has 200 counts a
/// full step.
#[test]
fn the_limit_is_in_256ths_of_a_full_step_at_any_resolution() {
    for (resolution, microsteps) in [(8, 256), (4, 16), (0, 1)] {
        let mut module = Module::new();
        module.sap(Ap::MicrostepResolution, resolution);
        module.ok(Command::MoveToPosition, 0, 0, 8 * microsteps);
        module.arrive();
        module.run_ms(500);
        module.sap(Ap::EncoderCounter, 8 * 200);
        module.sap(Ap::MaxEncoderDeviation, 512);
        module.run_ms(10);
        assert_eq!(module.gap(Ap::EncoderDeviationFlag), 0, "AP 140 = {resolution}");
        module.sap(Ap::EncoderCounter, 8 * 200 - 2 * 200);
        module.run_ms(10);
        assert_eq!(module.gap(Ap::EncoderDeviationFlag), 0, "two full steps are the limit, not beyond it");
        module.sap(Ap::EncoderCounter, 8 * 200 - 2 * 200 - 1);
        module.run_ms(10);
        assert_eq!(module.gap(Ap::EncoderDeviationFlag), 1, "AP 140 = {resolution}");
    }
}

#[test]
fn without_a_limit_nothing_deviates() {
    let mut module = deviating(0);
    module.run_ms(2000);
    assert_eq!((module.variable(0), module.gap(Ap::EncoderDeviationFlag)), (0, 0));
    assert_eq!(module.gap(Ap::ActualVelocity), TURN / 2);
}
