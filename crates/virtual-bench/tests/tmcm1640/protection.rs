//! Every bit of AP 156 by its real cause (§5), temperature (§8), I²t (§9; decisions 6.4), the minute counter, AP 255.

use crate::common::bldc::{Bldc, bench, fault, flag};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

/// The bits of AP 156 that report something wrong.
const ERRORS: i32 = 0b10_0000_0000_0110_1111;

/// Turning at 1000 rpm without an error.
fn turning() -> Bldc {
    let mut axis = Bldc::strong();
    axis.sap(Ap::MaxAcceleration, 10_000);
    axis.rotate(1000);
    axis.run_ms(500);
    assert_eq!(axis.gap(Ap::StatusFlags) & ERRORS, 0, "{}", axis.figures());
    axis
}

/// No transistor is on, or all are equally: no current flows at this speed, where the back-EMF is far below the supply.
fn is_off(axis: &mut Bldc) -> bool {
    axis.run_ms(5);
    axis.range(100, |axis| axis.amplitude_ma()).1 < 5.0
}

/// Bit 0: a regulator of 20 ms that has only an integral part takes its time to follow a lowered limit.
#[test]
fn overcurrent() {
    let mut axis = Bldc::strong();
    axis.clamp();
    axis.set_all(&[
        (Ap::CurrentLoopDelay, 400),
        (Ap::CurrentP, 0),
        (Ap::CurrentI, 10_000),
        (Ap::TargetCurrent, 5000),
    ]);
    axis.run_ms(1500);
    assert!((axis.amplitude_ma() / 5000.0 - 1.0).abs() < 0.05, "{}", axis.figures());
    assert!(!axis.flag(flag::OVERCURRENT), "{}", axis.figures());
    axis.sap(Ap::MaxCurrent, 1000);
    axis.run_ms(2);
    assert!(axis.amplitude_ma() > 3000.0, "the current cannot be gone yet: {}", axis.figures());
    assert!(axis.flag(flag::OVERCURRENT), "{}", axis.figures());
    axis.run_ms(1500);
    assert!((axis.amplitude_ma() / 1000.0 - 1.0).abs() < 0.05, "{}", axis.figures());
    assert!(!axis.flag(flag::OVERCURRENT), "it resets itself; {}", axis.figures());
}

/// Bit 1, below 10 V (decisions 6.10): the motor is off while it lasts.
#[test]
fn undervoltage() {
    let mut axis = turning();
    for (volts, flagged) in [(10.6, false), (9.4, true), (24.0, false)] {
        axis.set("supply.voltage_v", volts);
        axis.run_ms(600);
        assert_eq!(axis.flag(flag::UNDERVOLTAGE), flagged, "{volts} V: {}", axis.figures());
        assert_eq!(is_off(&mut axis), flagged, "{volts} V: {}", axis.figures());
        let read = f64::from(axis.gap(Ap::SupplyVoltage)) / 10.0;
        let real = axis.read("physical.bus_voltage_v");
        assert!((read - real).abs() < 0.15, "AP 151 = {read}, but {real:.2} V");
    }
    axis.run_ms(1000);
    assert!((axis.rpm() / 1000.0 - 1.0).abs() < 0.02, "it goes on: {}", axis.figures());
}

/// Bit 2 with AP 245: off above 30 V until 29 V; without it nothing happens.
#[test]
fn overvoltage() {
    for protected in [1, 0] {
        let mut axis = turning();
        axis.sap(Ap::OvervoltageProtection, protected);
        for (volts, flagged) in [(29.8, false), (30.5, true), (29.4, true), (28.5, false)] {
            axis.set("supply.voltage_v", volts);
            axis.run_ms(1500);
            let flagged = flagged && protected == 1;
            assert_eq!(
                axis.flag(flag::OVERVOLTAGE),
                flagged,
                "{volts} V, AP 245 = {protected}: {}",
                axis.figures()
            );
            assert_eq!(is_off(&mut axis), flagged, "{volts} V, AP 245 = {protected}");
        }
    }
}

