//! I²t monitoring (TMCM-1311 §6, AP 25 to 29 and bit 13 of AP 18; decisions 5.11, 6.4): against the current in the coils.

use crate::common::{Module, TICKS_PER_MS, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use virtual_bench::TICK_NS;

/// Bit 13 of the status word.
const I2T_EXCEEDED: i32 = 1 << 13;

fn flagged(module: &mut Module) -> bool {
    module.gap(Ap::StatusWord) & I2T_EXCEEDED != 0
}

/// A module at rest, whose current never falls, with this window.
fn at_rest(current: i32, window_ms: i32, limit: i32) -> Module {
    let mut module = Module::new();
    for (parameter, value) in [
        (Ap::MaxCurrent, current),
        (Ap::StandbyCurrent, 255),
        (Ap::ThermalWindingTimeConstant, window_ms),
        (Ap::I2tLimit, limit),
    ] {
        module.sap(parameter, value);
    }
    module
}

/// I_RMS² in A² of a setting of AP 6.
fn square_a2(setting: i32) -> f64 {
    (3.0 * f64::from(setting / 8 + 1) / 32.0).powi(2)
}

/// The manual's table: an average of 1, 2 and 3 A over 13.2 s is 13 200, 52 800 and 118 800; here 3 A and 1.5 A.
#[test]
fn a_full_window_sums_up_the_square_of_the_rms_current() {
    for (current, expected) in [(255, 118_800.0), (127, 29_700.0)] {
        let mut module = at_rest(current, 13_200, -1);
        module.run_ms(13_700);
        let sum = f64::from(module.gap(Ap::I2tSum));
        assert!((sum / expected - 1.0).abs() < 0.002, "{sum}, not {expected}");
    }
}

#[test]
fn the_sum_follows_the_coils_while_the_motor_turns() {
    let mut module = at_rest(128, 320, 0);
    module.ok(Command::RotateRight, 0, 0, 2 * TURN);
    let mut squares = Vec::new();
    for _ in 0..1000 * TICKS_PER_MS {
        module.run_ticks(1);
        let physical = module.physical();
        squares.push((physical.coil_a_a.powi(2) + physical.coil_b_a.powi(2)) / 2.0);
        // Every 5 ms, a 64th of the window, the sum is new; the sensors are a period behind.
        if squares.len() >= 7000 && (squares.len() - 1).is_multiple_of(100) {
            let end = squares.len() - 1;
            let expected: f64 = squares[end - 6400..end].iter().sum::<f64>() * 0.05;
            let sum = f64::from(module.gap(Ap::I2tSum));
            assert!((sum - expected).abs() < 2.0 + expected * 0.001, "{sum}, not {expected}");
        }
    }
}

#[test]
fn the_sum_falls_to_nothing_when_the_current_is_cut() {
    let mut module = at_rest(255, 1280, -1);
    module.run_ms(1500);
    assert!(module.gap(Ap::I2tSum) > 11_000);
    module.sap(Ap::ChopperOffTime, 0);
    module.run_ms(640);
    let half = module.gap(Ap::I2tSum);
    assert!((5600..5950).contains(&half), "{half}");
    module.run_ms(700);
    assert_eq!(module.gap(Ap::I2tSum), 0);
}

/// Exceeding the limit flags, counts each second, and does nothing to the motor.
#[test]
fn above_the_limit_it_counts_seconds_and_the_current_flows_on() {
    let limit = (square_a2(255) * 640.0) as i32;
    let mut module = at_rest(255, 1280, limit);
    let mut exceeded_ticks = 0;
    while !flagged(&mut module) {
        assert!(module.gap(Ap::I2tSum) <= limit);
        module.run_ticks(1);
        exceeded_ticks += 1;
    }
    assert!(module.gap(Ap::I2tSum) > limit);
    let exceeded_ms = exceeded_ticks / TICKS_PER_MS;
    assert!(
        (640..=680).contains(&exceeded_ms),
        "{exceeded_ms} ms: half the window, and 20 ms that it is late"
    );
    let current = module.gap(Ap::CoolstepActualCurrent);
    // The first of the second's ticks is behind it.
    module.run_ticks(1000 * TICKS_PER_MS - 2);
    assert_eq!(module.gap(Ap::I2tExceedCounter), 0);
    module.run_ticks(1);
    assert_eq!(module.gap(Ap::I2tExceedCounter), 1);
    module.run_ms(4999);
    assert_eq!(module.gap(Ap::I2tExceedCounter), 5);
    module.run_ms(1);
    assert_eq!(module.gap(Ap::I2tExceedCounter), 6);
    assert_eq!(module.gap(Ap::CoolstepActualCurrent), current);
    module.sap(Ap::I2tExceedCounter, 0);
    module.run_ms(1000);
    assert_eq!(module.gap(Ap::I2tExceedCounter), 1);
}

#[test]
fn the_flag_stays_until_it_is_cleared_and_that_takes_a_window_of_cooling() {
    let mut module = at_rest(255, 500, 1000);
    module.run_ms(1000);
    assert!(flagged(&mut module));
    module.sap(Ap::ClearI2tFlag, 0);
    assert!(flagged(&mut module), "the sum is above the limit");
    module.sap(Ap::MaxCurrent, 0);
    while module.gap(Ap::I2tSum) > 1000 {
        module.run_ms(1);
    }
    let count = module.gap(Ap::I2tExceedCounter);
    module.run_ms(490);
    module.sap(Ap::ClearI2tFlag, 0);
    assert!(flagged(&mut module), "too early");
    module.run_ms(20);
    assert!(flagged(&mut module), "it does not clear of itself");
    module.sap(Ap::ClearI2tFlag, 123);
    assert!(!flagged(&mut module));
    module.run_ms(5000);
    assert_eq!(module.gap(Ap::I2tExceedCounter), count, "below the limit nothing counts");
}

/// AP 25 below 64 ms counts as 64 ms.
#[test]
fn a_window_shorter_than_64_ms_is_64_ms() {
    for window_ms in [0, 1, 63, 64] {
        let mut module = at_rest(255, window_ms, -1);
        module.run_ms(300);
        let sum = module.gap(Ap::I2tSum);
        assert!((570..=580).contains(&sum), "{sum} with AP 25 = {window_ms}");
        assert_eq!(module.gap(Ap::ThermalWindingTimeConstant), window_ms);
    }
}

#[test]
fn another_window_begins_anew_and_the_longest_is_no_trouble() {
    let mut module = at_rest(255, 100, -1);
    module.run_ms(300);
    module.sap(Ap::ThermalWindingTimeConstant, 100);
    assert!(module.gap(Ap::I2tSum) > 800, "the same one goes on");
    module.sap(Ap::ThermalWindingTimeConstant, -1);
    assert_eq!(module.gap(Ap::I2tSum), 0);
    module.run_ms(60_000);
    assert_eq!(module.gap(Ap::I2tSum), 0, "a 64th of 49 days is not over");
}

#[test]
fn a_power_cycle_forgets_the_sum_and_keeps_what_is_stored() {
    let mut module = at_rest(255, 320, 100);
    module.run_ms(2000);
    assert!(flagged(&mut module) && module.gap(Ap::I2tExceedCounter) == 1);
    for parameter in [Ap::ThermalWindingTimeConstant, Ap::I2tLimit, Ap::I2tExceedCounter] {
        module.ok(Command::StoreAxisParameter, parameter.number(), 0, 0);
    }
    module.power_cycle();
    assert!(!flagged(&mut module));
    assert_eq!(module.gap(Ap::I2tSum), 0);
    let stored = [Ap::ThermalWindingTimeConstant, Ap::I2tLimit, Ap::I2tExceedCounter];
    assert_eq!(stored.map(|parameter| module.gap(parameter)), [320, 100, 1]);
}

/// The whole bench after a rest and after going through it period by period: filling, full, above the limit, falling.
#[test]
fn resting_is_stepping_while_the_window_fills_and_empties() {
    let mut resting = Module::new();
    // 1.59 A until 2 s, then 0.19 A; parts that do not divide evenly.
    resting.sap(Ap::ThermalWindingTimeConstant, 777);
    resting.sap(Ap::I2tLimit, 500);
    let mut stepping = resting.clone();
    for ticks in [7_001, 20_000, 39_990, 41_000, 60_003, 90_000] {
        resting.bench.advance_to(ticks * TICK_NS);
        while stepping.bench.time_ns() < ticks * TICK_NS {
            stepping.run_ticks(1);
        }
        assert!(resting.state() == stepping.state(), "at {ticks} ticks");
    }
    assert!(flagged(&mut resting));
    assert_eq!(resting.gap(Ap::I2tExceedCounter), 2, "0.3 s to 2.6 s");
}

/// Whoever looks on sees every change at its time, although the bench rests.
#[test]
fn an_observer_sees_each_change_of_the_sum() {
    let mut stepped = at_rest(255, 640, -1);
    let mut watched = stepped.clone();
    let probe = watched.bench.probe("i2t_sum").expect("a parameter");
    let mut expected = Vec::new();
    let mut sum = 0.0;
    while stepped.bench.time_ns() < 700_000_000 {
        stepped.run_ticks(1);
        let now = stepped.bench.read(probe);
        if now > sum {
            sum = now;
            expected.push((stepped.bench.time_ns(), now.to_bits()));
        }
    }
    let mut seen = Vec::new();
    let mut sum = 0.0;
    watched.bench.advance_observed(700_000_000, &mut |bench| {
        let now = bench.read(probe);
        if now > sum {
            sum = now;
            seen.push((bench.time_ns(), now.to_bits()));
        }
        true
    });
    assert!(seen.len() >= 64, "{}", seen.len());
    assert_eq!(seen, expected);
}
