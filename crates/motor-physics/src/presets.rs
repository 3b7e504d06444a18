//! Motors by their maker's name, from the maker's datasheets.
//!
//! The figures are those of the tables in decisions §8.3. Friction and load belong to the shaft and stand in
//! [`crate::mechanics`].

use core::f64::consts::TAU;

use crate::pmsm::PmsmParameters;
use crate::stepper::StepperParameters;

/// Counts that the encoder on a QBL4208 makes in a turn.
pub const QBL4208_ENCODER_COUNTS: u32 = 4096;

/// The two-phase hybrid steppers, 200 full steps to the turn.
pub const STEPPERS: &[(&str, StepperParameters)] = &[
    ("QSH4218-35-10-027", hybrid(1.0, 5.3, 6.6e-3, 0.27, 0.022, 35.0, 18.0)),
    ("QSH4218-51-10-049", hybrid(1.0, 5.0, 8.0e-3, 0.49, 0.028, 68.0, 22.0)),
    ("QSH5718-51-28-101", hybrid(2.8, 0.83, 2.2e-3, 1.01, 0.035, 275.0, 22.0)),
    ("QSH5718-76-28-189", hybrid(2.8, 1.13, 3.6e-3, 1.89, 0.066, 480.0, 30.0)),
];

/// The brushless motors: 8 poles, 24 V, 4000 rpm.
pub const PMSMS: &[(&str, PmsmParameters)] = &[
    ("QBL4208-61-04-013", brushless([3.47, 10.6], [0.125, 0.38], 0.72, 1.2e-3, 48.0)),
    ("QBL4208-100-04-025", brushless([6.95, 20.0], [0.25, 0.75], 0.28, 0.54e-3, 96.0)),
];

/// The stepper of this name.
#[must_use]
pub fn stepper(name: &str) -> Option<StepperParameters> {
    named(STEPPERS, name)
}

/// The brushless motor of this name.
#[must_use]
pub fn pmsm(name: &str) -> Option<PmsmParameters> {
    named(PMSMS, name)
}

fn named<T: Copy>(motors: &[(&str, T)], name: &str) -> Option<T> {
    motors.iter().find(|(known, _)| *known == name).map(|&(_, parameters)| parameters)
}

const KGM2_PER_GCM2: f64 = 1e-7;

const fn hybrid(
    rated_current_rms_a: f64,
    resistance_ohm: f64,
    inductance_h: f64,
    holding_torque_nm: f64,
    detent_torque_nm: f64,
    inertia_gcm2: f64,
    winding_time_constant_min: f64,
) -> StepperParameters {
    StepperParameters {
        rated_current_rms_a,
        resistance_ohm,
        inductance_h,
        holding_torque_nm,
        detent_torque_nm,
        rotor_inertia_kgm2: inertia_gcm2 * KGM2_PER_GCM2,
        pole_pairs: 50.0,
        winding_time_constant_s: winding_time_constant_min * 60.0,
    }
}

/// A QBL4208 from its datasheet, which measures between two terminals of the delta-wound motor; the star that behaves the
/// same has half the resistance and inductance in each phase.
///
/// The datasheet gives the inertia in kg·m² with a figure ten times larger than its rotor could have (decision), and no
/// thermal time constant: 13.2 s is what the TMCM-1640 §9 assumes for these windings.
const fn brushless(
    [rated_current_a, peak_current_a]: [f64; 2],
    [rated_torque_nm, peak_torque_nm]: [f64; 2],
    line_to_line_ohm: f64,
    line_to_line_h: f64,
    inertia_gcm2: f64,
) -> PmsmParameters {
    let (pole_pairs, torque_constant_nm_per_a) = (4.0, 0.036);
    PmsmParameters {
        pole_pairs,
        resistance_ohm: line_to_line_ohm / 2.0,
        d_inductance_h: line_to_line_h / 2.0,
        q_inductance_h: line_to_line_h / 2.0,
        flux_linkage_wb: PmsmParameters::flux_linkage_from(torque_constant_nm_per_a, pole_pairs),
        rotor_inertia_kgm2: inertia_gcm2 * KGM2_PER_GCM2,
        rated_voltage_v: 24.0,
        rated_velocity_rad_s: 4000.0 / 60.0 * TAU,
        rated_current_a,
        rated_torque_nm,
        peak_current_a,
        peak_torque_nm,
        winding_time_constant_s: 13.2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motors_are_found_by_name() {
        let motor = stepper("QSH5718-51-28-101").expect("a preset");
        assert_eq!((motor.holding_torque_nm, motor.resistance_ohm), (1.01, 0.83));
        assert!((motor.rotor_inertia_kgm2 - 27.5e-6).abs() < 1e-15);
        assert_eq!(motor.winding_time_constant_s, 1320.0);
        assert_eq!(pmsm("QBL4208-61-04-013").map(|motor| motor.resistance_ohm), Some(0.36));
        assert_eq!((stepper("QBL4208-61-04-013"), pmsm("qbl")), (None, None));
    }

    /// The datasheets' torques follow from their currents: block commutation makes a current vector of 2/√3 times it.
    #[test]
    fn rated_and_peak_torques_follow_from_the_currents() {
        for (name, motor) in PMSMS {
            let torque_nm = |current_a: f64| motor.torque_nm(0.0, 2.0 / libm::sqrt(3.0) * current_a);
            assert!((torque_nm(motor.rated_current_a) / motor.rated_torque_nm - 1.0).abs() < 0.01, "{name}");
            assert!((torque_nm(motor.peak_current_a) / motor.peak_torque_nm - 1.0).abs() < 0.05, "{name}");
        }
    }
}
