//! Every step arrives at the shaft, as long as the motor can follow.

use super::*;

/// The rotor's turns from where it stood, once the field that interpolation delays has arrived.
fn turned(rig: &mut Rig, act: impl FnOnce(&mut Rig)) -> f64 {
    rig.wait(0.3);
    let from = rig.motor.turns();
    act(rig);
    rig.wait(0.5);
    rig.motor.turns() - from
}

/// Friction holds the rotor back from where the hold current's field points.
const SLACK_TURNS: f64 = 0.0005;

fn assert_turns(turns: f64, expected: f64, what: &str) {
    assert!((turns - expected).abs() < SLACK_TURNS, "{turns} turns, expected {expected}: {what}");
}

#[test]
fn sixteen_thousand_pulses_at_a_sixteenth_are_five_turns() {
    for intpol in [true, false] {
        let mut rig = Rig::new(factory());
        rig.registers.chopconf.intpol = intpol;
        let turns = turned(&mut rig, |rig| rig.go(2 * 16_000, 16_000.0));
        assert_turns(turns, 5.0, if intpol { "interpolated" } else { "not interpolated" });
        rig.pulses.reverse = true;
        let turns = turned(&mut rig, |rig| rig.go(2 * 16_000, 16_000.0));
        assert_turns(turns, -5.0, "and back");
    }
}

#[test]
fn directions_edges_and_resolutions_in_any_order_keep_count() {
    let mut rig = Rig::new(factory());
    let mut expected = 0.0;
    for (mres, dedge, reverse, edges, frequency_hz) in [
        (4, false, false, 6400, 8000.0),
        (4, true, true, 6400, 8000.0),
        (0, false, false, 102_400, 128_000.0),
        (7, true, false, 300, 500.0),
        (8, false, true, 200, 200.0),
        (2, true, true, 777, 1000.0),
    ] {
        rig.registers.chopconf.mres = mres;
        rig.registers.chopconf.dedge = dedge;
        rig.pulses.reverse = reverse;
        let rising = (edges + u32::from(!rig.pulses.rising)) / 2;
        let steps = if dedge { edges } else { rising };
        let sign = if reverse { -1.0 } else { 1.0 };
        expected += sign * f64::from(steps << mres) / 51_200.0;
        turned(&mut rig, |rig| rig.go(edges, frequency_hz));
        assert_turns(rig.motor.turns(), expected, "all moves so far");
    }
}

#[test]
fn a_hundred_thousand_pulses_a_second_arrive_one_by_one() {
    let mut rig = Rig::new(factory());
    rig.registers.chopconf.mres = 0;
    let turns = turned(&mut rig, |rig| {
        rig.ramp(2 * 20_000, 100.0, 100_000.0);
        rig.ramp(2 * 216_000, 100_000.0, 100_000.0);
        rig.ramp(2 * 20_000, 100_000.0, 100.0);
    });
    assert_turns(turns, 5.0, "256 000 pulses at 1/256");
}

#[test]
fn a_frequency_that_the_motor_cannot_follow_loses_steps() {
    let mut rig = Rig::new(factory());
    // 20 turns a second at once.
    let turns = turned(&mut rig, |rig| rig.run(64_000.0, 0.5));
    assert!(turns < 5.0, "{turns} of 10 turns");
    let steps = turns * 50.0;
    assert!(
        (steps - libm::round(steps)).abs() < 0.03,
        "lost four full steps at a time: {steps} electrical periods"
    );
}

#[test]
fn interpolation_makes_steps_of_a_sixteenth_as_smooth_as_those_of_a_256th() {
    let roughness = |mres: u8, intpol: bool| {
        let mut rig = Rig::new(factory());
        (rig.registers.chopconf.mres, rig.registers.chopconf.intpol) = (mres, intpol);
        let frequency_hz = 200.0 * f64::from(256 >> mres);
        rig.run(frequency_hz, 0.5);
        let (mut before, mut largest) = (rig.motor.currents_a[0], 0.0_f64);
        for _ in 0..2000 {
            rig.run(frequency_hz, PERIOD_S);
            let now = rig.motor.currents_a[0];
            largest = largest.max((now - before).abs());
            before = now;
        }
        largest
    };
    let [smooth, interpolated, stepped] = [roughness(0, true), roughness(4, true), roughness(4, false)];
    assert!(interpolated < 1.5 * smooth, "{interpolated} A against {smooth} A in 50 µs");
    assert!(stepped > 4.0 * smooth, "{stepped} A against {smooth} A in 50 µs");
}

#[test]
fn without_a_pulse_for_2_to_the_20_clocks_it_stands_with_tstep_at_its_end() {
    let mut rig = Rig::new(factory());
    rig.run(16_000.0, 0.1);
    let status = rig.chip.status();
    assert_eq!((status.tstep, status.stst), (46, false), "750 clocks for 16 microsteps");
    rig.wait(0.088);
    let status = rig.chip.status();
    assert_eq!((status.tstep, status.stst), (STANDSTILL_TSTEP, true));
    assert_eq!(status.bits() >> 31, 1);
}
