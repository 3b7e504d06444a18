//! What the TMCM-1640 knows before it regulates (§5.1 AP 238, 239, 240): each takes work off a regulator.

use crate::common::bldc::{Bldc, torque_nm};
use core::f64::consts::TAU;
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

/// Of the default motor: inertia, back EMF between two terminals, resistance between two terminals.
const INERTIA_KGM2: f64 = 4.8e-6;
const EMF_V_S: f64 = 0.036;
const RESISTANCE_MOHM: i32 = 720;

/// AP 238: the current for 1000 rpm/s.
fn inertia_ma() -> i32 {
    let torque = INERTIA_KGM2 * 1000.0 / 60.0 * TAU;
    (torque / torque_nm(1.0) * 1000.0).round() as i32
}

/// The mean error of the velocity while the ramp rises by 20 000 rpm/s, by the truth.
fn error_while_accelerating(mass_inertia_constant: i32) -> f64 {
    let mut axis = Bldc::aligned();
    axis.set_all(&[
        (Ap::VelocityP, 200),
        (Ap::VelocityI, 0),
        (Ap::MaxAcceleration, 20_000),
        (Ap::MassInertiaConstant, mass_inertia_constant),
    ]);
    axis.rotate(3000);
    axis.run_ms(50);
    axis.mean(1000, |axis| f64::from(axis.gap(Ap::RampVelocity)) - axis.rpm())
}

#[test]
fn the_mass_inertia_constant_takes_the_acceleration_off_the_velocity_regulator() {
    let without = error_while_accelerating(0);
    let with = error_while_accelerating(inertia_ma());
    assert!(without > 100.0, "{without:.0} rpm behind");
    assert!(with.abs() < 0.5 * without, "{with:.0} rpm behind with AP 238, {without:.0} without");
    let wrong = error_while_accelerating(-inertia_ma());
    assert!(wrong > 1.3 * without, "{wrong:.0} rpm behind with the wrong sign");
}

/// The integral part of the current regulator, as a part of the whole voltage.
fn integral_part(axis: &mut Bldc) -> f64 {
    let gain = f64::from(axis.gap(Ap::CurrentI));
    let sum = axis.mean(2000, |axis| f64::from(axis.gap(Ap::CurrentPidErrorSum)));
    sum * gain / 65_536.0 / 32_767.0
}

#[test]
fn the_bemf_constant_takes_the_speed_off_the_current_regulator() {
    for rpm in [2000, -2000] {
        let mut axis = Bldc::aligned();
        axis.sap(Ap::MaxAcceleration, 10_000);
        axis.rotate(rpm);
        axis.run_ms(1000);
        let without = integral_part(&mut axis);
        let speed = axis.mean(2000, |axis| axis.rpm()) / 60.0 * TAU;
        let expected = speed * EMF_V_S / axis.read("physical.bus_voltage_v");
        assert!((without / expected - 1.0).abs() < 0.1, "{without:.3}, not {expected:.3} of the voltage");
        axis.sap(Ap::BemfConstant, (10.0 / EMF_V_S * 60.0 / TAU).round() as i32);
        axis.run_ms(500);
        let with = integral_part(&mut axis);
        assert!(with.abs() < 0.1 * without.abs(), "{with:.3} of the voltage is left of {without:.3}");
        let speed = axis.mean(2000, |axis| axis.rpm());
        assert!((speed / f64::from(rpm) - 1.0).abs() < 0.01, "{}", axis.figures());
    }
}

#[test]
fn the_coil_resistance_takes_the_current_off_its_regulator() {
    for current_ma in [2000, -2000] {
        let mut axis = Bldc::strong();
        axis.clamp();
        axis.sap(Ap::TargetCurrent, current_ma);
        axis.run_ms(500);
        let without = integral_part(&mut axis);
        assert!(without.abs() > 0.04, "{without:.4} of the voltage");
        axis.sap(Ap::MotorCoilResistance, RESISTANCE_MOHM);
        axis.run_ms(500);
        let with = integral_part(&mut axis);
        assert!(with.abs() < 0.15 * without.abs(), "{with:.4} of the voltage is left of {without:.4}");
        let amplitude = axis.mean(200, |axis| axis.amplitude_ma());
        assert!((amplitude / 2000.0 - 1.0).abs() < 0.02, "{amplitude:.0} mA");
    }
}

/// A regulator that is cut short: what is known alone makes most of the current.
#[test]
fn the_coil_resistance_alone_makes_most_of_the_current() {
    let mut axis = Bldc::strong();
    axis.clamp();
    axis.set_all(&[(Ap::CurrentP, 0), (Ap::CurrentI, 0), (Ap::TargetCurrent, 2000)]);
    axis.run_ms(200);
    assert!(axis.amplitude_ma() < 20.0, "{}", axis.figures());
    axis.sap(Ap::MotorCoilResistance, RESISTANCE_MOHM);
    axis.run_ms(200);
    let amplitude = axis.mean(200, |axis| axis.amplitude_ma());
    assert!((amplitude / 2000.0 - 1.0).abs() < 0.07, "{amplitude:.0} mA");
}
