//! Currents, choppers, thresholds and coolStep of the TMCM-1076, judged by the coils (§4, §5.1, §5.2, §6; decisions 7.6, 7.7).

use crate::common::step::{CHOP, ENABLE, STANDSTILL, StepDriver};
use tmcl_tables::tmcm_1076::AxisParameter as Ap;

/// PWMCONF of the TMC5160's data sheet: automatic tuning.
const AUTOMATIC: i32 = 0xC40C_001E_u32.cast_signed();

/// With stealthChop latched at a standstill, and 0.2 s to find its amplitude.
fn stealth() -> StepDriver {
    let mut module = StepDriver::new();
    module.sap(Ap::Pwmconf, AUTOMATIC);
    module.set(CHOP, 1);
    module.run_ms(300);
    module
}

/// AP 206 tells the choppers apart: PWM_SCALE_SUM with stealthChop, with spreadCycle the stallGuard2 value, 0 below AP 182.
fn is_stealthchop(module: &mut StepDriver) -> bool {
    module.gap(Ap::LoadValue) != 0
}

#[test]
fn the_factory_s_currents_are_2_3_and_0_29_amperes_rms() {
    let mut module = StepDriver::new();
    module.run_ms(200);
    assert!((module.rms_a() - 3.0 * 3.0 / 31.0).abs() < 1e-3, "{} A at rest", module.rms_a());
    assert_eq!(module.gap(Ap::CoolstepActualCurrent), 3);
    module.turn(1600.0);
    // 20 electrical periods.
    for rms_a in module.coils_rms_a(16_000) {
        assert!((rms_a - 24.0 / 31.0 * 3.0).abs() < 0.005, "{rms_a} A in motion");
    }
    assert_eq!(module.gap(Ap::CoolstepActualCurrent), 24);
}

#[test]
fn the_standby_current_comes_by_steps_of_ap_9() {
    for (delay, expected_ms) in [(0, 0.0), (1, 21.0 * 21.8453), (4, 4.0 * 21.0 * 21.8453)] {
        let mut module = StepDriver::new();
        module.sap(Ap::StandbyCurrentDelay, delay);
        module.turn(1600.0);
        module.set("step_dir.acceleration_hz_per_s", 0);
        module.set("step_dir.frequency_hz", 0);
        let mut fell_ms = [0; 2];
        for ms in 1..3000 {
            module.run_ms(1);
            let scale = module.gap(Ap::CoolstepActualCurrent);
            if scale == 24 {
                fell_ms[0] = ms;
            }
            if scale != 3 {
                fell_ms[1] = ms;
            }
        }
        // Standstill after 2^20 clocks, TPOWERDOWN of 10 · 2^18 clocks; then a step each AP 9 · 2^18 clocks.
        let [first, last] = fell_ms.map(f64::from);
        let begin = 87.4 + 218.5 + f64::from(delay) * 21.8453;
        assert!((first - begin).abs() < 2.0, "{first} ms, not {begin}");
        assert!(
            (last - first - (expected_ms - f64::from(delay) * 21.8453).max(0.0)).abs() < 2.0,
            "{last} ms"
        );
    }
}

#[test]
fn tstep_is_read_at_every_speed_and_at_standstill() {
    let mut module = StepDriver::new();
    assert_eq!(module.gap(Ap::Tstep), STANDSTILL);
    for (resolution, frequency_hz, tstep) in
        [(4, 1600.0, 468), (4, 3200.0, 234), (8, 100_000.0, 120), (0, 500.0, 93)]
    {
        module.sap(Ap::MicrostepResolution, resolution);
        module.set("step_dir.acceleration_hz_per_s", 0);
        module.set("step_dir.frequency_hz", frequency_hz);
        module.run_ms(20);
        assert_eq!(module.gap(Ap::Tstep), tstep, "{frequency_hz} Hz");
    }
    module.set("step_dir.frequency_hz", 0);
    module.run_ms(90);
    assert_eq!(module.gap(Ap::Tstep), STANDSTILL);
}

#[test]
fn chop_raised_while_moving_waits_for_standstill_and_lowered_acts_at_once() {
    let mut module = StepDriver::new();
    module.sap(Ap::Pwmconf, AUTOMATIC);
    module.turn(1600.0);
    module.set(CHOP, 1);
    for _ in 0..500 {
        module.run_ms(1);
        assert!(!is_stealthchop(&mut module));
    }
    module.set("step_dir.acceleration_hz_per_s", 0);
    module.set("step_dir.frequency_hz", 0);
    module.run_ms(80);
    assert!(!is_stealthchop(&mut module), "no standstill yet: 2^20 clocks are 87 ms");
    module.run_ms(20);
    assert!(is_stealthchop(&mut module));
    module.turn(1600.0);
    assert!(is_stealthchop(&mut module), "in motion, too");
    module.set(CHOP, 0);
    module.run_ticks(2);
    assert!(!is_stealthchop(&mut module), "at once");
    module.set(CHOP, 1);
    module.run_ms(100);
    assert!(!is_stealthchop(&mut module));
}

#[test]
fn chop_raised_without_power_waits_for_enable() {
    let mut module = StepDriver::new();
    module.set(ENABLE, 1);
    module.set(CHOP, 1);
    module.run_ms(200);
    assert!(!is_stealthchop(&mut module));
    module.set(ENABLE, 0);
    module.run_ms(100);
    assert!(is_stealthchop(&mut module));
}

