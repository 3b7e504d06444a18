//! The supply as the module reads it, what it is like to be switched off, and how warm things get over minutes.

use crate::common::{Module, TURN};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use tmcl_tables::{Command, GlobalParameter};
use tmcl_wire::{Request, serial};

/// Copper loss at standstill and phase 0: all of the default amplitude in one coil of 0.83 Ω.
const COPPER_W: f64 = 0.83 * 2.0 * (17.0 / 32.0 * 3.0) * (17.0 / 32.0 * 3.0);

const SECOND_NS: u64 = 1_000_000_000;

/// A module whose current stays at rest what it is in motion: AP 7 counts as AP 6 from there on.
fn holding() -> Module {
    let mut module = Module::new();
    module.sap(Ap::StandbyCurrent, 255);
    module
}

#[test]
fn both_readings_of_the_supply_follow_the_bus() {
    let mut module = holding();
    module.run_ms(100);
    for (supply_v, undervoltage, overvoltage) in [(48.0, 0, 0), (60.0, 0, 1), (24.0, 0, 0), (8.0, 1, 0)] {
        module.set("supply.voltage_v", supply_v);
        module.run_ms(1000);
        let bus_v = module.physical().bus_voltage_v;
        // 0.1 Ω for some 6 W.
        assert!((bus_v - supply_v).abs() < 0.1, "{bus_v} V behind {supply_v} V");
        let reading = module.gap(Ap::SupplyVoltage);
        assert!((f64::from(reading) - 10.0 * bus_v).abs() <= 0.51, "AP 153 = {reading} at {bus_v} V");
        assert_eq!(module.ok(Command::GetInput, 8, 1, 0), reading, "GIO 8 says the same");
        let status = module.gap(Ap::StatusWord);
        assert_eq!((status >> 9 & 1, status >> 10 & 1), (undervoltage, overvoltage), "AP 18 at {supply_v} V");
    }
}

#[test]
fn the_current_of_the_supply_is_the_power_over_the_voltage() {
    let mut module = Module::new();
    module.run_ms(1000);
    let bus_v = module.physical().bus_voltage_v;
    let expected_ma = 1000.0 * (1.5 + COPPER_W) / bus_v;
    let reading = f64::from(module.gap(Ap::DcCurrent));
    assert!((reading - expected_ma).abs() < 1.0, "{reading} mA instead of {expected_ma}");
}

#[test]
fn braking_raises_the_bus() {
    let mut module = Module::on(
        "[[module]]\nkind = \"tmcm-1311\"\n[module.load]\ninertia_kgm2 = 2e-3\nviscous_nm_s_per_rad = 1e-3\n",
    );
    module.sap(Ap::MaxVelocity, 10 * TURN);
    module.sap(Ap::MaxAcceleration, 10 * TURN);
    module.ok(Command::RotateRight, 0, 0, 10 * TURN);
    module.run_ms(3500);
    assert!(module.physical().bus_voltage_v < 48.0);
    let kinetic_j = 0.5 * (2e-3 + 275e-7) * (10.0 * std::f64::consts::TAU).powi(2);
    module.sap(Ap::MaxAcceleration, 20 * TURN);
    module.ok(Command::MotorStop, 0, 0, 0);
    let mut highest_v = 0.0_f64;
    for _ in 0..1000 {
        module.run_ms(1);
        highest_v = highest_v.max(module.physical().bus_voltage_v);
        assert!(module.physical().supply_current_a >= 0.0, "the diode lets nothing back");
    }
    // What copper, board and friction take in the half second is lost; the capacitor gets the rest.
    let charged_j = 0.5 * 2200e-6 * (highest_v * highest_v - 48.0 * 48.0);
    assert!(highest_v > 52.0, "{highest_v} V");
    assert!(charged_j < kinetic_j, "{charged_j} J of {kinetic_j} J");
}

mod switched_off {
    use super::*;

    #[test]
    fn nobody_answers_and_what_was_said_halfway_is_forgotten() {
        let mut module = Module::new();
        let request = serial::encode_request(1, Request::new(Command::GetAxisParameter, 4, 0, 0));
        let (half, rest) = request.split_at(4);
        assert_eq!(module.exchange(half), []);
        module.set("power", "off");
        assert_eq!(module.exchange(rest), []);
        assert_eq!(module.exchange(&request), []);
        module.run_ms(10);
        assert_eq!(module.exchange(&request), []);
        module.set("power", "on");
        assert_eq!(module.exchange(&request).len(), 9);
    }

    #[test]
    fn the_motor_is_free_and_the_rotor_keeps_its_place() {
        let mut module = Module::new();
        module.ok(Command::MoveToPosition, 0, 0, TURN / 4);
        module.arrive();
        module.run_ms(200);
        let turns = module.turns();
        module.set("power", "off");
        module.run_ms(1000);
        let physical = module.physical();
        assert_eq!((physical.coil_a_a, physical.coil_b_a), (0.0, 0.0));
        assert_eq!(physical.supply_current_a, 0.0, "nothing draws");
        assert!((physical.rotor_turns - turns).abs() < 0.001, "{} turns", physical.rotor_turns);

        module.set("load.torque_nm", 0.1);
        module.run_ms(100);
        module.set("load.torque_nm", 0.0);
        module.run_ms(2000);
        let turns = module.turns();
        assert!(turns > 0.3, "anybody can turn it: {turns}");
        module.set("power", "on");
        module.run_ms(500);
        // Field and rotor meet at the next rest position, less than two full steps off.
        assert!((module.turns() - turns).abs() < 0.0101, "{} turns after {turns}", module.turns());
        assert_eq!(module.gap(Ap::ActualPosition), 0, "the module does not know where it is");
    }