/// Braking a flywheel charges the capacitor: with the protection the stage goes off at 30 V, without it the voltage climbs on.
#[test]
fn braking_raises_the_voltage_until_the_protection_cuts_in() {
    let mut peaks = Vec::new();
    for protected in [1, 0] {
        let mut axis = Bldc::strong_on(&bench(
            "[module.load]\ninertia_kgm2 = 5e-5\n[module.supply]\nvoltage_v = 27.0\ncapacitance_f = 1e-3",
        ));
        axis.set_all(&[(Ap::OvervoltageProtection, protected), (Ap::MaxAcceleration, 6000)]);
        axis.rotate(4000);
        axis.run_ms(1500);
        assert!((axis.rpm() / 4000.0 - 1.0).abs() < 0.03, "{}", axis.figures());
        axis.set_all(&[(Ap::EnableRamp, 0), (Ap::TargetVelocity, 0)]);
        let mut flagged = false;
        let (_, peak) = axis.range(2000, |axis| {
            flagged |= axis.flag(flag::OVERVOLTAGE);
            axis.read("physical.bus_voltage_v")
        });
        assert_eq!(flagged, protected == 1, "peak {peak:.1} V");
        peaks.push(peak);
        axis.run_ms(5000);
        assert!(axis.rpm().abs() < 50.0, "it stands in the end: {}", axis.figures());
        assert!(!axis.flag(flag::OVERVOLTAGE));
    }
    assert!((29.9..32.0).contains(&peaks[0]), "{peaks:?} V");
    assert!(peaks[1] > 32.0, "{peaks:?} V");
}

/// §8: what the converter reads at a temperature, by the formula's inverse.
fn adc_at(celsius: f64) -> f64 {
    let kelvin = celsius + 273.16;
    let resistance_kohm = 10.0 * (3434.0 * (298.16 / kelvin - 1.0) / 298.16).exp();
    9011.2 / (resistance_kohm + 2.2)
}

#[test]
fn axis_parameter_152_is_the_converter_reading_of_chapter_8() {
    let mut axis = Bldc::new();
    // The two examples: 1000 is 35.3 °C and 1200 is 42.3 °C ("≈ 35", "≈ 42").
    for (celsius, adc) in [(35.3, 1000.0), (42.3, 1200.0)] {
        assert!((adc_at(celsius) / adc - 1.0_f64).abs() < 0.005, "{}", adc_at(celsius));
    }
    for celsius in [-20.0, 0.0, 25.0, 35.3, 42.3, 80.0, 110.0] {
        axis.set(fault::DRIVER_TEMPERATURE, celsius);
        axis.run_ms(2);
        let read = f64::from(axis.gap(Ap::DriverTemperature));
        assert!(
            (read - adc_at(celsius)).abs() < 3.0,
            "AP 152 = {read} at {celsius} °C, not {}",
            adc_at(celsius)
        );
    }
}

/// Bit 3: at 100 °C (decisions 6.10).
#[test]
fn overtemperature() {
    let mut axis = turning();
    for (celsius, flagged) in [(99.0, false), (101.0, true), (60.0, false)] {
        axis.set(fault::DRIVER_TEMPERATURE, celsius);
        axis.run_ms(100);
        assert_eq!(axis.flag(flag::OVERTEMPERATURE), flagged, "{celsius} °C");
        assert_eq!(is_off(&mut axis), flagged, "{celsius} °C: {}", axis.figures());
    }
}

/// Bit 5: two lines down and the third changes, so 000 comes.
#[test]
fn hall_error() {
    let mut axis = turning();
    for line in fault::HALLS {
        axis.set(line, "low");
    }
    axis.run_ms(10);
    assert!(axis.flag(flag::HALL_ERROR));
    for line in fault::HALLS {
        axis.set(line, "none");
    }
    axis.run_ms(500);
    assert!(!axis.flag(flag::HALL_ERROR), "it resets itself");
    for line in fault::HALLS {
        axis.set(line, "high");
    }
    axis.run_ms(10);
    assert!(axis.flag(flag::HALL_ERROR), "111 is none either");
}

/// Bit 6: a phase shorted to ground while current wants to flow into it.
#[test]
fn driver_error() {
    let mut axis = turning();
    axis.set(fault::PHASE_SHORT, "u");
    let mut flagged = false;
    for _ in 0..400 {
        axis.run_ticks(1);
        flagged |= axis.flag(flag::DRIVER_ERROR);
    }
    assert!(flagged, "{}", axis.figures());
    axis.set(fault::PHASE_SHORT, "none");
    axis.run_ms(2500);
    assert!(!axis.flag(flag::DRIVER_ERROR), "it resets itself");
}

