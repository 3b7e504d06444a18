//! Everything around the firmware of a TMCM-1076: driver chip, motor, load, supply, heat, and what comes in at STEP, DIR, ENABLE
//! and CHOP.
//!
//! In each control period the chip takes the edges on STEP that fall into it, with their times, and turns them into voltages
//! across the coils, which are held for the period while the motor's equations are integrated in one step.

mod lines;
mod settings;

use driver_chips::tmc5160::{
    Board, ChopConf, CoolConf, Edges, GConf, IHoldIRun, Inputs, PwmConf, Registers, Tmc5160,
};
use module_firmware::tmcm_1076::{Drive, Sensed};

use crate::TICK_NS;
use crate::config::ModuleConfig;
use crate::parts::{self, levels};
use bench_hardware::PERIOD_S;
use bench_hardware::PulseSource;
use bench_hardware::StepperStage;
use bench_hardware::{Hardware, Physical};
use lines::Lines;

/// The TMCM-1076's power stage: the current scale n makes n/31 of 3 A RMS (TMCM-1076 §4, §5.2).
const BOARD: Board = Board { full_scale_rms_a: 3.0, lowest_scale: 0.0 };

/// TPOWERDOWN after the chip's reset, which no parameter changes.
const TPOWERDOWN: u8 = 10;

/// Clocks of the chip in a control period.
const PERIOD_CLOCKS: u32 = 600;

/// The ports of the inputs (§3.5.5).
const CHOP: u8 = 0;
const ENABLE: u8 = 1;

/// The hardware of a TMCM-1076.
#[derive(Clone, Debug)]
pub(crate) struct StepBench {
    chip: Tmc5160,
    stage: StepperStage,
    pulses: PulseSource,
    lines: Lines,
    /// The edges of the last control period.
    edges: Vec<Edges>,
    /// CHOP and ENABLE as bits 0 and 1.
    inputs: u8,
    sensed: Sensed,
}

impl StepBench {
    /// Everything at rest, the shaft at 0.
    pub(crate) fn new(config: &ModuleConfig) -> Self {
        let motor = parts::stepper_motor(config);
        let mut bench = Self {
            chip: Tmc5160::new(BOARD),
            stage: StepperStage::new(&parts::common(config, motor.rotor_inertia_kgm2), motor),
            pulses: PulseSource::connected(&parts::pulses(&config.step_dir)),
            lines: Lines::playing(&config.step_dir.edges),
            edges: Vec::new(),
            inputs: levels(&config.inputs),
            sensed: Sensed::default(),
        };
        bench.sense();
        bench
    }

    /// What the firmware will be told next.
    fn sense(&mut self) {
        let status = self.chip.status();
        self.sensed = Sensed {
            chop: self.inputs >> CHOP & 1 == 1,
            enable: self.inputs >> ENABLE & 1 == 1,
            standstill: status.stst,
            stealth: status.stealth,
            tstep: status.tstep,
            cs_actual: status.cs_actual,
            sg_result: status.sg_result,
            pwm_scale_sum: status.pwm_scale_sum,
        };
    }
}

impl Hardware for StepBench {
    type Sensed = Sensed;
    type Drive = Drive;

    fn sensed(&self) -> Sensed {
        self.sensed
    }

    fn advance(&mut self, drive: &Drive, until_ns: u64) -> bool {
        // The rest is not looked at while the motor moves: it cannot rest before that does.
        let before = (!self.stage.moved).then_some((self.chip, self.stage.supply, self.sensed));
        self.pulses.advance();
        self.edges.clear();
        self.edges.extend(Some(self.pulses.edges(PERIOD_CLOCKS)).filter(|edges| edges.count > 0));
        self.lines.take(self.stage.time_ns, &mut self.edges);
        let pins = self.stage.pins();
        let inputs = Inputs { pins: &pins, enabled: drive.enabled, edges: &self.edges };
        let terminals = self.chip.advance(&registers(drive), inputs, PERIOD_S);
        self.stage.advance(terminals, until_ns);
        self.sense();
        // Edges are events: the next period has others, even if as many.
        let pulsed = !self.edges.is_empty();
        self.stage.moved || pulsed || before != Some((self.chip, self.stage.supply, self.sensed))
    }

    fn rest(&mut self, periods: u64, until_ns: u64) {
        self.stage.rest(periods, until_ns);
        self.pulses.rest(periods);
    }

    fn next_change_ns(&self) -> u64 {
        let time_ns = self.stage.time_ns;
        let Some(change_ns) = self.stage.next_change_ns() else { return time_ns + TICK_NS };
        let edge_ns = self.pulses.periods_to_edge().saturating_mul(TICK_NS).saturating_add(time_ns);
        edge_ns.min(change_ns).min(self.lines.next_change_ns())
    }

    fn physical(&self) -> Physical {
        self.stage.physical(self.chip.status().mscuract)
    }
}

fn registers(drive: &Drive) -> Registers {
    Registers {
        gconf: GConf { en_pwm_mode: drive.stealthchop, ..GConf::default() },
        global_scaler: 0,
        ihold_irun: IHoldIRun { ihold: drive.ihold, irun: drive.irun, iholddelay: drive.iholddelay },
        tpowerdown: TPOWERDOWN,
        tpwmthrs: drive.tpwmthrs,
        tcoolthrs: drive.tcoolthrs,
        thigh: drive.thigh,
        chopconf: ChopConf::from_bits(drive.chopconf),
        coolconf: CoolConf::from_bits(drive.coolconf),
        pwmconf: PwmConf::from_bits(drive.pwmconf),
    }
}