    #[test]
    fn the_encoders_counter_starts_at_0_again() {
        for power in ["off", "cycle"] {
            let mut module = Module::new();
            module.ok(Command::MoveToPosition, 0, 0, TURN);
            module.arrive();
            module.run_ms(500);
            assert!((module.gap(Ap::EncoderCounter) - 40_000).abs() < 3);
            module.set("power", power);
            module.set("power", "on");
            module.run_ms(200);
            assert!(module.gap(Ap::EncoderCounter).abs() < 3, "{}", module.gap(Ap::EncoderCounter));
            assert!((module.turns() - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn only_the_eeprom_survives() {
        for power in ["off", "cycle"] {
            let mut module = Module::new();
            module.sap(Ap::MaxVelocity, 1000);
            module.ok(Command::StoreAxisParameter, Ap::MaxVelocity.number(), 0, 0);
            module.sap(Ap::MaxCurrent, 55);
            module.sgp(GlobalParameter::SerialHeartbeat, 77);
            module.set("power", power);
            module.run_ms(10);
            module.set("power", "on");
            assert_eq!(module.gap(Ap::MaxVelocity), 1000);
            assert_eq!(module.gap(Ap::MaxCurrent), 128);
            assert_eq!(module.ggp(GlobalParameter::SerialHeartbeat), 77);
        }
    }

    #[test]
    fn to_switch_on_what_is_on_changes_nothing() {
        let mut module = Module::new();
        module.sap(Ap::MaxCurrent, 55);
        module.run_ms(10);
        module.set("power", "on");
        assert_eq!(module.gap(Ap::MaxCurrent), 55);
        assert_eq!(module.ggp(GlobalParameter::TickTimer), 10);
    }

    #[test]
    fn a_moving_load_coasts_and_the_move_is_forgotten() {
        let mut module = Module::new();
        module.ok(Command::RotateRight, 0, 0, TURN);
        module.run_ms(1500);
        module.set("power", "cycle");
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::ActualVelocity), 0);
        assert_eq!(module.physical().velocity_rpm, 0.0, "caught by the standing field");
    }
}

mod heat {
    use super::*;

    /// The rise after `time_s` towards `final_k`.
    fn rise_k(final_k: f64, time_s: u64, time_constant_s: f64) -> f64 {
        final_k * (1.0 - (-(time_s as f64) / time_constant_s).exp())
    }

    #[test]
    fn winding_and_board_reach_their_closed_form() {
        let mut module = holding();
        let winding_k = 80.0 * COPPER_W / (2.0 * 2.8 * 2.8 * 0.83);
        let board_k = 10.0 * (1.5 + COPPER_W * 0.1 / 0.83);
        for time_s in [1, 60, 600, 3600, 10_800] {
            module.bench.advance_to(time_s * SECOND_NS);
            let physical = module.physical();
            let winding_c = 25.0 + rise_k(winding_k, time_s, 1320.0);
            let board_c = 25.0 + rise_k(board_k, time_s, 120.0);
            assert!((physical.winding_temperature_c - winding_c).abs() < 0.001, "winding after {time_s} s");
            assert!((physical.board_temperature_c - board_c).abs() < 0.001, "board after {time_s} s");
            assert_eq!(module.gap(Ap::ModuleTemperature), board_c.round() as i32, "AP 155");
            assert_eq!(module.ok(Command::GetInput, 9, 1, 0), board_c.round() as i32, "GIO 9");
        }
    }

    #[test]
    fn what_warmed_up_cools_down_without_current() {
        let mut module = Module::new();
        module.bench.advance_to(3600 * SECOND_NS);
        let warm_c = module.physical().winding_temperature_c;
        module.set("power", "off");
        module.bench.advance_by(1320 * SECOND_NS);
        let physical = module.physical();
        let expected_c = 25.0 + (warm_c - 25.0) * (-1.0_f64).exp();
        assert!(
            (physical.winding_temperature_c - expected_c).abs() < 0.01,
            "{}",
            physical.winding_temperature_c
        );
        assert!((physical.board_temperature_c - 25.0).abs() < 0.01, "{}", physical.board_temperature_c);
    }

    #[test]
    fn a_turning_motor_at_full_current_gets_warmer_than_a_standing_one_at_half() {
        let mut module = Module::new();
        module.sap(Ap::MaxCurrent, 255);
        module.ok(Command::RotateRight, 0, 0, TURN);
        module.bench.advance_to(60 * SECOND_NS);
        // 3 A RMS in both coils, a second of which goes by in the ramp; the current is the same.
        let copper_w = 2.0 * 9.0 * 0.83;
        let expected_k = rise_k(80.0 * copper_w / (2.0 * 2.8 * 2.8 * 0.83), 60, 1320.0);
        let rise_k = module.physical().winding_temperature_c - 25.0;
        assert!((rise_k / expected_k - 1.0).abs() < 0.02, "{rise_k} K instead of {expected_k}");
    }

    #[test]
    fn the_surroundings_lift_everything() {
        let mut module = Module::on("temperature_c = 10.0\n[[module]]\nkind = \"tmcm-1311\"\n");
        module.set("power", "off");
        module.run_ms(1000);
        assert!((module.physical().winding_temperature_c - 10.0).abs() < 0.1);
        module.set("temperature_c", 60);
        assert!((module.physical().winding_temperature_c - 60.0).abs() < 0.1);
        assert!((module.physical().board_temperature_c - 60.0).abs() < 0.1);
    }
}
