//! The currents at rest and in motion, with spreadCycle and with stealthChop.

use super::*;

/// stealthChop as the datasheet's example for a start has it.
fn stealth() -> Registers {
    let mut registers = factory();
    registers.gconf.en_pwm_mode = true;
    registers.pwmconf = PwmConf::from_bits(0xC40C_001E);
    registers
}

#[test]
fn the_factory_settings_make_2_3_and_0_29_amperes() {
    let mut rig = Rig::new(factory());
    rig.wait(0.1);
    assert!((rig.rms_a() - 3.0 * 3.0 / 31.0).abs() < 1e-4, "0.290 A at standstill: {}", rig.rms_a());
    rig.run(1600.0, 0.5);
    let (mut sum_a2, periods) = ([0.0; 2], 8000);
    for _ in 0..periods {
        rig.run(1600.0, PERIOD_S);
        for (sum, current) in sum_a2.iter_mut().zip(rig.motor.currents_a) {
            *sum += current * current;
        }
    }
    for sum in sum_a2 {
        let rms_a = libm::sqrt(sum / f64::from(periods));
        assert!((rms_a - 24.0 / 31.0 * 3.0).abs() < 0.005, "2.32 A in motion: {rms_a}");
    }
    assert_eq!(rig.chip.status().cs_actual, 24);
    // 87 ms until standstill and 218 ms to power-down.
    rig.wait(0.30);
    assert_eq!(rig.chip.status().cs_actual, 24);
    rig.wait(0.01);
    assert_eq!(rig.chip.status().cs_actual, 3);
    rig.wait(0.1);
    assert!((rig.rms_a() - 3.0 * 3.0 / 31.0).abs() < 1e-4, "{}", rig.rms_a());
}

#[test]
fn a_board_of_the_datasheet_counts_currents_in_32nds() {
    for (lowest_scale, cs, expected_a) in [(1.0 / 32.0, 0, 3.0 / 32.0), (1.0 / 32.0, 15, 1.5), (0.0, 0, 0.0)]
    {
        let mut rig = Rig::new(factory());
        rig.chip = Tmc5160::new(Board { lowest_scale, ..BOARD });
        rig.registers.ihold_irun.ihold = cs;
        rig.wait(0.05);
        assert!((rig.rms_a() - expected_a).abs() < 1e-4, "{} A", rig.rms_a());
    }
    let mut rig = Rig::new(factory());
    (rig.registers.ihold_irun.ihold, rig.registers.global_scaler) = (31, 128);
    rig.wait(0.05);
    assert!((rig.rms_a() - 1.5).abs() < 1e-4, "half of it: {} A", rig.rms_a());
}

#[test]
fn stealthchop_finds_its_amplitude_at_standstill_whatever_it_starts_from() {
    for pwmconf in [PwmConf::from_bits(0xC40C_001E), PwmConf::from_bits(328_136)] {
        for ihold in [3, 12, 24] {
            let mut rig = Rig::new(Registers { pwmconf, ..stealth() });
            rig.registers.ihold_irun.ihold = ihold;
            let mut highest_a = 0.0_f64;
            for _ in 0..4000 {
                rig.period(&[]);
                highest_a = highest_a.max(rig.rms_a());
            }
            let target_a = 3.0 * f64::from(ihold) / 31.0;
            // A step of the amplitude is 24 V · 248/256/256 / 0.83 Ω / √2 = 77 mA.
            assert!((rig.rms_a() - target_a).abs() < 0.04, "{} A, wanted {target_a} A", rig.rms_a());
            assert!(highest_a < 3.5, "{highest_a} A on the way");
        }
    }
}

#[test]
fn stealthchop_comes_near_the_run_current_in_slow_motion_and_its_regulator_to_it() {
    let mut rig = Rig::new(stealth());
    rig.wait(0.2);
    rig.run(1600.0, 1.0);
    let status = rig.chip.status();
    assert!(status.stealth);
    assert_eq!(status.cs_actual, 24);
    assert!((rig.rms_a() - 2.32).abs() < 0.15, "{} A", rig.rms_a());
    assert!((20..60).contains(&status.pwm_scale_sum), "{}", status.pwm_scale_sum);
}

#[test]
fn automatic_tuning_learns_the_gradient_that_the_back_emf_needs() {
    let amplitudes = |frequency_hz: f64, learn: bool| {
        let mut rig = Rig::new(stealth());
        rig.registers.pwmconf.pwm_autograd = learn;
        rig.wait(0.2);
        // 60 to 300 rpm: there the datasheet tells to learn.
        rig.ramp(2 * 3200, 100.0, 6400.0);
        rig.run(6400.0, 3.0);
        rig.run(frequency_hz, 0.02);
        rig.rms_a()
    };
    // Right after a change of velocity the current is right if the gradient is: the regulator has had no time.
    let [learnt, not] = [amplitudes(8000.0, true), amplitudes(8000.0, false)];
    assert!((learnt - 2.32).abs() < 0.25, "{learnt} A");
    assert!((learnt - 2.32).abs() < (not - 2.32).abs(), "{learnt} A against {not} A");
}

