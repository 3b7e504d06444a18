//! What can be changed about a stepper module's surroundings while it runs.

use driver_chips::tmc262::Tmc262;

use super::StepperBench;
use super::build::BOARD;
use crate::Surroundings;
use crate::bench_parts::{encoder_fault, restarted, stick, with_level};
use crate::{Power, Setting, SwitchName};

impl Surroundings for StepperBench {
    fn apply(&mut self, setting: Setting) {
        if let Some(setting) = self.stage.apply(setting) {
            self.connect(&setting);
        }
        // What changed may show at once, even if nothing moves; an index that the firmware has not seen yet stays.
        let index_pending = self.sensed.encoder_index;
        self.sense();
        self.sensed.encoder_index |= index_pending;
    }

    fn encoder_counts(&self) -> i32 {
        self.sensed.encoder_counts
    }

    fn step_pulses(&self) -> i64 {
        self.pulses.total()
    }
}

impl StepperBench {
    /// What is not the stage's.
    fn connect(&mut self, setting: &Setting) {
        let state = &mut self.surroundings;
        match *setting {
            Setting::Input { number, high } => {
                state.inputs = with_level(state.inputs, number, high);
            }
            Setting::AnalogInput { number, reading } => {
                let [ain_0, ain_4] = &mut state.analog_inputs;
                match number {
                    0 => *ain_0 = reading,
                    4 => *ain_4 = reading,
                    _ => {}
                }
            }
            Setting::EncoderLine(line) => self.encoder.fault = encoder_fault(line, self.encoder_has_index),
            Setting::SwitchContact { switch, stuck } => {
                let [left, right, home] = &mut self.switches;
                let switch = match switch {
                    SwitchName::Left => left,
                    SwitchName::Right => right,
                    SwitchName::Home => home,
                };
                stick(switch.as_mut(), stuck);
            }
            Setting::StepFrequencyHz(frequency_hz) => self.pulses.set_frequency(frequency_hz),
            Setting::StepAccelerationHzPerS(hz_per_s) => self.pulses.set_acceleration(hz_per_s),
            Setting::StepPulses(pulses) => self.pulses.set_pulses(pulses),
            Setting::StepEnable(enabled) => state.enabled = enabled,
            Setting::Power(power) => self.switch(power),
            // What is the stage's it has taken; a stepper has neither phases U, V, W nor hall sensors.
            _ => {}
        }
    }

    /// Without power the chip forgets what it found, and the encoder's counter how far it counted; the rotor keeps its
    /// place.
    fn switch(&mut self, power: Power) {
        self.stage.switch(power);
        self.chip = Tmc262::new(BOARD);
        self.pulses.forget_steps();
        self.encoder = restarted(&self.encoder, self.stage.motor.turns());
    }
}
