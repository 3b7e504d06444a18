//! What switches the bridges off, and what is only reported.

use super::*;

fn floating(bus_voltage_v: f64) -> [Terminal; 2] {
    [Terminal::Floating { bus_voltage_v }; 2]
}

fn shorted_b(rig: &Rig) -> Pins {
    Pins { coil_faults: [CoilFault::None, CoilFault::ShortToGround], ..rig.pins() }
}

fn advance(rig: &mut Rig, pins: &Pins) -> [Terminal; 2] {
    let inputs = Inputs { pins, enabled: rig.enabled, edges: &[] };
    rig.chip.advance(&rig.registers, inputs, PERIOD_S)
}

#[test]
fn a_driver_that_is_not_enabled_lets_the_motor_go_and_counts_steps() {
    let mut rig = Rig::new(factory());
    rig.registers.chopconf.intpol = false;
    rig.enabled = false;
    let edges = Edges { count: 20, first_clock: 0, last_clock: 599, rising_first: true, reverse: false };
    assert_eq!(rig.period(&[edges]), floating(24.0));
    assert_eq!(rig.chip.status().mscnt, 160);
    rig.enabled = true;
    assert!(matches!(rig.period(&[]), [Terminal::Driven { .. }, Terminal::Driven { .. }]));
    rig.registers.chopconf.toff = 0;
    assert_eq!(rig.period(&[]), floating(24.0));
}

#[test]
fn a_short_switches_off_until_the_driver_is_disabled() {
    for stealthchop in [false, true] {
        let mut rig = Rig::new(factory());
        rig.registers.gconf.en_pwm_mode = stealthchop;
        let shorted = shorted_b(&rig);
        for _ in 0..3 {
            advance(&mut rig, &shorted);
        }
        assert_eq!(rig.chip.status().s2g, [false, true]);
        let healthy = rig.pins();
        assert_eq!(advance(&mut rig, &healthy), floating(24.0), "it stays off when the short is gone");
        rig.enabled = false;
        advance(&mut rig, &healthy);
        rig.enabled = true;
        assert_ne!(advance(&mut rig, &healthy), floating(24.0));
        assert_eq!(rig.chip.status().s2g, [false, false]);
    }
}

#[test]
fn without_protection_a_short_is_lived_with() {
    let mut rig = Rig::new(factory());
    rig.registers.chopconf.diss2g = true;
    let shorted = shorted_b(&rig);
    for _ in 0..10 {
        assert!(matches!(advance(&mut rig, &shorted), [Terminal::Driven { .. }, Terminal::Driven { .. }]));
    }
    assert_eq!(rig.chip.status().s2g, [false, false]);
}

#[test]
fn over_temperature_switches_off_until_it_is_colder_than_the_warning() {
    let mut rig = Rig::new(factory());
    for (temperature_c, otpw, ot) in [
        (119.0, false, false),
        (121.0, true, false),
        (150.0, true, true),
        (121.0, true, true),
        (119.0, false, false),
    ] {
        rig.temperature_c = temperature_c;
        let off = rig.period(&[]) == floating(24.0);
        let status = rig.chip.status();
        assert_eq!((off, status.ot, status.otpw), (ot, ot, otpw), "at {temperature_c} °C");
        assert_eq!(status.bits() >> 25 & 3, u32::from(ot) | u32::from(otpw) << 1);
    }
}

#[test]
fn an_open_coil_is_reported_while_the_motor_turns() {
    for (fault, expected) in [(CoilFault::None, false), (CoilFault::Open, true)] {
        let mut rig = Rig::new(factory());
        rig.pulses.interval = CLOCK_HZ / 1600.0;
        for _ in 0..20_000 {
            let edges = [rig.pulses.edges(u32::MAX)];
            let pins = Pins { coil_faults: [fault, CoilFault::None], ..rig.pins() };
            let inputs = Inputs { pins: &pins, enabled: true, edges: &edges };
            let terminals = rig.chip.advance(&rig.registers, inputs, PERIOD_S);
            rig.motor.advance(terminals, 0.0, PERIOD_S);
        }
        assert_eq!(rig.chip.status().ol, [expected, false]);
    }
}