#[test]
fn stealthchop_holds_and_runs_with_nearly_the_same_currents() {
    let mut module = stealth();
    module.run_ms(300);
    // A step of the amplitude is 77 mA here.
    assert!((module.rms_a() - 0.29).abs() < 0.04, "{} A at rest", module.rms_a());
    module.turn(1600.0);
    module.run_ms(1000);
    assert!((module.rms_a() - 2.32).abs() < 0.2, "{} A in motion", module.rms_a());
}

#[test]
fn tstep_written_to_136_switches_at_that_speed_with_a_sixteenth_of_hysteresis() {
    let mut module = stealth();
    module.turn(1600.0);
    let tstep = module.gap(Ap::Tstep);
    module.sap(Ap::StealthchopVelocityLimit, tstep);
    module.run_ms(100);
    assert!(is_stealthchop(&mut module));
    for (frequency_hz, stealthchop) in [
        (1650.0, true),
        (1690.0, true),
        (1750.0, false),
        (1650.0, false),
        (1610.0, false),
        (1590.0, true),
        (1690.0, true),
    ] {
        module.set("step_dir.frequency_hz", frequency_hz);
        module.run_ms(200);
        assert_eq!(is_stealthchop(&mut module), stealthchop, "at {frequency_hz} Hz");
    }
}

/// coolStep with SEMIN 4, SEMAX 2 and quick steps, from `tstep` on.
fn set_coolstep(module: &mut StepDriver, tstep: i32) {
    for (parameter, value) in [
        (Ap::CoolstepHysteresisStart, 4),
        (Ap::CoolstepHysteresis, 2),
        (Ap::CoolstepUpStep, 2),
        (Ap::CoolstepDownStep, 2),
        (Ap::CoolstepMinCurrent, 1),
        (Ap::Stallguard2Filter, 1),
        (Ap::CoolstepThresholdVelocity, tstep),
    ] {
        module.sap(parameter, value);
    }
}

#[test]
fn tstep_written_to_182_switches_coolstep_at_that_speed_with_the_hysteresis() {
    let mut module = StepDriver::new();
    module.turn(8000.0);
    let tstep = module.gap(Ap::Tstep);
    assert_eq!(tstep, 93);
    set_coolstep(&mut module, tstep);
    for (frequency_hz, saves) in
        [(8000.0, false), (8500.0, false), (8900.0, true), (8300.0, true), (7900.0, false), (8300.0, false)]
    {
        module.set("step_dir.frequency_hz", frequency_hz);
        module.run_ms(1000);
        assert_eq!(module.gap(Ap::CoolstepActualCurrent) < 24, saves, "at {frequency_hz} Hz");
        assert_eq!(module.gap(Ap::LoadValue) > 0, saves, "stallGuard2 at {frequency_hz} Hz");
    }
    // And above AP 22 it ends.
    module.sap(Ap::HighVelocityThreshold, 60);
    module.set("step_dir.frequency_hz", 13_500);
    module.run_ms(1000);
    assert_eq!(module.gap(Ap::CoolstepActualCurrent), 24);
}

#[test]
fn coolstep_holds_the_torque_under_a_load_and_saves_current_without() {
    let mut module = StepDriver::new();
    set_coolstep(&mut module, 200);
    module.turn(16_000.0);
    module.run_ms(1000);
    let light_a = module.rms_a();
    assert!(light_a < 1.2, "{light_a} A without load, 2.32 A without coolStep");
    let mut other = StepDriver::new();
    other.turn(16_000.0);
    other.run_ms(1000);
    assert!((other.rms_a() - 2.32).abs() < 0.1, "{} A", other.rms_a());
    let from = module.turns();
    // More than 1.2 A could hold, in 0.2 s.
    for step in 1..=20 {
        module.set("load.torque_nm", -0.025 * f64::from(step));
        module.run_ms(10);
    }
    module.run_ms(800);
    assert!((module.turns() - from - 5.0).abs() < 0.01, "{} turns in a second", module.turns() - from);
    assert!(module.rms_a() > 1.6, "{} A", module.rms_a());
    module.set("load.torque_nm", 0);
    module.run_ms(1000);
    assert!(module.rms_a() < 1.2, "{} A again", module.rms_a());
}

#[test]
fn a_stall_reads_zero_and_double_the_load_less() {
    let mut module = StepDriver::new();
    module.sap(Ap::CoolstepThresholdVelocity, 200);
    module.sap(Ap::Stallguard2Filter, 1);
    module.turn(16_000.0);
    let mut readings = Vec::new();
    for load_nm in [0.0, -0.2, -0.4, -2.0] {
        module.set("load.torque_nm", load_nm);
        module.run_ms(500);
        readings.push(module.gap(Ap::LoadValue));
    }
    assert!(readings.is_sorted_by(|more, less| more > less), "{readings:?}");
    assert_eq!(readings[3], 0);
}

#[test]
fn interpolation_smooths_the_coil_currents() {
    let roughness = |interpolation: i32| {
        let mut module = StepDriver::new();
        module.sap(Ap::MicrostepInterpolation, interpolation);
        module.turn(320.0);
        let mut before = module.physical().coil_a_a;
        let mut largest = 0.0_f64;
        for _ in 0..10_000 {
            module.run_ticks(1);
            let now = module.physical().coil_a_a;
            largest = largest.max((now - before).abs());
            before = now;
        }
        largest
    };
    let [smooth, stepped] = [roughness(1), roughness(0)];
    assert!(stepped > 8.0 * smooth, "{stepped} A against {smooth} A in 50 µs");
}
