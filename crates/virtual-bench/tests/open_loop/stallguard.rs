//! stallGuard2: what AP 206 reads under load and at speed, and the stop on stall (TMCM-1311 §7, decisions 5.5).

use std::f64::consts::TAU;

use crate::common::{Module, TURN};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter as Ap;

/// What the default motor holds at the default AP 6 = 128: 17/32 of 3 A RMS, and 1.01 Nm at 2.8 A.
const PULL_OUT_NM: f64 = 1.01 * (17.0 / 32.0 * 3.0) / 2.8;

/// A second at least of turning to the right at `turns_per_s` against `load_nm`.
fn turning(load_nm: f64, turns_per_s: f64) -> Module {
    let mut module = Module::new();
    module.set("load.torque_nm", -load_nm);
    module.run_ms(200);
    module.sap(Ap::MaxVelocity, 20 * TURN);
    module.sap(Ap::MaxAcceleration, 10 * TURN);
    module.ok(Command::RotateRight, 0, 0, pps(turns_per_s));
    module.run_ms((turns_per_s * 100.0) as u64 + 1000);
    module
}

fn pps(turns_per_s: f64) -> i32 {
    (turns_per_s * f64::from(TURN)) as i32
}

/// The mean of AP 206 over half a second.
fn mean_reading(module: &mut Module) -> f64 {
    let readings: i32 = (0..500)
        .map(|_| {
            module.run_ms(1);
            module.gap(Ap::LoadValue)
        })
        .sum();
    f64::from(readings) / 500.0
}

fn is_in_step(module: &mut Module) -> bool {
    let behind = f64::from(module.gap(Ap::ActualPosition)) / f64::from(TURN) - module.turns();
    behind.abs() * 200.0 < 1.0
}

#[test]
fn the_reading_falls_with_the_load_as_the_sine_of_the_load_angle_rises() {
    for turns_per_s in [2.0, 5.0, 10.0] {
        let mut before = f64::INFINITY;
        for load_nm in [0.0, 0.1, 0.2, 0.3, 0.4] {
            let mut module = turning(load_nm, turns_per_s);
            let reading = mean_reading(&mut module);
            assert!(is_in_step(&mut module));
            let torque_nm = load_nm + 0.01 + 4e-4 * TAU * turns_per_s;
            let expected = 500.0 * (1.0 - torque_nm / PULL_OUT_NM);
            let at = format!("{turns_per_s} turns/s, {load_nm} Nm");
            assert!((reading - expected).abs() < 5.0, "{reading} instead of {expected} at {at}");
            assert!(reading < before, "{reading} after {before} at {at}");
            before = reading;
        }
        let mut stalled = turning(0.7, turns_per_s);
        assert!(!is_in_step(&mut stalled));
        assert_eq!(mean_reading(&mut stalled), 0.0, "stalled at {turns_per_s} turns/s");
    }
}

#[test]
fn below_a_turn_a_second_speed_passes_for_load() {
    let unloaded: Vec<_> = [0.1, 0.25, 0.5].map(|speed| mean_reading(&mut turning(0.0, speed))).into();
    for (reading, expected) in unloaded.iter().zip([48.0, 120.0, 240.0]) {
        assert!((reading - expected).abs() < 10.0, "{reading} instead of {expected}");
    }
    let loaded = mean_reading(&mut turning(0.2, 2.0));
    assert!(unloaded.iter().all(|reading| *reading < loaded), "{unloaded:?} free, {loaded} under load");
}

#[test]
fn where_the_back_emf_reaches_the_supply_the_reading_is_low_without_a_load() {
    // The back-EMF at 15 turns/s is 24 V.
    for (supply_v, useful) in [(48, true), (30, false)] {
        let mut module = turning(0.0, 15.0);
        module.set("supply.voltage_v", supply_v);
        module.run_ms(3000);
        let reading = mean_reading(&mut module);
        assert!(is_in_step(&mut module));
        assert_eq!(reading > 400.0, useful, "{reading} at {supply_v} V");
    }
}

#[test]
fn the_threshold_moves_the_reading_by_eight_a_step() {
    let mut module = turning(0.2, 2.0);
    let plain = mean_reading(&mut module);
    for (threshold, expected) in
        [(-64, 0.0), (-10, plain - 80.0), (10, plain + 80.0), (63, plain + 504.0), (0, plain)]
    {
        module.sap(Ap::Stallguard2Threshold, threshold);
        module.run_ms(20);
        let reading = mean_reading(&mut module);
        assert!((reading - expected).abs() < 2.0, "{reading} instead of {expected} at SGT {threshold}");
    }
}

