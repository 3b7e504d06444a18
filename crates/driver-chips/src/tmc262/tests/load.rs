//! stallGuard2 and coolStep on a turning motor.

use super::*;

fn reading(velocity_rps: f64, load_rad: f64, bus_voltage_v: f64) -> f64 {
    let mut turning = Turning::new(velocity_rps);
    turning.pins.bus_voltage_v = bus_voltage_v;
    f64::from(turning.reading(load_rad, 3.0))
}

#[test]
fn stallguard_falls_with_load_to_zero_at_ninety_degrees_and_stays_there() {
    let mut before = 501.0;
    for degrees in (0..=80).step_by(5) {
        let load = f64::from(degrees).to_radians();
        let value = reading(5.0, load, 48.0);
        let expected = 500.0 * (1.0 - libm::sin(load));
        assert!((value - expected).abs() < 3.0, "{value} at {degrees}°, expected {expected}");
        assert!(value < before);
        assert!((value - reading(5.0, -load, 48.0)).abs() < 3.0, "a load that drives is a load too");
        before = value;
    }
    for degrees in [90.0_f64, 120.0, 180.0, 269.0] {
        assert!(reading(5.0, degrees.to_radians(), 48.0) < 2.0, "at {degrees}°");
    }
}

#[test]
fn stallguard_is_the_same_in_both_directions() {
    assert!((reading(5.0, 0.5, 48.0) - reading(-5.0, -0.5, 48.0)).abs() < 4.0);
}

#[test]
fn stallguard_needs_speed() {
    for (velocity_rps, expected) in [(0.1, 50.0), (0.5, 250.0), (1.0, 500.0), (3.0, 500.0)] {
        let value = reading(velocity_rps, 0.0, 48.0);
        assert!((value - expected).abs() < 3.0, "{value} at {velocity_rps} rps");
    }
}

#[test]
fn stallguard_needs_headroom_of_a_quarter_of_the_supply() {
    let velocity_rps = 5.0;
    let drop_v = KM * velocity_rps * TAU + PEAK_A * 0.83;
    for (bus_voltage_v, part) in [(drop_v / 0.7, 1.0), (drop_v / 0.9, 0.4), (drop_v * 0.99, 0.0)] {
        let value = reading(velocity_rps, 0.0, bus_voltage_v);
        assert!((value - 500.0 * part).abs() < 3.0, "{value} at {bus_voltage_v} V");
    }
}

#[test]
fn the_threshold_moves_the_reading_by_eight_a_step() {
    for (threshold, expected) in [(0, 500.0), (10, 580.0), (-20, 340.0), (-64, 0.0), (63, 1004.0)] {
        let mut turning = Turning::new(5.0);
        turning.registers.stallguard_threshold = threshold;
        let value = turning.reading(0.0, 3.0);
        assert!((f64::from(value) - expected).abs() < 3.0, "{value} with {threshold}");
        assert_eq!(turning.chip.status().stall, value == 0);
    }
}

#[test]
fn the_filter_makes_one_reading_of_the_mean_of_four_full_steps() {
    let changes = |filtered: bool| {
        let mut turning = Turning::new(2.0);
        turning.registers.stallguard_filter = filtered;
        turning.reading(0.0, 8.1);
        let (mut readings, mut lowest, mut highest) = (0, 1023, 0);
        let mut before = turning.chip.status().stallguard_value;
        for period in 0..9000 {
            // The load changes from one full step to the next.
            let quadrant = libm::floor(turning.phase / (PI / 2.0)) as i64;
            turning.period(if quadrant % 2 == 0 { 0.2 } else { 1.0 });
            let value = turning.chip.status().stallguard_value;
            if period >= 1000 {
                readings += u32::from(value != before);
                (lowest, highest) = (lowest.min(value), highest.max(value));
            }
            before = value;
        }
        (readings, lowest, highest)
    };
    let (readings, lowest, highest) = changes(false);
    assert!(readings >= 150, "{readings} in 160 full steps");
    assert!(lowest < 100 && highest > 370, "{lowest} to {highest}");
    let (readings, lowest, highest) = changes(true);
    assert!(readings <= 40, "{readings} in 160 full steps");
    let mean = 500.0 * (1.0 - (libm::sin(0.2) + libm::sin(1.0)) / 2.0);
    for extreme in [lowest, highest] {
        assert!((f64::from(extreme) - mean).abs() < 8.0, "{lowest} to {highest}, mean {mean}");
    }
}