/// Bits 9 to 11, one at a time; bit 14 and bit 4 at rest.
#[test]
fn modes_and_rest() {
    let mut axis = Bldc::strong();
    let modes = |axis: &mut Bldc| axis.gap(Ap::StatusFlags) >> flag::VELOCITY_MODE & 0b111;
    assert_eq!(modes(&mut axis), 0b001, "velocity mode after power-on");
    axis.sap(Ap::TargetCurrent, 0);
    assert_eq!(modes(&mut axis), 0b100);
    axis.go(0);
    assert_eq!(modes(&mut axis), 0b010);
    axis.run_ms(700);
    assert!(axis.flag(flag::POSITION_END) && axis.flag(flag::HALTED));
    axis.rotate(500);
    assert_eq!(modes(&mut axis), 0b001);
    axis.run_ms(1000);
    assert!(!axis.flag(flag::HALTED));
}

mod i2t {
    use super::*;

    /// A clamped shaft with this current, limit and window.
    fn holding(current_ma: i32, window_ms: i32, limit: i32) -> Bldc {
        let mut axis = Bldc::strong();
        axis.clamp();
        axis.set_all(&[
            (Ap::ThermalWindingTimeConstant, window_ms),
            (Ap::I2tLimit, limit),
            (Ap::TargetCurrent, current_ma),
        ]);
        axis
    }

    /// The four examples of chapter 9: an average of 1 to 4 A over 13.2 s.
    const EXAMPLES: [(i32, i32); 4] = [(1000, 13_200), (2000, 52_800), (3000, 118_800), (4000, 211_200)];

    #[test]
    fn the_sum_of_the_four_examples_is_their_limit() {
        for (current, limit) in EXAMPLES {
            let mut axis = holding(current, 13_200, -1);
            axis.run_ms(14_000);
            let sum = f64::from(axis.gap(Ap::I2tSum));
            let real = axis.mean(100, |axis| axis.amplitude_ma()) / 1000.0;
            assert!((sum / f64::from(limit) - 1.0).abs() < 0.02, "{sum} for {current} mA, not {limit}");
            assert!((sum / (real * real * 13_200.0) - 1.0).abs() < 0.02, "{sum}, but {real:.3} A flow");
        }
    }

    #[test]
    fn a_little_less_than_the_average_never_trips_and_a_little_more_does() {
        for (current, limit) in EXAMPLES {
            for (permille, trips) in [(970, false), (1030, true)] {
                let mut axis = holding(current * permille / 1000, 13_200, limit);
                axis.run_ms(14_500);
                assert_eq!(axis.flag(flag::I2T), trips, "{permille} ‰ of {current} mA: {}", axis.figures());
            }
        }
    }

    #[test]
    fn exceeding_trips_in_time_stops_the_pwm_and_counts_seconds() {
        // 4 A against an average of 2 A over 4 s: a quarter of the time.
        let (window, limit) = (4000, 16_000);
        let mut axis = holding(4000, window, limit);
        let mut ms = 0;
        while !axis.flag(flag::I2T) {
            axis.run_ms(1);
            ms += 1;
            assert!(ms < 2000, "{}", axis.figures());
        }
        assert!((980..1120).contains(&ms), "tripped after {ms} ms; a partial sum lasts 62.5 ms");
        assert!(axis.gap(Ap::I2tSum) > limit);
        axis.run_ms(5);
        assert!(axis.amplitude_ma() < 5.0, "PWM is zero: {}", axis.figures());
        assert!(axis.flag(flag::TORQUE_MODE), "\"The actual regulation mode will not be changed.\"");
        assert_eq!(axis.gap(Ap::TargetCurrent), 4000);
        // The sum stays above until what tripped it leaves the window.
        let (mut above_ms, mut last) = (5, axis.gap(Ap::I2tExceedCounter));
        assert_eq!(last, 0);
        while axis.gap(Ap::I2tSum) > limit {
            axis.run_ms(1);
            above_ms += 1;
            let counter = axis.gap(Ap::I2tExceedCounter);
            assert!(counter == last || counter == last + 1);
            assert!((counter - above_ms / 1000).abs() <= 1, "{counter} after {above_ms} ms");
            last = counter;
            assert!(above_ms < 5000);
        }
        assert!((2800..4100).contains(&above_ms), "{above_ms} ms above the limit");
        assert_eq!(last, above_ms / 1000, "once every second");
        axis.run_ms(1500);
        assert_eq!(axis.gap(Ap::I2tExceedCounter), last, "below the limit it does not count");
        assert!(axis.flag(flag::I2T), "the flag does not reset itself");
        axis.sap(Ap::I2tExceedCounter, 0);
        assert_eq!(axis.gap(Ap::I2tExceedCounter), 0);
    }

