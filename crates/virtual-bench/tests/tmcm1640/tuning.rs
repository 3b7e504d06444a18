//! The manual's recipes for the two regulators (§7.2, §7.3), step by step: what the text promises must come.

use crate::common::bldc::{Bldc, loaded};
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

/// §7.2, "parameterizing the current regulator set".
mod current {
    use super::*;

    const TARGET: f64 = 1000.0;

    /// What of the target really flows 1 s after a start with these gains; the shaft is held.
    fn reached(p: i32, i: i32) -> f64 {
        let mut axis = Bldc::strong();
        axis.clamp();
        axis.set_all(&[(Ap::CurrentP, p), (Ap::CurrentI, i), (Ap::TargetCurrent, TARGET as i32)]);
        axis.run_ms(1000);
        axis.mean(200, |axis| axis.amplitude_ma()) / TARGET
    }

    /// 1: both zero. 3: P from low to high "until the actual current nearly reaches 50% of the desired target current".
    #[test]
    fn proportional_gain_alone_reaches_half_of_the_target() {
        assert!(reached(0, 0) < 0.005);
        let parts = [25, 50, 100, 150, 200, 250].map(|p| reached(p, 0));
        assert!(parts.is_sorted(), "more gain, more current: {parts:?}");
        assert!(parts[0] < 0.2, "{parts:?}");
        let nearly_half = parts.iter().any(|part| (0.4..0.55).contains(part));
        assert!(nearly_half, "{parts:?}");
    }

    /// 4: "Do the same with the current I parameter": the rest goes.
    #[test]
    fn integral_gain_brings_the_rest() {
        for i in [100, 300, 600] {
            let part = reached(200, i);
            assert!((part - 1.0).abs() < 0.02, "I = {i}: {part:.3} of the target");
        }
    }

    /// AP 200 and 201 show it: an error that stays with P alone, none with I.
    #[test]
    fn the_error_that_is_left_is_read() {
        let mut axis = Bldc::strong();
        axis.clamp();
        axis.set_all(&[(Ap::CurrentP, 200), (Ap::CurrentI, 0), (Ap::TargetCurrent, 1000)]);
        axis.run_ms(200);
        let error = axis.mean(200, |axis| f64::from(axis.gap(Ap::CurrentPidError)));
        let flows = axis.mean(200, |axis| f64::from(axis.gap(Ap::MotorCurrent)));
        assert!((error + flows - 1000.0).abs() < 30.0, "AP 200 = {error:.0}, AP 150 = {flows:.0}");
        axis.sap(Ap::CurrentI, 300);
        axis.run_ms(300);
        let error = axis.mean(200, |axis| f64::from(axis.gap(Ap::CurrentPidError)));
        assert!(error.abs() < 30.0, "AP 200 = {error:.0}");
    }

    /// A slower regulator (AP 134) regulates to the same current.
    #[test]
    fn the_loop_delay_leaves_the_target() {
        for delay in [0, 1, 2, 4, 8] {
            let mut axis = Bldc::strong();
            axis.clamp();
            axis.set_all(&[
                (Ap::CurrentLoopDelay, delay),
                (Ap::CurrentP, 100),
                (Ap::CurrentI, 200),
                (Ap::TargetCurrent, 2000),
            ]);
            axis.run_ms(2000);
            let amplitude = axis.mean(400, |axis| axis.amplitude_ma());
            assert!((amplitude / 2000.0 - 1.0).abs() < 0.02, "AP 134 = {delay}: {amplitude:.0} mA");
        }
    }
}

/// §7.3, "parameterizing the velocity regulator set".
mod velocity {
    use super::*;

    const TARGET: f64 = 2000.0;

    /// The default bench with what friction a small load has.
    fn motor(p: i32, i: i32) -> Bldc {
        let mut axis = Bldc::strong_on(&loaded("friction_nm = 0.01"));
        axis.set_all(&[(Ap::VelocityP, p), (Ap::VelocityI, i), (Ap::MaxAcceleration, 10_000)]);
        axis.rotate(TARGET as i32);
        axis.run_ms(1500);
        axis
    }

    fn reached(axis: &mut Bldc) -> f64 {
        axis.mean(4000, |axis| axis.rpm()) / TARGET
    }

    /// 3: P from low to high "until the actual motor speed reaches 80 or 90% of the target velocity".
    #[test]
    fn proportional_gain_alone_reaches_80_to_90_percent() {
        let parts = [50, 100, 200, 300, 400, 600].map(|p| reached(&mut motor(p, 0)));
        assert!(parts.is_sorted(), "more gain, more speed: {parts:?}");
        assert!(parts[0] < 0.7, "{parts:?}");
        assert!(parts.iter().any(|part| (0.8..=0.92).contains(part)), "{parts:?}");
        assert!(parts[5] < 0.99, "never quite all: {parts:?}");
    }

    /// 4: "The lasting 10 or 20% speed difference can be reduced by slowly increasing the velocity I parameter."
    #[test]
    fn integral_gain_removes_the_rest() {
        let mut axis = motor(300, 0);
        let before = reached(&mut axis);
        for i in [10, 50, 200] {
            axis.sap(Ap::VelocityI, i);
            axis.run_ms(700);
        }
        axis.run_ms(1500);
        let after = reached(&mut axis);
        assert!(before < 0.95 && (after - 1.0).abs() < 0.005, "{before:.3}, then {after:.3} of the target");
    }

    /// A slower regulator (AP 133) arrives at the same velocity.
    #[test]
    fn the_loop_delay_leaves_the_target() {
        for delay in [0_i32, 1, 2, 5] {
            let mut axis = Bldc::strong_on(&loaded("friction_nm = 0.01"));
            axis.set_all(&[(Ap::PidLoopDelay, delay), (Ap::VelocityP, 300), (Ap::VelocityI, 200)]);
            axis.rotate(1500);
            axis.run_ms(2000 + 2500 * u64::from(delay.unsigned_abs()));
            let mean = axis.mean(4000, |axis| axis.rpm());
            assert!((mean / 1500.0 - 1.0).abs() < 0.005, "AP 133 = {delay}: {mean:.1} rpm");
        }
    }
}

/// §7.5, "parameterizing the position regulation".
mod position {
    use super::*;

    /// 1, 2: without ramp, P from zero up, until the motor reaches the target approximately; 3, 4: with the ramp, the flag.
    #[test]
    fn proportional_gain_up_from_zero_reaches_the_target() {
        let mut axis = Bldc::strong();
        axis.use_encoder();
        axis.set_all(&[(Ap::ActualPosition, 0), (Ap::EnableRamp, 0), (Ap::PositionP, 0)]);
        let zero = axis.turns();
        axis.go(20_480);
        let mut turned = Vec::new();
        for p in [0, 20, 50, 100, 300] {
            axis.sap(Ap::PositionP, p);
            axis.run_ms(500);
            turned.push(axis.turns() - zero);
        }
        assert!(turned[0].abs() < 0.01, "{turned:?}");
        assert!((turned[4] - 5.0).abs() < 0.02, "{turned:?}");
        axis.sap(Ap::EnableRamp, 1);
        axis.go(0);
        axis.reach(6000);
        axis.run_ms(3000);
        assert!((axis.turns() - zero).abs() < 0.002, "{}", axis.figures());
    }
}