#[test]
fn a_reading_holds_nothing_from_before_the_bridges_were_off() {
    let mut turning = Turning::new(2.0);
    turning.registers.stallguard_filter = true;
    turning.reading(0.0, 6.5);
    turning.registers.off_time = 0;
    turning.period(0.0);
    turning.registers.off_time = 5;
    let value = f64::from(turning.reading(1.0, 5.2));
    let expected = 500.0 * (1.0 - libm::sin(1.0));
    assert!((value - expected).abs() < 3.0, "{value}, expected {expected}");
}

#[test]
fn a_rotor_that_swings_about_one_place_reads_as_a_stall() {
    let mut turning = Turning::new(5.0);
    turning.registers.stallguard_filter = true;
    turning.reading(0.3, 12.0);
    assert!(!turning.chip.status().stall);
    for period in 0..4000 {
        turning.phase += 5.0 * POLE_PAIRS * TAU * PERIOD_S;
        // 250 Hz electrical slip: the rotor swings by it, once in four full steps.
        let velocity_rps = 2.0 * libm::sin(TAU * 250.0 * f64::from(period) * PERIOD_S);
        let emf_v = KM * velocity_rps * TAU;
        turning.pins.rotor_velocity_rps = velocity_rps;
        turning.pins.back_emf_v = [0.0, emf_v];
        turning.registers.coils = Coils::Direct(Turning::vector(turning.phase));
        turning.chip.advance(&turning.registers, &turning.pins, PERIOD_S);
    }
    let value = turning.chip.status().stallguard_value;
    assert!(value < 10, "{value}");
}

/// Runs a motor whose load needs this part of its torque at full current; the load angle follows from the current in use.
fn scale_under_load(turning: &mut Turning, load: f64, periods: u32) -> u8 {
    for _ in 0..periods {
        let torque = f64::from(turning.chip.status().current_scale + 1) / 32.0;
        turning.period(libm::asin((load / torque).min(1.0)));
    }
    turning.chip.status().current_scale
}

#[test]
fn coolstep_saves_current_under_light_load_and_gives_it_back_under_load() {
    for (quarter_minimum, bound) in [(false, 15), (true, 7)] {
        let mut turning = Turning::new(5.0);
        let coolstep =
            CoolStep { lower_threshold: 4, hysteresis: 2, up_step: 1, down_step: 2, quarter_minimum };
        turning.registers.coolstep = coolstep;
        assert_eq!(scale_under_load(&mut turning, 0.05, 4000), bound);
        // The currents of the bridges are those of the scale in use: at this angle nothing but R · I + e is needed.
        let half = f64::from(bound + 1) / 32.0;
        let Coils::Direct([value, _]) = turning.registers.coils else { unreachable!() };
        turning.pins.currents_a = [PEAK_A * half * f64::from(value) / 248.0, 0.0];
        let terminals = turning.chip.advance(
            &turning.registers,
            &Pins { back_emf_v: [0.0; 2], ..turning.pins },
            PERIOD_S,
        );
        let expected_v = turning.pins.resistance_ohm * turning.pins.currents_a[0];
        assert!(
            matches!(terminals[0], Terminal::Driven { voltage_v } if (voltage_v - expected_v).abs() < 1e-9)
        );
        // 60 % of the torque at full current: SG = 500 · (1 − 0.6 · 32 / (scale + 1)) is in the band, 128 to 223, from 25 on.
        let scale = scale_under_load(&mut turning, 0.6, 4000);
        assert!((25..=28).contains(&scale), "{scale}");
        assert!(turning.chip.status().stallguard_value >= 128);
    }
}
