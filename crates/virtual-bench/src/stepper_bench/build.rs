//! A stepper module's hardware as the bench file describes it.

use driver_chips::tmc262::{Board, Tmc262};
use module_firmware::tmcm_1311::Sensed;
use motor_physics::heat::{HeatParameters, HeatedBody};
use motor_physics::stepper::{Stepper, StepperParameters};
use motor_physics::supply::Supply;
use motor_physics::switch::LimitSwitch;

use super::pulse_source::PulseSource;
use super::{StepperBench, SurroundingsState};
use crate::bench_parts::{encoder, levels, mechanics};
use crate::config::{ModuleConfig, MotorConfig};
use crate::kind::ModuleKind;

/// The TMCM-1311's power stage: 3 A RMS (TMCM-1311 §2).
pub(super) const BOARD: Board = Board { full_scale_rms_a: 3.0 };

impl StepperBench {
    /// Everything at rest, the shaft at 0.
    pub(crate) fn new(config: &ModuleConfig) -> Self {
        let parameters = motor(config);
        let motor = Stepper::new(parameters, mechanics(&config.load, parameters.rotor_inertia_kgm2));
        let turns = motor.turns();
        let switches = [config.switches.left, config.switches.right, config.switches.home];
        let mut bench = Self {
            chip: Tmc262::new(BOARD),
            load: config.load.torque.clone(),
            encoder: encoder(&config.encoder, turns),
            encoder_has_index: config.encoder.index,
            switches: switches.map(|switch| switch.map(|switch| LimitSwitch::new(switch, turns))),
            pulses: pulse_source(config),
            supply: Supply::new(config.supply),
            winding: HeatedBody::new(HeatParameters::stepper_winding(&parameters)),
            board: HeatedBody::new(HeatParameters::board()),
            surroundings: surroundings(config),
            motor,
            time_ns: 0,
            heat_from_pj: 0,
            sensed: Sensed::default(),
            coils: [0, 0],
            load_nm: 0.0,
            moved: false,
        };
        bench.sense();
        bench
    }
}

fn surroundings(config: &ModuleConfig) -> SurroundingsState {
    let analog = |number: u8| config.inputs.analog.get(&number).copied().unwrap_or(0);
    SurroundingsState {
        powered: true,
        ambient_c: config.temperature_c,
        board_temperature_c: None,
        open_coil: None,
        shorted_coil: None,
        enabled: config.step_dir.enabled,
        inputs: levels(&config.inputs),
        analog_inputs: [analog(0), analog(4)],
    }
}

fn pulse_source(config: &ModuleConfig) -> PulseSource {
    let mut source = PulseSource::default();
    source.set_frequency(config.step_dir.frequency_hz);
    source.set_pulses(config.step_dir.pulses);
    source
}

/// The bench file's parser lets no other motor near a stepper module; built by hand, a wrong one becomes the default.
fn motor(config: &ModuleConfig) -> StepperParameters {
    let default = || MotorConfig::default_for(ModuleKind::Tmcm1311).stepper();
    config.motor.stepper().or_else(default).expect("the TMCM-1311's default motor is a stepper")
}
