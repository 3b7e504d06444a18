//! The hardware of a module for brushless motors as the bench file describes it.

use driver_chips::tmc603::{Board, Tmc603};
use module_firmware::tmcm_1640::Sensed;
use motor_physics::hall::HallSensors;
use motor_physics::heat::{HeatParameters, HeatedBody};
use motor_physics::pmsm::{Pmsm, PmsmParameters};
use motor_physics::supply::Supply;
use motor_physics::switch::LimitSwitch;

use super::{BldcBench, SurroundingsState};
use crate::bench_parts::{encoder, levels, mechanics};
use crate::config::{HallsConfig, ModuleConfig, MotorConfig};
use crate::kind::ModuleKind;

/// The TMCM-1640's power stage. The transistors' resistance is chosen, as of MOSFETs for 5 A RMS (TMCM-1640 §1) on a board of
/// this size; overcurrent is where the TMC603's datasheet ends, 30 A.
pub(super) const BOARD: Board = Board { on_resistance_ohm: 0.015, overcurrent_a: 30.0 };

impl BldcBench {
    /// Everything at rest, the shaft at 0.
    pub(crate) fn new(config: &ModuleConfig) -> Self {
        let parameters = motor(config);
        let motor = Pmsm::new(parameters, mechanics(&config.load, parameters.rotor_inertia_kgm2));
        let turns = motor.turns();
        let switches = [config.switches.left, config.switches.right];
        let mut bench = Self {
            chip: Tmc603::new(BOARD),
            load: config.load.torque.clone(),
            encoder: encoder(&config.encoder, turns),
            encoder_has_index: config.encoder.index,
            halls: halls(&config.halls),
            switches: switches.map(|switch| switch.map(|switch| LimitSwitch::new(switch, turns))),
            supply: Supply::new(config.supply),
            winding: HeatedBody::new(HeatParameters::pmsm_winding(&parameters)),
            board: HeatedBody::new(HeatParameters::board()),
            surroundings: surroundings(config),
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

fn surroundings(config: &ModuleConfig) -> SurroundingsState {
    SurroundingsState {
        powered: true,
        ambient_c: config.temperature_c,
        board_temperature_c: None,
        open_phase: None,
        shorted_phase: None,
        inputs: levels(&config.inputs),
        analog_input: config.inputs.analog.get(&0).copied().unwrap_or(0),
    }
}

fn halls(config: &HallsConfig) -> HallSensors {
    HallSensors {
        offset_rad: config.offset_deg.to_radians(),
        inverted: config.inverted,
        ..HallSensors::default()
    }
}

/// The bench file's parser lets no other motor near a module for brushless ones; built by hand, a wrong one becomes the
/// default.
fn motor(config: &ModuleConfig) -> PmsmParameters {
    let default = || MotorConfig::default_for(ModuleKind::Tmcm1640).brushless();
    config.motor.brushless().or_else(default).expect("the TMCM-1640's default motor is brushless")
}
