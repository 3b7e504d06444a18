//! A stepper module's hardware made of its parts.

use driver_chips::tmc262::{Board, Tmc262};
use module_firmware::tmcm_1311::Sensed;
use motor_physics::heat::{HeatParameters, HeatedBody};
use motor_physics::stepper::Stepper;
use motor_physics::supply::Supply;
use motor_physics::switch::LimitSwitch;

use super::pulse_source::PulseSource;
use super::{StepperBench, SurroundingsState};
use crate::bench_parts::encoder;
use crate::parts::StepperParts;

/// The TMCM-1311's power stage: 3 A RMS (TMCM-1311 §2).
pub(super) const BOARD: Board = Board { full_scale_rms_a: 3.0 };

impl StepperBench {
    /// Everything at rest, the shaft at 0.
    #[must_use]
    pub fn new(parts: &StepperParts) -> Self {
        let common = &parts.common;
        let motor = Stepper::new(parts.motor, common.mechanics);
        let turns = motor.turns();
        let mut bench = Self {
            chip: Tmc262::new(BOARD),
            load: common.load.clone(),
            encoder: encoder(&common.encoder, turns),
            encoder_has_index: common.encoder.index,
            switches: parts.switches.map(|switch| switch.map(|switch| LimitSwitch::new(switch, turns))),
            pulses: pulse_source(parts),
            supply: Supply::new(common.supply),
            winding: HeatedBody::new(HeatParameters::stepper_winding(&parts.motor)),
            board: HeatedBody::new(HeatParameters::board()),
            surroundings: surroundings(parts),
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

fn surroundings(parts: &StepperParts) -> SurroundingsState {
    SurroundingsState {
        powered: true,
        ambient_c: parts.common.ambient_c,
        board_temperature_c: None,
        open_coil: None,
        shorted_coil: None,
        enabled: parts.enabled,
        inputs: parts.common.inputs,
        analog_inputs: parts.analog_inputs,
    }
}

fn pulse_source(parts: &StepperParts) -> PulseSource {
    let mut source = PulseSource::default();
    source.set_frequency(parts.pulse_frequency_hz);
    source.set_pulses(parts.pulses);
    source
}
