//! What can be changed about a TMCM-1076's surroundings while it runs.

use driver_chips::tmc5160::Tmc5160;

use super::{BOARD, ENABLE, StepBench};
use crate::config::{Power, Setting};
use bench_hardware::PulseLevels;
use bench_hardware::Surroundings;
use bench_hardware::with_level;

impl Surroundings for StepBench {
    fn apply(&mut self, setting: Setting) {
        if let Some(setting) = self.stage.apply(setting) {
            self.connect(&setting);
        }
        // What changed may show at once, even if nothing moves.
        self.sense();
    }

    /// It has no encoder.
    fn encoder_counts(&self) -> i32 {
        0
    }

    fn step_pulses(&self) -> i64 {
        self.pulses.total() + self.lines.total()
    }

    fn pulse_levels(&self) -> PulseLevels {
        self.lines.levels()
    }
}

impl StepBench {
    /// What is not the stage's.
    fn connect(&mut self, setting: &Setting) {
        match *setting {
            Setting::Input { number, high } => self.inputs = with_level(self.inputs, number, high),
            Setting::StepFrequencyHz(frequency_hz) => self.pulses.set_frequency(frequency_hz),
            Setting::StepAccelerationHzPerS(hz_per_s) => self.pulses.set_acceleration(hz_per_s),
            Setting::StepPulses(pulses) => self.pulses.set_pulses(pulses),
            // Active is low.
            Setting::StepEnable(enabled) => self.inputs = with_level(self.inputs, ENABLE, !enabled),
            Setting::StepLevel(high) => self.lines.set_step(high),
            Setting::DirLevel(high) => self.lines.set_dir(high),
            Setting::Power(power) => self.switch(power),
            // It has neither encoder, switches nor analogue inputs, and its motor neither phases U, V, W nor hall sensors.
            _ => {}
        }
    }

    /// Without power the chip forgets everything, where in its table it was too; the rotor keeps its place.
    fn switch(&mut self, power: Power) {
        self.stage.switch(power);
        self.chip = Tmc5160::new(BOARD);
        self.pulses.forget_steps();
    }
}
