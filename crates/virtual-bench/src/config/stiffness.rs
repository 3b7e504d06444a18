//! Whether the physics can follow a motor and its load.
//!
//! The equations are integrated in one step a control period of 50 µs. What decays or swings faster than that resolves would
//! come out as infinities, not as a fast motor.

use motor_physics::pmsm::PmsmParameters;
use motor_physics::stepper::StepperParameters;

use super::load::LoadConfig;
use super::module::ModuleConfig;
use bench_hardware::MotorFamily;

/// Rates of decay and angular frequencies at most, in 1/s: half a radian in a control period. The fastest motor of the
/// presets stays below half of it.
const FASTEST: f64 = 10_000.0;

/// What decays or swings, how fast in 1/s, and which figures make it so.
type Rate = (&'static str, f64, &'static str);

/// What is too fast about a module's motor and load, and which figures make it so.
pub(super) fn too_fast(module: &ModuleConfig) -> Option<(String, String)> {
    let rates = match module.kind.motor() {
        MotorFamily::Stepper => stepper_rates(&module.motor.stepper()?, &module.load),
        MotorFamily::Brushless => {
            brushless_rates(&module.motor.brushless()?, &module.load, module.supply.voltage_v)
        }
    };
    let (what, rate, figures) = rates.into_iter().find(|(_, rate, _)| *rate > FASTEST)?;
    let message = format!(
        "this motor and load are too fast for the bench: {what} {rate:.0} 1/s, at most {FASTEST} is followed"
    );
    Some((message, format!("check {figures}")))
}

fn stepper_rates(motor: &StepperParameters, load: &LoadConfig) -> Vec<Rate> {
    // Torque grows with current; a module may drive a small motor with far more than its rated current.
    let overdrive = (TMCM_1311_RMS_A / motor.rated_current_rms_a).max(1.0);
    let stiffness = motor.pole_pairs * (motor.holding_torque_nm * overdrive + 4.0 * motor.detent_torque_nm);
    let inertia_kgm2 = motor.rotor_inertia_kgm2 + load.inertia_kgm2;
    vec![
        (
            "the winding current decays with",
            motor.resistance_ohm / motor.inductance_h,
            "resistance_ohm and inductance_h",
        ),
        (
            "the rotor swings with",
            libm::sqrt(stiffness / inertia_kgm2),
            "rated_current_a, holding_torque_nm, full_steps and rotor_inertia_kgm2",
        ),
        viscous_rate(load, inertia_kgm2),
    ]
}

fn brushless_rates(motor: &PmsmParameters, load: &LoadConfig, supply_v: f64) -> Vec<Rate> {
    let inertia_kgm2 = motor.rotor_inertia_kgm2 + load.inertia_kgm2;
    // A field holds the rotor with the torque of its current; the magnets and the inductance are a spring of their own.
    let held_a = TMCM_1640_AMPLITUDE_A + motor.flux_linkage_wb / motor.q_inductance_h;
    let stiffness = 1.5 * motor.pole_pairs * motor.pole_pairs * motor.flux_linkage_wb * held_a;
    let free_rad_s = supply_v / libm::sqrt(3.0) / motor.flux_linkage_wb;
    vec![
        (
            "the winding current decays with",
            motor.resistance_ohm / motor.q_inductance_h,
            "line_resistance_ohm and line_inductance_h",
        ),
        (
            "the rotor swings with",
            libm::sqrt(stiffness / inertia_kgm2),
            "pole_pairs, torque_constant_nm_per_a, line_inductance_h and rotor_inertia_kgm2",
        ),
        (
            "without load the field turns with",
            free_rad_s,
            "pole_pairs, torque_constant_nm_per_a and the supply's voltage_v",
        ),
        viscous_rate(load, inertia_kgm2),
    ]
}

fn viscous_rate(load: &LoadConfig, inertia_kgm2: f64) -> Rate {
    (
        "viscous friction brakes with",
        load.viscous_nm_s_per_rad / inertia_kgm2,
        "viscous_nm_s_per_rad, inertia_kgm2 and rotor_inertia_kgm2",
    )
}

/// The RMS current that a TMCM-1311 can drive (TMCM-1311 §2).
const TMCM_1311_RMS_A: f64 = 3.0;

/// The amplitude of the 5 A RMS that a TMCM-1640 can drive (TMCM-1640 §1).
const TMCM_1640_AMPLITUDE_A: f64 = 5.0 * core::f64::consts::SQRT_2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ModuleKind;
    use crate::config::{BldcConfig, MotorConfig};
    use motor_physics::presets::{PMSMS, STEPPERS};

    #[test]
    fn every_preset_is_followed_with_the_default_load() {
        for (name, _) in STEPPERS {
            let motor = MotorConfig::Preset(name);
            let module = ModuleConfig { motor, ..ModuleConfig::default_for(ModuleKind::Tmcm1311, "m1") };
            assert_eq!(too_fast(&module), None, "{name}");
        }
        for (name, _) in PMSMS {
            let motor = MotorConfig::Preset(name);
            let module = ModuleConfig { motor, ..ModuleConfig::default_for(ModuleKind::Tmcm1640, "m1") };
            assert_eq!(too_fast(&module), None, "{name}");
        }
    }

    #[test]
    fn each_rate_of_a_brushless_motor_is_checked() {
        let module = ModuleConfig::default_for(ModuleKind::Tmcm1640, "m1");
        let figures = BldcConfig {
            pole_pairs: 4,
            torque_constant_nm_per_a: 0.036,
            line_resistance_ohm: 0.72,
            line_inductance_h: 1.2e-3,
            rated_current_a: 3.47,
            rotor_inertia_kgm2: 4.8e-6,
            winding_time_constant_s: 13.2,
        };
        let with = |figures| ModuleConfig { motor: MotorConfig::Bldc(figures), ..module.clone() };
        assert_eq!(too_fast(&with(figures.clone())), None);
        assert!(too_fast(&with(BldcConfig { line_resistance_ohm: 100.0, ..figures.clone() })).is_some());
        assert!(too_fast(&with(BldcConfig { rotor_inertia_kgm2: 1e-9, ..figures.clone() })).is_some());
        assert!(too_fast(&with(BldcConfig { torque_constant_nm_per_a: 1e-3, ..figures })).is_some());
        let mut sticky = module.clone();
        sticky.load.viscous_nm_s_per_rad = 0.5;
        assert!(too_fast(&sticky).is_some());
    }

    #[test]
    fn each_rate_is_checked() {
        let module = ModuleConfig::default_for(ModuleKind::Tmcm1311, "m1");
        let motor = module.motor.stepper().expect("a stepper");
        let with = |motor| ModuleConfig { motor: MotorConfig::Stepper(motor), ..module.clone() };
        assert!(too_fast(&with(motor)).is_none());
        assert!(too_fast(&with(StepperParameters { inductance_h: 1e-5, ..motor })).is_some());
        assert!(too_fast(&with(StepperParameters { rotor_inertia_kgm2: 1e-8, ..motor })).is_some());
        let mut sticky = module.clone();
        sticky.load.viscous_nm_s_per_rad = 0.5;
        assert!(too_fast(&sticky).is_some());
    }
}
