//! The currents: scale, supply limit, sequencer.

use super::*;

#[test]
fn the_current_settles_at_the_commanded_part_of_the_boards_full_scale() {
    for (current_scale, half_scale, expected_a) in
        [(31, false, PEAK_A), (31, true, PEAK_A / 2.0), (0, false, PEAK_A / 32.0), (15, true, PEAK_A / 4.0)]
    {
        let registers = Registers { current_scale, half_scale, ..registers([248, -124]) };
        let (mut chip, mut pins) = (chip(), pins());
        for _ in 0..200 {
            turn_on(&mut chip, &registers, &mut pins);
        }
        assert!((pins.currents_a[0] - expected_a).abs() < 1e-12);
        assert!((pins.currents_a[1] + expected_a / 2.0).abs() < 1e-12);
    }
}

#[test]
fn the_supply_limits_how_fast_a_current_rises() {
    let (mut chip, mut pins) = (chip(), pins());
    let time_constant_s = pins.inductance_h / pins.resistance_ohm;
    let mut limited = 0;
    for period in 1..=10 {
        let [terminal, _] = turn_on(&mut chip, &registers([248, 0]), &mut pins);
        if terminal != (Terminal::Driven { voltage_v: 48.0 }) {
            break;
        }
        limited = period;
        let rise = 1.0 - libm::exp(-f64::from(period) * PERIOD_S / time_constant_s);
        assert!((pins.currents_a[0] - 48.0 / pins.resistance_ohm * rise).abs() < 1e-9);
    }
    // At 48 V the current reaches 4.24 A after τ ln(1 / (1 − 4.24 A · R / 48 V)) = 202 µs.
    assert_eq!(limited, 4);
    assert!((pins.currents_a[0] - PEAK_A).abs() < 1e-5, "on target one period later");
}

#[test]
fn the_current_follows_a_sine_as_long_as_the_supply_suffices() {
    let worst_error_a = |frequency_hz: f64| {
        let (mut chip, mut pins) = (chip(), pins());
        let mut worst_a = 0.0_f64;
        for period in 0..4000 {
            let vector = Turning::vector(TAU * frequency_hz * f64::from(period) * PERIOD_S);
            turn_on(&mut chip, &registers(vector), &mut pins);
            let error_a = pins.currents_a[1] - PEAK_A * f64::from(vector[1]) / 248.0;
            if period > 200 {
                worst_a = worst_a.max(error_a.abs());
            }
        }
        worst_a
    };
    // The amplitude's voltage is PEAK_A · √(R² + (ωL)²): 48 V at 812 Hz.
    assert!(worst_error_a(100.0) < 1e-4);
    assert!(worst_error_a(700.0) < 1e-4);
    assert!(worst_error_a(1000.0) > 0.5);
}

#[test]
fn the_back_emf_is_made_up_for() {
    let (mut chip, mut pins) = (chip(), Pins { back_emf_v: [20.0, -20.0], ..pins() });
    for _ in 0..20 {
        turn_on(&mut chip, &registers([124, 124]), &mut pins);
    }
    for current_a in pins.currents_a {
        assert!((current_a - PEAK_A / 2.0).abs() < 1e-9);
    }
}

#[test]
fn an_off_time_of_zero_frees_the_motor() {
    let registers = Registers { off_time: 0, ..registers([248, 0]) };
    assert_eq!(
        chip().advance(&registers, &pins(), PERIOD_S),
        [Terminal::Floating { bus_voltage_v: 48.0 }; 2]
    );
}

#[test]
fn the_reset_state_of_the_registers_leaves_the_bridges_off() {
    assert!(matches!(
        chip().advance(&Registers::default(), &pins(), PERIOD_S),
        [Terminal::Floating { .. }, Terminal::Floating { .. }]
    ));
}

#[test]
fn steps_make_the_same_currents_as_the_vector_they_stand_for() {
    let (mut stepped, mut direct) = (chip(), chip());
    let by_step = Registers { coils: Coils::StepDirection { microstep_resolution: 4 }, ..registers([0, 0]) };
    for step in 0..64 {
        let angle = (16.0 * f64::from(step) + 0.5) * PI / 512.0;
        let expected = direct.advance(&registers(Turning::vector(angle)), &pins(), PERIOD_S);
        assert_eq!(stepped.advance(&by_step, &pins(), PERIOD_S), expected, "at step {step}");
        stepped.step(1);
    }
    stepped.step(-32);
    stepped.advance(&by_step, &pins(), PERIOD_S);
    assert_eq!(stepped.status().microstep_position, 512);
}