#[test]
fn the_filter_makes_one_reading_of_four_full_steps() {
    // A load that never comes to the same place of a full step.
    let bench_file = "[[module]]\nkind = \"tmcm-1311\"\n[module.load]\n\
        torque = { by = \"position\", points = [[0.0, 0.0], [0.005, -0.2]], period = 0.0137 }\n";
    let mut spreads = Vec::new();
    for (filter, full_steps) in [(0, 1), (1, 4)] {
        let mut module = Module::on(bench_file);
        module.sap(Ap::Stallguard2Filter, filter);
        module.sap(Ap::MaxVelocity, 2 * TURN);
        module.sap(Ap::MaxAcceleration, 10 * TURN);
        module.ok(Command::RotateRight, 0, 0, 2 * TURN);
        module.run_ms(1000);
        let (mut readings, mut last_change) = (vec![module.gap(Ap::LoadValue)], None);
        for tick in 0..20_000_u64 {
            module.run_ticks(1);
            let reading = module.gap(Ap::LoadValue);
            if readings.last() != Some(&reading) {
                readings.push(reading);
                // 400 full steps a second are 50 control periods each.
                let since = tick - last_change.replace(tick).unwrap_or(tick);
                let reading_ticks = 50 * full_steps;
                let off = (since + 2) % reading_ticks;
                assert!(off <= 4, "{since} periods between two readings of {full_steps} full steps");
            }
        }
        assert!(readings.len() > 90 / full_steps as usize, "{} readings in a second", readings.len());
        spreads.push(readings.iter().max().unwrap() - readings.iter().min().unwrap());
    }
    assert!(spreads[1] < spreads[0], "{spreads:?}");
}

mod stop_on_stall {
    use super::*;

    /// Turning at 2 turns/s with AP 181 set; then something jams.
    fn jammed(threshold_pps: i32) -> Module {
        let mut module = turning(0.0, 2.0);
        module.sap(Ap::StopOnStallVelocity, threshold_pps);
        module.run_ms(500);
        assert_eq!(module.gap(Ap::ActualVelocity), pps(2.0), "no stall yet");
        module.set("load.friction_nm", 1.0);
        module
    }

    #[test]
    fn stops_at_once_when_the_reading_is_0_above_its_velocity() {
        let mut module = jammed(TURN);
        for tick in 0.. {
            module.run_ticks(1);
            if module.gap(Ap::LoadValue) == 0 {
                break;
            }
            assert_eq!(module.gap(Ap::ActualVelocity), pps(2.0));
            assert!(tick < 1000, "50 ms are 20 full steps");
        }
        assert_eq!(module.gap(Ap::ActualVelocity), 0, "in the same control period");
        assert_eq!(module.gap(Ap::TargetPosition), module.gap(Ap::ActualPosition));
        assert_eq!(module.gap(Ap::TargetVelocity), 0);
        assert_eq!(module.gap(Ap::DriverErrorFlags) & 1, 1, "AP 208 says stall");

        let stopped_at = module.gap(Ap::ActualPosition);
        module.set("load.friction_nm", 0.01);
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualPosition), stopped_at, "it does not start again by itself");
        let lost = (f64::from(stopped_at) / f64::from(TURN) - module.turns()) * 200.0;
        assert!(lost.abs() < 4.5, "it stops in time to lose four full steps at most, not {lost}");
    }

    #[test]
    fn in_a_move_the_target_becomes_where_it_stands_and_the_next_move_works() {
        let mut module = Module::new();
        module.run_ms(100);
        module.sap(Ap::MaxVelocity, 2 * TURN);
        module.sap(Ap::MaxAcceleration, 10 * TURN);
        module.sap(Ap::StopOnStallVelocity, TURN);
        module.ok(Command::MoveToPosition, 0, 0, 10 * TURN);
        module.run_ms(1000);
        module.set("load.friction_nm", 1.0);
        module.run_ms(200);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        let target = module.gap(Ap::TargetPosition);
        assert_eq!(target, module.gap(Ap::ActualPosition));
        assert!(target < 3 * TURN, "{target}");

        module.set("load.friction_nm", 0.01);
        module.ok(Command::MoveToPosition, 0, 0, target + 4 * TURN);
        let from = module.turns();
        module.arrive();
        module.run_ms(500);
        assert_eq!(module.gap(Ap::ActualPosition), target + 4 * TURN);
        let turned = module.turns() - from;
        assert!((turned - 4.0).abs() < 0.05, "{turned} turns");
    }

    #[test]
    fn neither_without_a_velocity_nor_below_it() {
        for threshold_pps in [0, 3 * TURN] {
            let mut module = jammed(threshold_pps);
            module.run_ms(500);
            assert_eq!(module.gap(Ap::LoadValue), 0);
            assert_eq!(module.gap(Ap::ActualVelocity), pps(2.0), "AP 181 = {threshold_pps}");
            assert!(!is_in_step(&mut module));
        }
    }

    #[test]
    fn below_useful_speed_it_stops_a_free_motor() {
        let mut module = Module::new();
        module.sap(Ap::StopOnStallVelocity, 50);
        module.ok(Command::RotateRight, 0, 0, TURN);
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualVelocity), 0, "the first reading near standstill is 0");
    }
}