    #[test]
    fn the_flag_clears_only_after_the_winding_time() {
        let window = 2000;
        let mut axis = holding(4000, window, 8000);
        axis.run_ms(600);
        assert!(axis.flag(flag::I2T));
        let mut after_ms = 0;
        // Tripped 500 to 540 ms after the beginning.
        for wait in [0, 500, 800, 500] {
            axis.run_ms(wait);
            after_ms += wait;
            axis.sap(Ap::ClearI2tFlag, 0);
            assert!(axis.flag(flag::I2T), "cleared {after_ms} ms after tripping, less than {window}");
            assert!(axis.amplitude_ma() < 5.0);
        }
        // Whether the time counts from the trip or from when the sum fell, it has passed after another window.
        axis.run_ms(2400);
        assert!(axis.flag(flag::I2T), "not of itself");
        axis.sap(Ap::ClearI2tFlag, 0);
        assert!(!axis.flag(flag::I2T), "{after_ms} ms and 2400 after tripping: {}", axis.figures());
        axis.run_ms(100);
        assert!(
            (axis.amplitude_ma() / 4000.0 - 1.0).abs() < 0.02,
            "and the mode goes on: {}",
            axis.figures()
        );
        axis.run_ms(600);
        assert!(axis.flag(flag::I2T), "as long as it is too much");
    }

    #[test]
    fn the_factory_limit_lets_the_factory_current_flow_for_ever() {
        let mut axis = Bldc::new();
        axis.clamp();
        axis.sap(Ap::TargetCurrent, 2000);
        axis.run_ms(14_000);
        assert!(!axis.flag(flag::I2T));
        let sum = axis.gap(Ap::I2tSum);
        assert!((52_000..53_600).contains(&sum), "{sum}");
    }
}

/// AP 30: minutes, kept over power-off.
#[test]
fn the_minute_counter_survives_power_off() {
    let mut axis = Bldc::new();
    axis.sap(Ap::MinuteCounter, 41);
    axis.run_ms(59_000);
    assert_eq!(axis.gap(Ap::MinuteCounter), 41);
    axis.run_ms(2000);
    assert_eq!(axis.gap(Ap::MinuteCounter), 42);
    axis.power_cycle();
    axis.run_ms(10);
    assert_eq!(axis.gap(Ap::MinuteCounter), 42);
    axis.ok(Command::RestoreAxisParameter, Ap::MinuteCounter.number(), 0, 0);
    assert_eq!(axis.gap(Ap::MinuteCounter), 42);
    axis.run_ms(60_100);
    assert_eq!(axis.gap(Ap::MinuteCounter), 43);
}

/// AP 255 = 0: the shaft can be turned by hand, whatever the mode.
#[test]
fn a_disabled_driver_resists_nothing() {
    let mut axis = Bldc::strong();
    for mode in [Ap::TargetVelocity, Ap::TargetPosition, Ap::TargetCurrent] {
        axis.sap(mode, 0);
        axis.sap(Ap::EnableDriver, 0);
        let from = axis.turns();
        axis.set("load.torque_nm", 0.01);
        axis.run_ms(100);
        assert!(axis.turns() - from > 0.3, "{mode:?}: {}", axis.figures());
        assert!(axis.amplitude_ma() < 5.0, "{mode:?}: {}", axis.figures());
        assert!(!axis.flag(flag::DRIVER_ERROR));
        axis.set("load.torque_nm", 0);
        axis.run_ms(1000);
        axis.sap(Ap::EnableDriver, 1);
    }
    axis.power_cycle();
    assert_eq!(axis.gap(Ap::EnableDriver), 1, "it is not kept");
}
