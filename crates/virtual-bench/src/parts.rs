//! The parts of modules' hardware as the bench file describes them.

use bench_hardware::parts::{BldcParts, CommonParts, EncoderParts, PulseParts, StepperParts};
use motor_physics::mechanics::Mechanics;
use motor_physics::pmsm::PmsmParameters;
use motor_physics::stepper::StepperParameters;

use crate::config::{EncoderConfig, InputsConfig, LoadConfig, ModuleConfig, MotorConfig, StepDirConfig};

/// What every module has, with a rotor of this inertia.
pub(crate) fn common(config: &ModuleConfig, rotor_inertia_kgm2: f64) -> CommonParts {
    CommonParts {
        mechanics: mechanics(&config.load, rotor_inertia_kgm2),
        load: config.load.torque.clone(),
        encoder: encoder(&config.encoder),
        supply: config.supply,
        ambient_c: config.temperature_c,
        inputs: levels(&config.inputs),
    }
}

/// The hardware of a TMCM-1311.
pub(crate) fn stepper(config: &ModuleConfig) -> StepperParts {
    let motor = stepper_motor(config);
    let switches = &config.switches;
    StepperParts {
        common: common(config, motor.rotor_inertia_kgm2),
        motor,
        switches: [switches.left, switches.right, switches.home],
        pulses: pulses(&config.step_dir),
        enabled: config.step_dir.enabled,
        analog_inputs: [analog(&config.inputs, 0), analog(&config.inputs, 4)],
    }
}

/// The hardware of a TMCM-1640.
pub(crate) fn brushless(config: &ModuleConfig) -> BldcParts {
    let motor = brushless_motor(config);
    BldcParts {
        common: common(config, motor.rotor_inertia_kgm2),
        motor,
        switches: [config.switches.left, config.switches.right],
        halls_offset_deg: config.halls.offset_deg,
        halls_inverted: config.halls.inverted,
        analog_input: analog(&config.inputs, 0),
    }
}

/// What gives pulses.
pub(crate) fn pulses(config: &StepDirConfig) -> PulseParts {
    let &StepDirConfig { frequency_hz, acceleration_hz_per_s, pulses, .. } = config;
    PulseParts { frequency_hz, acceleration_hz_per_s, pulses }
}

/// The levels at inputs 0 to 7, as bits.
pub(crate) fn levels(inputs: &InputsConfig) -> u8 {
    let high = inputs.digital.iter().filter(|(number, high)| **high && **number < 8);
    high.fold(0, |levels, (number, _)| levels | (1 << number))
}

/// The bench file's parser lets no other motor near a stepper module; built by hand, a wrong one becomes the default.
pub(crate) fn stepper_motor(config: &ModuleConfig) -> StepperParameters {
    let default = || MotorConfig::default_for(config.kind).stepper();
    config.motor.stepper().or_else(default).expect("the default motor of a stepper module is a stepper")
}

/// Likewise.
fn brushless_motor(config: &ModuleConfig) -> PmsmParameters {
    let default = || MotorConfig::default_for(config.kind).brushless();
    config.motor.brushless().or_else(default).expect("the TMCM-1640's default motor is brushless")
}

fn mechanics(load: &LoadConfig, rotor_inertia_kgm2: f64) -> Mechanics {
    Mechanics {
        inertia_kgm2: rotor_inertia_kgm2 + load.inertia_kgm2,
        friction_nm: load.friction_nm,
        viscous_nm_s_per_rad: load.viscous_nm_s_per_rad,
        hard_stops: load.hard_stops,
    }
}

fn encoder(config: &EncoderConfig) -> EncoderParts {
    let &EncoderConfig { counts, offset_turns, inverted, index } = config;
    EncoderParts { counts, offset_turns, inverted, index }
}

fn analog(inputs: &InputsConfig, number: u8) -> u16 {
    inputs.analog.get(&number).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ModuleKind;

    /// An emulated chip has no bench file: what surrounds it must be what stands on the default bench.
    #[test]
    fn the_standard_parts_are_those_of_the_default_bench() {
        let config = |kind| ModuleConfig::default_for(kind, "m1");
        assert_eq!(Some(stepper(&config(ModuleKind::Tmcm1311))), StepperParts::standard());
        assert_eq!(Some(brushless(&config(ModuleKind::Tmcm1640))), BldcParts::standard());
    }
}
