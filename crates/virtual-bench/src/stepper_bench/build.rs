//! A stepper module's hardware as the bench file describes it.

use driver_chips::tmc262::{Board, Tmc262};
use module_firmware::tmcm_1311::Sensed;
use motor_physics::switch::LimitSwitch;

use super::{StepperBench, SurroundingsState};
use crate::bench_parts::{encoder, levels};
use crate::config::ModuleConfig;
use crate::pulse_source::PulseSource;
use crate::stepper_stage::StepperStage;

/// The TMCM-1311's power stage: 3 A RMS (TMCM-1311 §2).
pub(super) const BOARD: Board = Board { full_scale_rms_a: 3.0 };

impl StepperBench {
    /// Everything at rest, the shaft at 0.
    pub(crate) fn new(config: &ModuleConfig) -> Self {
        let stage = StepperStage::new(config);
        let turns = stage.motor.turns();
        let switches = [config.switches.left, config.switches.right, config.switches.home];
        let mut bench = Self {
            chip: Tmc262::new(BOARD),
            encoder: encoder(&config.encoder, turns),
            encoder_has_index: config.encoder.index,
            switches: switches.map(|switch| switch.map(|switch| LimitSwitch::new(switch, turns))),
            pulses: PulseSource::connected(&config.step_dir),
            surroundings: surroundings(config),
            stage,
            sensed: Sensed::default(),
            coils: [0, 0],
        };
        bench.sense();
        bench
    }
}

fn surroundings(config: &ModuleConfig) -> SurroundingsState {
    let analog = |number: u8| config.inputs.analog.get(&number).copied().unwrap_or(0);
    SurroundingsState {
        enabled: config.step_dir.enabled,
        inputs: levels(&config.inputs),
        analog_inputs: [analog(0), analog(4)],
    }
}