/// The rotor's stiffness is that of the current; what differs is how fast the current answers.
#[test]
fn stealthchop_is_softer_than_spreadcycle() {
    let after_a_jerk = |stealthchop: bool| {
        let mut rig = Rig::new(stealth());
        rig.registers.gconf.en_pwm_mode = stealthchop;
        rig.registers.ihold_irun.ihold = 24;
        rig.wait(0.3);
        // A full step at once, not interpolated.
        rig.registers.chopconf.intpol = false;
        let edges = Edges { count: 31, first_clock: 0, last_clock: 500, rising_first: true, reverse: false };
        rig.period(&[edges]);
        let target_a = [0.0, 2.32 * SQRT_2];
        let mut periods = 1;
        while libm::hypot(rig.motor.currents_a[0] - target_a[0], rig.motor.currents_a[1] - target_a[1]) > 0.5
        {
            rig.period(&[]);
            periods += 1;
        }
        f64::from(periods) * PERIOD_S
    };
    let [stealthchop, spreadcycle] = [after_a_jerk(true), after_a_jerk(false)];
    assert!(spreadcycle < 0.001, "{spreadcycle} s with a current that is followed");
    assert!(stealthchop > 5.0 * spreadcycle, "{stealthchop} s with a voltage against {spreadcycle} s");
}

#[test]
fn stealthchop_loses_steps_at_an_acceleration_that_spreadcycle_follows() {
    let velocity_rps = |stealthchop: bool| {
        let mut rig = Rig::new(stealth());
        rig.registers.gconf.en_pwm_mode = stealthchop;
        rig.wait(0.2);
        // Five turns a second after a fifth of a second.
        rig.ramp(2 * 1600, 100.0, 16_000.0);
        rig.run(16_000.0, 0.5);
        rig.motor.velocity_rad_s / TAU
    };
    assert!((velocity_rps(false) - 5.0).abs() < 0.1);
    assert!(velocity_rps(true).abs() < 2.0, "its regulator is slower than the back-EMF grows");
}

#[test]
fn the_threshold_read_from_tstep_switches_the_chopper_with_its_hysteresis() {
    let mut rig = Rig::new(stealth());
    rig.wait(0.2);
    rig.run(3200.0, 0.3);
    let tstep = rig.chip.status().tstep;
    assert_eq!(tstep, 234);
    rig.registers.tpwmthrs = tstep;
    rig.run(3200.0, 0.1);
    assert!(rig.chip.status().stealth, "not yet faster by a sixteenth");
    for (frequency_hz, stealthchop) in
        [(3350.0, true), (3500.0, false), (3350.0, false), (3250.0, false), (3190.0, true), (3350.0, true)]
    {
        rig.run(frequency_hz, 0.1);
        assert_eq!(rig.chip.status().stealth, stealthchop, "at {frequency_hz} Hz");
    }
}

#[test]
fn freewheeling_and_passive_braking_come_with_no_hold_current() {
    let free = [Terminal::Floating { bus_voltage_v: 24.0 }; 2];
    let short = [Terminal::Driven { voltage_v: 0.0 }; 2];
    for (freewheel, expected) in [(0, short), (1, free), (2, short), (3, short)] {
        let mut rig = Rig::new(stealth());
        rig.registers.pwmconf.freewheel = freewheel;
        rig.registers.ihold_irun.ihold = 0;
        rig.wait(0.1);
        assert_eq!(rig.period(&[]), expected, "freewheel = {freewheel}");
    }
}

#[test]
fn at_high_velocity_vhighfs_makes_full_steps() {
    let mut rig = Rig::new(factory());
    rig.registers.chopconf.vhighfs = true;
    rig.registers.thigh = 64;
    rig.run(3200.0, 0.3);
    assert!(!rig.chip.status().fsactive);
    rig.ramp(2 * 6400, 3200.0, 16_000.0);
    rig.run(16_000.0, 0.1);
    let status = rig.chip.status();
    assert!(status.fsactive);
    assert!(status.mscuract.iter().all(|value| (175..=176).contains(&value.abs())), "{:?}", status.mscuract);
    assert!((rig.motor.velocity_rad_s / TAU - 5.0).abs() < 1.0, "and the motor follows");
}
