//! Velocity mode of the TMCM-1640 (§7.3, §7.4; decisions 6.2): what AP 2, 3, 4, 11, 13 and 146 say against how the shaft turns.

use crate::common::bldc::{Bldc, RATED_NM, current_ma, flag, loaded};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

/// Loads that resist in both directions: none beside the bench's own friction, and the rated torque.
const LOADS: [&str; 2] = ["", "friction_nm = 0.125"];

/// Control periods of 0.5 s, over which a mean is taken.
const HALF_A_SECOND: u64 = 10_000;

/// 0 → 3000 rpm by the ramp: at 3000 rpm in the mean, and never far above. Returns the axis and the highest speed.
#[track_caller]
fn assert_step(mut axis: Bldc, rpm: i32, what: &str) {
    axis.rotate(rpm);
    let sign = f64::from(rpm.signum());
    let wanted = f64::from(rpm.abs());
    // The ramp lasts wanted / 2000 s, and a second after it everything has settled.
    let ramp_ms = f64::from(rpm.abs()) / 2.0;
    let (_, fastest) = axis.range((ramp_ms as u64 + 1000) * 20, |axis| axis.rpm() * sign);
    assert!(fastest < wanted * 1.05, "{what}: {fastest:.1} rpm is an overshoot beyond 5 % of {wanted}");
    let mean = axis.mean(HALF_A_SECOND, |axis| axis.rpm() * sign);
    let figures = axis.figures();
    assert!(
        (mean / wanted - 1.0).abs() < 0.005,
        "{what}: {mean:.2} rpm in the mean, not {wanted}; {figures}"
    );
}

#[test]
fn a_step_to_3000_rpm_with_halls_arrives_without_and_with_the_rated_load() {
    for load in LOADS {
        for rpm in [3000, -3000] {
            assert_step(Bldc::strong_on(&loaded(load)), rpm, load);
        }
    }
}

#[test]
fn a_step_to_3000_rpm_with_the_encoder_arrives_without_and_with_the_rated_load() {
    for load in LOADS {
        let mut axis = Bldc::strong();
        axis.use_encoder();
        if !load.is_empty() {
            axis.set("load.friction_nm", RATED_NM);
        }
        assert_step(axis, 3000, load);
    }
}

#[test]
fn an_unchanged_module_without_load_arrives_too() {
    assert_step(Bldc::new(), 3000, "as delivered");
}

/// From a crawl up to what the supply allows.
#[test]
fn every_velocity_is_kept_in_the_mean_with_the_encoder() {
    for rpm in [20, 100, 500, -1000, 2000, -4000] {
        let mut axis = Bldc::strong();
        axis.use_encoder();
        axis.sap(Ap::MaxAcceleration, 8000);
        axis.rotate(rpm);
        axis.run_ms(4000);
        let start = axis.turns();
        axis.run_ms(1000);
        let mean = (axis.turns() - start) * 60.0;
        assert!((mean / f64::from(rpm) - 1.0).abs() < 0.01, "{mean:.2} rpm, not {rpm}");
    }
}

#[test]
fn the_ramp_accelerates_and_brakes_with_axis_parameter_11() {
    let mut axis = Bldc::strong();
    axis.use_encoder();
    axis.set_all(&[(Ap::MaxAcceleration, 1000), (Ap::TargetVelocity, 2000)]);
    for ms in [500, 1000, 1500] {
        axis.run_ms(500);
        let (ramp, measured, real) = (axis.gap(Ap::RampVelocity), axis.gap(Ap::ActualVelocity), axis.rpm());
        assert!((ramp - ms).abs() <= 3, "{ramp} rpm after {ms} ms at 1000 rpm/s");
        assert!((real - f64::from(ms)).abs() < 40.0, "{real:.1} rpm after {ms} ms at 1000 rpm/s");
        assert!((f64::from(measured) - real).abs() < 25.0, "AP 3 = {measured}, but {real:.1} rpm");
    }
    axis.run_ms(1500);
    assert_eq!(axis.gap(Ap::RampVelocity), 2000);
    axis.halt();
    assert_eq!(axis.gap(Ap::TargetVelocity), 0);
    assert!(axis.flag(flag::VELOCITY_MODE));
    axis.run_ms(1000);
    let (ramp, real) = (axis.gap(Ap::RampVelocity), axis.rpm());
    assert!((ramp - 1000).abs() <= 3, "{ramp} rpm a second after MST at 1000 rpm/s");
    assert!((real - 1000.0).abs() < 40.0, "{real:.1} rpm");
    axis.run_ms(1500);
    assert_eq!(axis.gap(Ap::RampVelocity), 0);
    let (slowest, fastest) = axis.range(2000, |axis| axis.rpm());
    assert!(slowest > -15.0 && fastest < 15.0, "{slowest:.1} to {fastest:.1} rpm after MST");
}

