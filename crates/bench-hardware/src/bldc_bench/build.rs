//! The hardware of a module for brushless motors made of its parts.

use driver_chips::tmc603::{Board, Tmc603};
use module_firmware::tmcm_1640::Sensed;
use motor_physics::hall::HallSensors;
use motor_physics::heat::{HeatParameters, HeatedBody};
use motor_physics::pmsm::Pmsm;
use motor_physics::supply::Supply;
use motor_physics::switch::LimitSwitch;

use super::{BldcBench, SurroundingsState};
use crate::bench_parts::encoder;
use crate::parts::BldcParts;

/// The TMCM-1640's power stage. The transistors' resistance is chosen, as of MOSFETs for 5 A RMS (TMCM-1640 §1) on a board of
/// this size; overcurrent is where the TMC603's datasheet ends, 30 A.
pub(super) const BOARD: Board = Board { on_resistance_ohm: 0.015, overcurrent_a: 30.0 };

impl BldcBench {
    /// Everything at rest, the shaft at 0.
    #[must_use]
    pub fn new(parts: &BldcParts) -> Self {
        let common = &parts.common;
        let motor = Pmsm::new(parts.motor, common.mechanics);
        let turns = motor.turns();
        let mut bench = Self {
            chip: Tmc603::new(BOARD),
            load: common.load.clone(),
            encoder: encoder(&common.encoder, turns),
            encoder_has_index: common.encoder.index,
            halls: halls(parts),
            switches: parts.switches.map(|switch| switch.map(|switch| LimitSwitch::new(switch, turns))),
            supply: Supply::new(common.supply),
            winding: HeatedBody::new(HeatParameters::pmsm_winding(&parts.motor)),
            board: HeatedBody::new(HeatParameters::board()),
            surroundings: surroundings(parts),
            motor,
            time_ns: 0,
            heat_from_pj: 0,
            driver_temperature_adc: 0,
            sensed: Sensed::default(),
            load_nm: 0.0,
            moved: false,
        };
        bench.read_ntc();
        bench.sense();
        bench
    }
}

fn surroundings(parts: &BldcParts) -> SurroundingsState {
    SurroundingsState {
        powered: true,
        ambient_c: parts.common.ambient_c,
        board_temperature_c: None,
        open_phase: None,
        shorted_phase: None,
        inputs: parts.common.inputs,
        analog_input: parts.analog_input,
    }
}

fn halls(parts: &BldcParts) -> HallSensors {
    HallSensors {
        offset_rad: parts.halls_offset_deg.to_radians(),
        inverted: parts.halls_inverted,
        ..HallSensors::default()
    }
}
