//! Torque mode of the TMCM-1640 (§7.2): the current that really makes torque, at rest and turning, and what is read of it.

use crate::common::bldc::{Bldc, current_ma, flag, torque_nm};
use tmcl_tables::tmcm_1640::AxisParameter as Ap;

const CURRENTS_MA: [i32; 8] = [200, 500, 1000, 2000, 4000, 6000, -500, -4000];

/// Torque mode at a current, 100 ms on.
fn torque(axis: &mut Bldc, current_ma: i32) {
    axis.sap(Ap::TargetCurrent, current_ma);
    axis.run_ms(100);
}

/// With halls alone the angle is up to 30° off, so it is the length of the current vector that is regulated.
#[test]
fn at_standstill_with_halls_the_phase_current_is_within_2_percent() {
    for target in CURRENTS_MA {
        let mut axis = Bldc::strong();
        axis.clamp();
        torque(&mut axis, target);
        let amplitude = axis.mean(2000, |axis| axis.amplitude_ma());
        let wanted = f64::from(target.abs());
        assert!((amplitude / wanted - 1.0).abs() < 0.02, "{amplitude:.1} mA, not {wanted}");
        let current_q = axis.current_q_ma();
        let least = wanted * 0.85; // cos 30° = 0.866
        assert!(current_q * f64::from(target.signum()) > least, "{current_q:.0} mA along q for {target}");
    }
}

#[test]
fn at_standstill_with_the_encoder_the_torque_current_is_within_2_percent() {
    let aligned = Bldc::aligned();
    for target in CURRENTS_MA {
        let mut axis = aligned.clone();
        axis.clamp();
        torque(&mut axis, target);
        let current_q = axis.mean(2000, |axis| axis.current_q_ma());
        let current_d = axis.mean(2000, |axis| axis.current_d_ma());
        assert!((current_q / f64::from(target) - 1.0).abs() < 0.02, "{current_q:.1} mA, not {target}");
        assert!(current_d.abs() < 0.1 * f64::from(target.abs()), "{current_d:.1} mA along d for {target}");
    }
}

/// A clamped shaft does not turn, a released one goes off.
#[test]
fn full_torque_at_zero_speed() {
    let mut axis = Bldc::aligned();
    axis.clamp();
    let start = axis.turns();
    torque(&mut axis, 6500);
    let torque_truth = axis.mean(2000, |axis| axis.read("physical.torque_nm"));
    assert!((torque_truth / torque_nm(6.5) - 1.0).abs() < 0.02, "{torque_truth:.4} Nm");
    assert!((axis.turns() - start).abs() < 1e-6);
    assert!(axis.rpm().abs() < 0.1);
}

/// A weight of nine tenths of the torque is lifted, one of eleven tenths is not.
#[test]
fn a_weight_is_lifted_from_rest_when_the_torque_exceeds_it() {
    for (part, lifted) in [(0.9, true), (1.1, false)] {
        let mut axis = Bldc::aligned();
        axis.clamp();
        axis.set("load.torque_nm", -torque_nm(3.0) * part);
        torque(&mut axis, 3000);
        let start = axis.turns();
        axis.release();
        axis.run_ms(30);
        let turned = axis.turns() - start;
        assert_eq!(turned > 0.0, lifted, "{turned:.3} turns against {part} of the torque");
    }
}

/// Turning with nearly no acceleration, under friction that takes up the torque.
#[test]
fn turning_the_torque_current_is_within_2_percent() {
    for target in [500_i32, 2000, 4000, -2000] {
        let mut axis = Bldc::aligned();
        axis.set("load.friction_nm", torque_nm(f64::from(target.abs()) / 1000.0) * 0.92);
        axis.set("load.inertia_kgm2", 1e-4);
        axis.sap(Ap::TargetCurrent, target);
        axis.run_ms(1500);
        assert!(axis.rpm().abs() > 60.0, "{target} mA: {}", axis.figures());
        let (mut current, mut reading) = (0.0, 0.0);
        for _ in 0..4000 {
            axis.run_ticks(1);
            current += axis.current_q_ma() / 4000.0;
            reading += f64::from(axis.gap(Ap::MotorCurrent)) / 4000.0;
        }
        let off = current / f64::from(target) - 1.0;
        assert!(off.abs() < 0.02, "{current:.1} mA, not {target}; {}", axis.figures());
        assert!((reading / current - 1.0).abs() < 0.02, "AP 150 = {reading:.1}, but {current:.1} mA");
    }
}

#[test]
fn the_current_is_limited_by_axis_parameter_6() {
    for sign in [1, -1] {
        let mut axis = Bldc::aligned();
        axis.clamp();
        axis.sap(Ap::MaxCurrent, 1500);
        axis.sap(Ap::TargetCurrent, 5000 * sign);
        let (_, peak) = axis.range(2000, |axis| axis.amplitude_ma());
        assert!(peak < 1500.0 * 1.3, "{peak:.0} mA: \"temporarily exceeded marginally\" (§5.1)");
        let current_q = axis.mean(2000, |axis| axis.current_q_ma());
        assert!((current_q / f64::from(1500 * sign) - 1.0).abs() < 0.02, "{current_q:.1} mA");
        axis.sap(Ap::MaxCurrent, 3000);
        axis.run_ms(100);
        let current_q = axis.mean(2000, |axis| axis.current_q_ma());
        assert!(
            (current_q / f64::from(3000 * sign) - 1.0).abs() < 0.02,
            "the limit rises: {current_q:.1} mA"
        );
    }
}

