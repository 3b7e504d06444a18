//! What switches the bridges off, and what is only reported.

use super::*;

#[test]
fn a_short_to_ground_switches_off_until_the_off_time_was_zero() {
    let (mut chip, on) = (chip(), registers([100, -200]));
    let shorted = Pins { coil_faults: [CoilFault::None, CoilFault::ShortToGround], ..pins() };
    for _ in 0..2 {
        let [a, b] = chip.advance(&on, &shorted, PERIOD_S);
        assert!(matches!((a, b), (Terminal::Driven { .. }, Terminal::Floating { .. })));
    }
    let off = [Terminal::Floating { bus_voltage_v: 48.0 }; 2];
    assert_eq!(chip.advance(&on, &shorted, PERIOD_S), off);
    assert_eq!(chip.status().short_to_ground, [false, true]);
    assert_eq!(chip.advance(&on, &pins(), PERIOD_S), off, "it stays off when the short is gone");
    chip.advance(&Registers { off_time: 0, ..on }, &pins(), PERIOD_S);
    assert_eq!(chip.status().short_to_ground, [false, false]);
    assert!(matches!(
        chip.advance(&on, &pins(), PERIOD_S),
        [Terminal::Driven { .. }, Terminal::Driven { .. }]
    ));
}

#[test]
fn without_protection_a_shorted_bridge_pushes_but_cannot_pull() {
    let mut chip = chip();
    let shorted = Pins { coil_faults: [CoilFault::ShortToGround; 2], ..pins() };
    let registers = Registers { short_protection_disabled: true, ..registers([200, -200]) };
    for _ in 0..10 {
        let terminals = chip.advance(&registers, &shorted, PERIOD_S);
        assert_eq!(terminals, [Terminal::Driven { voltage_v: 48.0 }, Terminal::Driven { voltage_v: 0.0 }]);
    }
    assert_eq!(chip.status().short_to_ground, [false, false]);
}

#[test]
fn over_temperature_switches_off_until_it_is_colder() {
    let mut chip = chip();
    for (temperature_c, driven) in [(149.0, true), (151.0, false), (121.0, false), (119.0, true)] {
        let terminals = chip.advance(&registers([100, 100]), &Pins { temperature_c, ..pins() }, PERIOD_S);
        assert_eq!(matches!(terminals[0], Terminal::Driven { .. }), driven, "at {temperature_c} °C");
        assert_eq!(chip.status().over_temperature, !driven);
        assert!(chip.status().over_temperature_warning);
    }
}

#[test]
fn an_open_coil_is_reported_while_the_motor_turns_and_only_for_that_coil() {
    let run = |fault: CoilFault| {
        let (mut chip, mut pins) = (chip(), Pins { coil_faults: [CoilFault::None, fault], ..pins() });
        for period in 0..2000 {
            let vector = Turning::vector(f64::from(period) * 0.02);
            turn_on(&mut chip, &registers(vector), &mut pins);
        }
        chip.status().open_load
    };
    assert_eq!(run(CoilFault::None), [false, false]);
    assert_eq!(run(CoilFault::Open), [false, true]);
}

#[test]
fn bridges_that_are_off_say_nothing_about_the_coils() {
    let (mut chip, mut pins) = (chip(), pins());
    let mut turn = |temperature_c: f64, periods: u32| {
        pins.temperature_c = temperature_c;
        for period in 0..periods {
            turn_on(&mut chip, &registers(Turning::vector(f64::from(period) * 0.02)), &mut pins);
        }
        chip.status().open_load
    };
    assert_eq!(turn(25.0, 50), [false, false]);
    assert_eq!(turn(151.0, 2000), [false, false]);
    assert_eq!(turn(25.0, 2000), [false, false]);
}

#[test]
fn a_half_wave_that_a_shutdown_cuts_off_is_not_judged() {
    let mut chip = chip();
    // Too short for the currents to come up.
    for (value, temperature_c) in [(200, 25.0), (200, 25.0), (200, 151.0), (-200, 25.0), (-200, 25.0)] {
        chip.advance(&registers([value; 2]), &Pins { temperature_c, ..pins() }, PERIOD_S);
    }
    assert_eq!(chip.status().open_load, [false, false]);
}

#[test]
fn steps_of_a_whole_period_are_no_standstill() {
    let (mut chip, pins) = (chip(), pins());
    let registers =
        Registers { coils: Coils::StepDirection { microstep_resolution: 8 }, ..registers([0, 0]) };
    for _ in 0..1400 {
        chip.step(4);
        chip.advance(&registers, &pins, PERIOD_S);
    }
    assert!(!chip.status().standstill);
}

#[test]
fn standstill_is_reported_and_ends_with_the_next_current() {
    let (mut chip, pins) = (chip(), pins());
    for _ in 0..1312 {
        chip.advance(&registers([248, 0]), &pins, PERIOD_S);
    }
    assert!(chip.status().standstill);
    chip.advance(&registers([248, 2]), &pins, PERIOD_S);
    assert!(!chip.status().standstill);
}
