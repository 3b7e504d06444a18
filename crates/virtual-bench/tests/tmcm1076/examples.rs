//! The example benches of the TMCM-1076 do what their comments say.

use crate::common::step::StepDriver;
use tmcl_tables::tmcm_1076::AxisParameter as Ap;

macro_rules! example {
    ($name:literal) => {
        StepDriver::on(include_str!(concat!("../../../../examples/benches/", $name)))
    };
}

#[test]
fn a_ramp_of_pulses_arrives() {
    let mut module = example!("pulses-ramp.toml");
    module.run_ms(2000);
    assert!((module.physical().velocity_rpm - 300.0).abs() < 15.0, "{} rpm", module.physical().velocity_rpm);
    module.run_ms(4000);
    assert!((module.turns() - 15.0).abs() < 0.001, "{} turns", module.turns());
}

#[test]
fn pulses_that_begin_too_fast_stall_the_motor_and_a_ramp_does_not() {
    let mut module = example!("pulses-stall.toml");
    module.run_ms(2900);
    let stalled = module.turns();
    assert!(stalled < 6.0, "{stalled} of eight turns");
    module.run_ms(4000);
    assert!((module.turns() - stalled - 8.0).abs() < 0.001, "{} turns", module.turns() - stalled);
}

#[test]
fn coolstep_follows_the_load() {
    let mut module = example!("pulses-coolstep.toml");
    for (parameter, value) in [
        (Ap::CoolstepHysteresisStart, 4),
        (Ap::CoolstepHysteresis, 2),
        (Ap::CoolstepUpStep, 2),
        (Ap::CoolstepDownStep, 2),
        (Ap::CoolstepMinCurrent, 1),
        (Ap::Stallguard2Filter, 1),
        (Ap::CoolstepThresholdVelocity, 200),
    ] {
        module.sap(parameter, value);
    }
    let mut scales = [2900, 1900, 2000].map(|ms| {
        module.run_ms(ms);
        module.gap(Ap::CoolstepActualCurrent)
    });
    let [light, loaded, _] = scales;
    assert!(light < 14 && loaded > 16, "{scales:?}");
    scales.reverse();
    assert!(scales[0] < 14, "{scales:?}");
    // 5 turns a second, but for the second of the ramp.
    let expected = 5.0 * 6.8 - 2.5;
    assert!((module.turns() - expected).abs() < 0.02, "{} turns, not {expected}", module.turns());
}

#[test]
fn chop_chooses_stealthchop_at_a_standstill_and_spreadcycle_at_once() {
    let mut module = example!("pulses-stealthchop.toml");
    module.sap(Ap::Pwmconf, -1_005_846_498);
    module.run_ms(2900);
    let from = module.turns();
    module.run_ms(1000);
    assert!(module.gap(Ap::LoadValue) > 0, "an amplitude of stealthChop");
    assert!((module.turns() - from - 0.5).abs() < 0.002, "{} turns in a second", module.turns() - from);
    module.run_ms(200);
    assert_eq!(module.gap(Ap::LoadValue), 0);
}