#[test]
fn the_current_arrives_without_overshoot_and_stays() {
    let mut axis = Bldc::aligned();
    axis.clamp();
    axis.sap(Ap::TargetCurrent, 4000);
    let (_, peak) = axis.range(4000, |axis| axis.current_q_ma());
    assert!(peak < 4000.0 * 1.1, "{peak:.0} mA for 4000");
    let (low, high) = axis.range(400, |axis| axis.current_q_ma());
    assert!(low > 3920.0 && high < 4080.0, "{low:.0} to {high:.0} mA 200 ms after");
}

/// AP 150 in torque mode, and in velocity mode at work.
#[test]
fn the_current_read_is_the_current_that_flows() {
    let mut axis = Bldc::aligned();
    axis.clamp();
    for target in CURRENTS_MA {
        torque(&mut axis, target);
        let (read, real) = (f64::from(axis.gap(Ap::MotorCurrent)), axis.current_q_ma());
        assert!((read - real).abs() < 20.0 + 0.01 * real.abs(), "AP 150 = {read}, but {real:.1} mA");
    }
    axis.release();
    axis.set("load.friction_nm", 0.06);
    axis.rotate(1000);
    axis.run_ms(1500);
    let read = axis.mean(2000, |axis| f64::from(axis.gap(Ap::MotorCurrent)));
    let real = axis.mean(2000, |axis| axis.current_q_ma());
    assert!((read / real - 1.0).abs() < 0.02, "AP 150 = {read:.1}, but {real:.1} mA");
}

/// AP 155 is what was written in torque mode, and elsewhere what the velocity regulator demands (§5).
#[test]
fn the_target_current_reads_what_is_wanted() {
    let mut axis = Bldc::aligned();
    axis.clamp();
    assert_eq!(axis.gap(Ap::TargetCurrent), 0);
    for target in [750, -750] {
        torque(&mut axis, target);
        assert_eq!(axis.gap(Ap::TargetCurrent), target);
        assert!(axis.flag(flag::TORQUE_MODE));
        assert!(!axis.flag(flag::VELOCITY_MODE) && !axis.flag(flag::POSITION_MODE));
    }
    axis.release();
    axis.set("load.friction_nm", torque_nm(1.5));
    axis.rotate(800);
    axis.run_ms(1500);
    let wanted = axis.mean(2000, |axis| f64::from(axis.gap(Ap::TargetCurrent)));
    assert!((1400.0..1900.0).contains(&wanted), "{wanted:.0} mA against friction of 1500");
    assert!(!axis.flag(flag::TORQUE_MODE));
}

/// AP 200 is small once the current is there, and the sum of AP 201 is what holds it: I · sum / 65 536 is the voltage.
#[test]
fn the_error_sum_carries_the_voltage_of_the_winding() {
    let mut axis = Bldc::aligned();
    axis.clamp();
    torque(&mut axis, 4000);
    let error = axis.mean(2000, |axis| f64::from(axis.gap(Ap::CurrentPidError)));
    assert!(error.abs() < 60.0, "AP 200 = {error:.1}");
    // Half of the 0.72 Ω between two lines at 4 A is 1.44 V; 32 767 is 24 V / √3 (decisions 6.2, 8.3).
    let sum = axis.mean(2000, |axis| f64::from(axis.gap(Ap::CurrentPidErrorSum)));
    let gain = f64::from(axis.gap(Ap::CurrentI));
    let volts = sum * gain / 65_536.0 / 32_767.0 * 24.0 / 3.0_f64.sqrt();
    assert!((volts / 1.44 - 1.0).abs() < 0.15, "{volts:.2} V");
}

#[test]
fn torque_mode_ends_with_the_next_command_and_a_stop_brakes() {
    let mut axis = Bldc::aligned();
    axis.sap(Ap::TargetCurrent, 200);
    axis.run_ms(300);
    assert!(axis.rpm() > 200.0, "{}", axis.figures());
    axis.halt();
    assert!(axis.flag(flag::VELOCITY_MODE));
    axis.run_ms(3500);
    assert!(axis.rpm().abs() < 15.0, "{}", axis.figures());
}

/// The rotor of 48 g·cm² follows T = J · dω/dt, from the current that flows (decisions 8.2).
#[test]
fn a_free_rotor_accelerates_as_its_inertia_says() {
    let mut axis = Bldc::aligned();
    axis.sap(Ap::TargetCurrent, 1000);
    axis.run_ms(5);
    let start = axis.rpm();
    let current_q = axis.mean(200, |axis| axis.current_q_ma());
    let measured = (axis.rpm() - start) / 60.0 * std::f64::consts::TAU / 0.01;
    let wanted = (torque_nm(current_q / 1000.0) - 0.002) / 48e-7;
    assert!((measured / wanted - 1.0).abs() < 0.1, "{measured:.0} rad/s², not {wanted:.0}");
    assert!((current_ma(torque_nm(1.0)) - 1000.0).abs() < 1e-9);
}

/// The back-EMF rises as the rotor speeds up; the regulator has to keep up with it.
#[test]
fn while_it_accelerates_the_torque_current_keeps_near_its_target() {
    let mut axis = Bldc::aligned();
    axis.set("load.inertia_kgm2", 5e-5);
    axis.sap(Ap::TargetCurrent, 2000);
    axis.run_ms(100);
    let current_q = axis.mean(400, |axis| axis.current_q_ma());
    assert!((current_q / 2000.0 - 1.0).abs() < 0.1, "{current_q:.0} mA of 2000; {}", axis.figures());
}