/// Without the ramp the regulator gets its target at once, and accelerates with all the current there is.
#[test]
fn without_the_ramp_the_motor_jumps_to_its_velocity() {
    let mut axis = Bldc::new();
    axis.use_encoder();
    axis.set_all(&[(Ap::EnableRamp, 0), (Ap::TargetVelocity, 2000)]);
    axis.run_ms(2);
    assert_eq!(axis.gap(Ap::RampVelocity), 2000);
    // 2 A make 0.062 Nm; a rotor of 48 g·cm² without friction needs 16 ms for 2000 rpm.
    let mut ms = 2;
    while axis.rpm() < 1900.0 {
        axis.run_ms(1);
        ms += 1;
        assert!(ms < 60, "{ms} ms; {}", axis.figures());
    }
    assert!(ms > 12, "{ms} ms is faster than 2 A allow");
    axis.run_ms(500);
    let mean = axis.mean(HALF_A_SECOND, |axis| axis.rpm());
    assert!((mean / 2000.0 - 1.0).abs() < 0.005, "{mean:.2} rpm");
}

#[test]
fn velocities_beyond_axis_parameter_4_are_accepted_and_limited() {
    for ramp in [0, 1] {
        let mut axis = Bldc::strong();
        axis.use_encoder();
        axis.set_all(&[(Ap::EnableRamp, ramp), (Ap::MaxVelocity, 1500), (Ap::MaxAcceleration, 5000)]);
        for rpm in [2500, -2500] {
            axis.rotate(rpm);
            assert_eq!(axis.gap(Ap::TargetVelocity), rpm);
            axis.run_ms(1500);
            let limited = 1500 * rpm.signum();
            assert_eq!(axis.gap(Ap::RampVelocity), limited, "ramp {ramp}");
            let mean = axis.mean(HALF_A_SECOND, |axis| axis.rpm());
            assert!((mean / f64::from(limited) - 1.0).abs() < 0.005, "ramp {ramp}: {mean:.2} rpm");
        }
    }
}

#[test]
fn reversal_at_full_speed_passes_through_zero_and_arrives() {
    for (encoder, ramp) in [(true, 1), (true, 0), (false, 1), (false, 0)] {
        let mut axis = Bldc::strong();
        axis.sap(Ap::MaxAcceleration, 20_000);
        if encoder {
            axis.use_encoder();
        }
        axis.rotate(4000);
        axis.run_ms(1500);
        assert!((axis.rpm() / 4000.0 - 1.0).abs() < 0.03, "{}", axis.figures());
        axis.sap(Ap::EnableRamp, ramp);
        axis.rotate(-4000);
        axis.run_ms(1000);
        let mean = axis.mean(HALF_A_SECOND, |axis| axis.rpm());
        assert!((mean / -4000.0 - 1.0).abs() < 0.01, "encoder {encoder}, ramp {ramp}: {mean:.1} rpm");
        let flags = axis.gap(Ap::StatusFlags);
        assert_eq!(flags & 0b100_1111, 0, "encoder {encoder}, ramp {ramp}: flags {flags:#b}");
    }
}

#[test]
fn a_load_step_of_half_the_rated_torque_recovers() {
    for encoder in [true, false] {
        let mut axis = Bldc::strong();
        if encoder {
            axis.use_encoder();
        }
        axis.rotate(3000);
        axis.run_ms(2500);
        for torque in [-RATED_NM / 2.0, 0.0] {
            axis.set("load.torque_nm", torque);
            // AP 234 over AP 235 is 0.4 s: three seconds are seven times as long.
            let (slowest, fastest) = axis.range(60_000, |axis| axis.rpm());
            assert!(
                slowest > 2000.0 && fastest < 4000.0,
                "encoder {encoder}, {torque} Nm: {slowest:.0} to {fastest:.0} rpm"
            );
            let mean = axis.mean(HALF_A_SECOND, |axis| axis.rpm());
            assert!((mean / 3000.0 - 1.0).abs() < 0.005, "encoder {encoder}, {torque} Nm: {mean:.2} rpm");
        }
    }
}

/// The torque of a load is paid for in current, and no more than AP 6.
#[test]
fn the_current_is_what_the_load_needs() {
    let mut axis = Bldc::strong();
    axis.use_encoder();
    axis.rotate(1000);
    axis.run_ms(1500);
    let idle = axis.mean(2000, |axis| axis.current_q_ma());
    axis.set("load.torque_nm", -RATED_NM);
    axis.run_ms(1000);
    let loaded = axis.mean(2000, |axis| axis.current_q_ma());
    let wanted = current_ma(RATED_NM);
    assert!(((loaded - idle) / wanted - 1.0).abs() < 0.02, "{loaded:.0} − {idle:.0} mA for {wanted:.0}");
    let demanded = axis.mean(2000, |axis| f64::from(axis.gap(Ap::TargetCurrent)));
    assert!((demanded / loaded - 1.0).abs() < 0.02, "AP 155 = {demanded:.0}, but {loaded:.0} mA");
    axis.sap(Ap::MaxCurrent, 1000);
    axis.clamp();
    axis.run_ms(300);
    let limited = axis.mean(200, |axis| axis.current_q_ma());
    assert!(limited < 1100.0, "{limited:.0} mA with 1000 allowed");
}

