//! A stepper module's hardware made of its parts.

use driver_chips::tmc262::{Board, Tmc262};
use module_firmware::tmcm_1311::Sensed;
use motor_physics::switch::LimitSwitch;

use super::{StepperBench, SurroundingsState};
use crate::bench_parts::encoder;
use crate::parts::StepperParts;
use crate::pulse_source::PulseSource;
use crate::stepper_stage::StepperStage;

/// The TMCM-1311's power stage: 3 A RMS (TMCM-1311 §2).
pub(super) const BOARD: Board = Board { full_scale_rms_a: 3.0 };

impl StepperBench {
    /// Everything at rest, the shaft at 0.
    #[must_use]
    pub fn new(parts: &StepperParts) -> Self {
        let stage = StepperStage::new(&parts.common, parts.motor);
        let turns = stage.motor.turns();
        let mut bench = Self {
            chip: Tmc262::new(BOARD),
            encoder: encoder(&parts.common.encoder, turns),
            encoder_has_index: parts.common.encoder.index,
            switches: parts.switches.map(|switch| switch.map(|switch| LimitSwitch::new(switch, turns))),
            pulses: PulseSource::connected(&parts.pulses),
            surroundings: surroundings(parts),
            stage,
            sensed: Sensed::default(),
            coils: [0, 0],
        };
        bench.sense();
        bench
    }
}

fn surroundings(parts: &StepperParts) -> SurroundingsState {
    SurroundingsState {
        enabled: parts.enabled,
        inputs: parts.common.inputs,
        analog_inputs: parts.analog_inputs,
    }
}
