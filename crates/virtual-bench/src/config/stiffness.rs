//! Whether the physics can follow a motor and its load.
//!
//! The equations are integrated in one step a control period of 50 µs. What decays or swings faster than that resolves would
//! come out as infinities, not as a fast motor.

use motor_physics::stepper::StepperParameters;

use super::load::LoadConfig;
use super::module::ModuleConfig;
use crate::ModuleKind;

/// Rates of decay and angular frequencies at most, in 1/s: half a radian in a control period. The fastest motor of the
/// presets stays below half of it.
const FASTEST: f64 = 10_000.0;

/// What is too fast about a module's motor and load, and which figures make it so.
pub(super) fn too_fast(module: &ModuleConfig) -> Option<(String, String)> {
    let motor = module.motor.stepper()?;
    let ModuleConfig { kind, load, .. } = module;
    let (what, rate, figures) =
        rates(&motor, load, *kind).into_iter().find(|(_, rate, _)| *rate > FASTEST)?;
    let message = format!(
        "this motor and load are too fast for the bench: {what} {rate:.0} 1/s, at most {FASTEST} is followed"
    );
    Some((message, format!("check {figures}")))
}

fn rates(
    motor: &StepperParameters,
    load: &LoadConfig,
    kind: ModuleKind,
) -> [(&'static str, f64, &'static str); 3] {
    // Torque grows with current; a module may drive a small motor with far more than its rated current.
    let overdrive = (full_scale_rms_a(kind) / motor.rated_current_rms_a).max(1.0);
    let stiffness = motor.pole_pairs * (motor.holding_torque_nm * overdrive + 4.0 * motor.detent_torque_nm);
    let inertia_kgm2 = motor.rotor_inertia_kgm2 + load.inertia_kgm2;
    [
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
        (
            "viscous friction brakes with",
            load.viscous_nm_s_per_rad / inertia_kgm2,
            "viscous_nm_s_per_rad, inertia_kgm2 and rotor_inertia_kgm2",
        ),
    ]
}

/// The RMS current that a module can drive (TMCM-1311 §2).
const fn full_scale_rms_a(kind: ModuleKind) -> f64 {
    match kind {
        ModuleKind::Tmcm1311 => 3.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::MotorConfig;
    use motor_physics::presets::STEPPERS;

    #[test]
    fn every_preset_is_followed_with_the_default_load() {
        for (name, _) in STEPPERS {
            let motor = MotorConfig::Preset(name);
            let module = ModuleConfig { motor, ..ModuleConfig::default_for(ModuleKind::Tmcm1311, "m1") };
            assert_eq!(too_fast(&module), None, "{name}");
        }
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
