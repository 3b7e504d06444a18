extern crate std;

use motor_physics::pmsm::Bridge;
use proptest::prelude::*;

use super::*;

const BOARD: Board = Board { on_resistance_ohm: 0.02, overcurrent_a: 30.0 };
const PERIOD: u16 = 32_768;

const PINS: Pins =
    Pins { phase_currents_a: [0.0; 3], bus_voltage_v: 24.0, open_phase: None, shorted_phase: None };

fn on(duties: [u16; 3]) -> Gates {
    Gates { duties, enabled: true }
}

const OFF: Gates = Gates { duties: [PERIOD / 2; 3], enabled: false };

fn voltage(bridge: Bridge) -> [f64; 2] {
    match bridge {
        Bridge::Driven { voltage_alpha_beta_v } => voltage_alpha_beta_v,
        other => panic!("{other:?}"),
    }
}

#[test]
fn duties_are_parts_of_the_supply() {
    let mut chip = Tmc603::new(BOARD);
    let [alpha, beta] = voltage(chip.advance(&on([PERIOD, 0, 0]), &PINS));
    assert!(
        (alpha - 16.0).abs() < 1e-12 && beta.abs() < 1e-12,
        "two thirds of 24 V along U: {alpha}, {beta}"
    );
    let [alpha, beta] = voltage(chip.advance(&on([0, PERIOD, 0]), &PINS));
    assert!((alpha + 8.0).abs() < 1e-12 && (beta - 24.0 / libm::sqrt(3.0)).abs() < 1e-12);
    assert_eq!(chip.advance(&on([u16::MAX, 0, 0]), &PINS), chip.advance(&on([PERIOD, 0, 0]), &PINS));
    assert!(!chip.error());
}

#[test]
fn the_transistors_take_their_part() {
    let mut chip = Tmc603::new(BOARD);
    let pins = Pins { phase_currents_a: [10.0, -5.0, -5.0], ..PINS };
    let [alpha, beta] = voltage(chip.advance(&on([PERIOD / 2; 3]), &pins));
    assert!((alpha + 0.2).abs() < 1e-12 && beta.abs() < 1e-12, "20 mΩ · 10 A: {alpha}, {beta}");
    assert!((chip.conduction_loss_per_copper_loss(0.4) - 0.05).abs() < 1e-12);
}

#[test]
fn off_no_transistor_is_on() {
    let mut chip = Tmc603::new(BOARD);
    assert_eq!(chip.advance(&OFF, &PINS), Bridge::Floating { bus_voltage_v: 24.0 });
    assert!(!chip.error());
}

#[test]
fn an_open_phase_is_told_to_the_motor_and_is_no_error() {
    let mut chip = Tmc603::new(BOARD);
    let pins = Pins { open_phase: Some(Phase::V), ..PINS };
    let bridge = chip.advance(&on([PERIOD, 0, 0]), &pins);
    assert!(matches!(bridge, Bridge::DrivenOpen { open_phase: 1, .. }), "{bridge:?}");
    assert!(!chip.error());
}

#[test]
fn a_short_stops_the_stage_until_it_is_disabled() {
    for (phase, duties) in [(Phase::U, [1, 0, 0]), (Phase::V, [0, PERIOD, 0]), (Phase::W, [0, 0, PERIOD / 2])]
    {
        let mut chip = Tmc603::new(BOARD);
        let shorted = Pins { shorted_phase: Some(phase), ..PINS };
        chip.advance(&on([0; 3]), &shorted);
        assert!(!chip.error(), "the lower transistors do not see it");
        let bridge = chip.advance(&on(duties), &shorted);
        assert!(chip.error() && matches!(bridge, Bridge::Floating { .. }));
        let bridge = chip.advance(&on(duties), &PINS);
        assert!(chip.error() && matches!(bridge, Bridge::Floating { .. }), "mended, but not forgotten");
        chip.advance(&OFF, &PINS);
        assert!(!chip.error());
        assert!(matches!(chip.advance(&on(duties), &PINS), Bridge::Driven { .. }));
    }
}

#[test]
fn an_overcurrent_of_either_sign_stops_the_stage_too() {
    for current_a in [31.0, -31.0] {
        let mut chip = Tmc603::new(BOARD);
        let pins = |current_a| Pins { phase_currents_a: [0.0, current_a, -current_a], ..PINS };
        chip.advance(&on([0; 3]), &pins(29.0));
        assert!(!chip.error());
        let bridge = chip.advance(&on([0; 3]), &pins(current_a));
        assert!(chip.error() && matches!(bridge, Bridge::Floating { .. }));
        chip.advance(&on([0; 3]), &PINS);
        assert!(chip.error(), "the current has died, the error has not");
        chip.advance(&OFF, &pins(current_a));
        assert!(!chip.error(), "a stage that is off measures nothing");
    }
}

#[test]
fn too_little_supply_is_an_error_for_as_long_as_it_lasts() {
    let mut chip = Tmc603::new(BOARD);
    let mut error_at = |bus_voltage_v| {
        let pins = Pins { bus_voltage_v, ..PINS };
        let off = matches!(chip.advance(&on([0; 3]), &pins), Bridge::Floating { .. });
        assert_eq!(off, chip.error());
        off
    };
    let errors = [24.0, 9.0, 8.9, 9.2, 9.4, 9.5, 9.2, 0.0, 24.0].map(&mut error_at);
    assert_eq!(errors, [false, false, true, true, true, false, false, true, false]);
}

/// The formula as the manual prints it.
fn temperature_c(reading: u16) -> f64 {
    let resistance_kohm = 9011.2 / f64::from(reading) - 2.2;
    3434.0 * 298.16 / (3434.0 + libm::log(resistance_kohm / 10.0) * 298.16) - 273.16
}

#[test]
fn the_manuals_examples() {
    assert!((temperature_c(1000) - 35.3).abs() < 0.05 && (temperature_c(1200) - 42.3).abs() < 0.05);
    assert!(ntc_reading(35.3).abs_diff(1000) <= 1, "{}", ntc_reading(35.3));
    assert!(ntc_reading(42.3).abs_diff(1200) <= 1, "{}", ntc_reading(42.3));
    assert_eq!(ntc_reading(25.0), 739, "9011.2 / 12.2");
}

#[test]
fn every_reading_comes_back_and_the_ends_hold() {
    for reading in 1..=4095 {
        assert_eq!(ntc_reading(temperature_c(reading)), reading);
    }
    for (temperature_c, reading) in
        [(-273.16, 0), (-1e9, 0), (1e9, 4095), (f64::INFINITY, 4095), (f64::NAN, 0)]
    {
        assert_eq!(ntc_reading(temperature_c), reading, "{temperature_c}");
    }
}

proptest! {
    /// No phase voltage exceeds two thirds of the supply, and what the duties have in common does nothing.
    #[test]
    fn the_voltage_is_what_differs_between_the_duties(duties: [u16; 3], common in 0_u16..1000, bus_voltage_v in 9.0..50.0) {
        let mut chip = Tmc603::new(BOARD);
        let pins = Pins { bus_voltage_v, ..PINS };
        let duties = duties.map(|duty| duty % (PERIOD - 1000));
        let [alpha, beta] = voltage(chip.advance(&on(duties), &pins));
        prop_assert!(libm::hypot(alpha, beta) <= bus_voltage_v * (2.0 / 3.0) + 1e-9);
        let [raised_alpha, raised_beta] = voltage(chip.advance(&on(duties.map(|duty| duty + common)), &pins));
        prop_assert!((alpha - raised_alpha).abs() < 1e-9 && (beta - raised_beta).abs() < 1e-9);
    }
}