/// Bit 4 of AP 156: slower than AP 9 (decisions 6.10).
#[test]
fn the_halted_flag_follows_the_velocity() {
    let mut axis = Bldc::strong();
    axis.use_encoder();
    axis.set_all(&[(Ap::MotorHaltedVelocity, 200), (Ap::MaxAcceleration, 1000)]);
    axis.run_ms(200);
    assert!(axis.flag(flag::HALTED));
    axis.rotate(1000);
    for _ in 0..1400 {
        axis.run_ms(1);
        let (halted, real) = (axis.flag(flag::HALTED), axis.rpm());
        if !(150.0..250.0).contains(&real) {
            assert_eq!(halted, real < 200.0, "at {real:.1} rpm");
        }
    }
    axis.halt();
    for _ in 0..1400 {
        axis.run_ms(1);
        let (halted, real) = (axis.flag(flag::HALTED), axis.rpm());
        if !(150.0..250.0).contains(&real) {
            assert_eq!(halted, real < 200.0, "at {real:.1} rpm");
        }
    }
}

/// AP 228 and 229: what the regulator makes its current of.
#[test]
fn the_error_is_what_the_ramp_wants_less_what_is_measured() {
    let mut axis = Bldc::strong();
    axis.use_encoder();
    axis.rotate(2000);
    axis.run_ms(300);
    let sum_turning = axis.gap(Ap::VelocityPidErrorSum);
    // The values of one run of the regulator; between two of them AP 3 goes on.
    let error = axis.mean(100, |axis| f64::from(axis.gap(Ap::VelocityPidError)));
    let difference =
        axis.mean(2000, |axis| f64::from(axis.gap(Ap::RampVelocity) - axis.gap(Ap::ActualVelocity)));
    assert!((error - difference).abs() < 20.0, "AP 228 = {error:.1}, AP 13 − AP 3 = {difference:.1}");
    axis.set("load.torque_nm", -RATED_NM / 2.0);
    axis.run_ms(2500);
    let sum_loaded = axis.gap(Ap::VelocityPidErrorSum);
    // In the steady state the integral carries the load: I · sum / 65 536 = the current.
    let carried = f64::from(sum_loaded) * 500.0 / 65_536.0;
    let current = axis.mean(2000, |axis| axis.current_q_ma());
    assert!((carried / current - 1.0).abs() < 0.05, "{carried:.0} mA in the sum, {current:.0} flow");
    assert!(sum_loaded > sum_turning);
}

/// ROR takes any value; a negative one turns the other way (decisions 3, ROL).
#[test]
fn rotation_commands_set_the_target_velocity_and_the_mode() {
    let mut axis = Bldc::new();
    for (command, value, target) in [
        (Command::RotateRight, 350, 350),
        (Command::RotateLeft, 350, -350),
        (Command::RotateLeft, -20, 20),
        (Command::MotorStop, 0, 0),
    ] {
        axis.sap(Ap::TargetCurrent, 10);
        assert!(axis.flag(flag::TORQUE_MODE));
        assert_eq!(axis.ok(command, 0, 0, value), value);
        assert_eq!(axis.gap(Ap::TargetVelocity), target);
        let flags = axis.gap(Ap::StatusFlags) >> flag::VELOCITY_MODE & 0b111;
        assert_eq!(flags, 1, "velocity mode and no other");
    }
}

#[test]
fn a_disabled_driver_lets_the_motor_coast_and_an_enabled_one_takes_it_up_again() {
    let mut axis = Bldc::strong();
    axis.use_encoder();
    axis.rotate(2000);
    axis.run_ms(1500);
    axis.sap(Ap::EnableDriver, 0);
    axis.run_ms(5);
    let (low, high) = axis.range(100, |axis| axis.amplitude_ma());
    assert!(low >= 0.0 && high < 5.0, "{high:.1} mA with the power stage off");
    axis.run_ms(200);
    assert!(axis.rpm() < 1990.0, "friction brakes it: {:.1} rpm", axis.rpm());
    let coasting = axis.rpm();
    axis.sap(Ap::EnableDriver, 1);
    axis.run_ms(1500);
    assert!((axis.rpm() / 2000.0 - 1.0).abs() < 0.02, "from {coasting:.1} to {:.1} rpm", axis.rpm());
}
