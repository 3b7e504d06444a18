//! A host of a virtual TMCM-1076, and the pulse generator, switches and instruments around it.

use std::ops::{Deref, DerefMut};

use tmcl_tables::Command;
use tmcl_tables::tmcm_1076::AxisParameter;

use super::Module;

/// TSTEP at standstill (AP 135).
pub(crate) const STANDSTILL: i32 = 1_048_575;

/// What the bench calls the pins.
pub(crate) const CHOP: &str = "input.0";
pub(crate) const ENABLE: &str = "input.1";

/// A module with its pulse generator.
#[derive(Clone, Debug)]
pub(crate) struct StepDriver(Module);

impl Deref for StepDriver {
    type Target = Module;

    fn deref(&self) -> &Module {
        &self.0
    }
}

impl DerefMut for StepDriver {
    fn deref_mut(&mut self) -> &mut Module {
        &mut self.0
    }
}

impl StepDriver {
    /// As delivered, on the default bench.
    pub(crate) fn new() -> Self {
        Self::with("")
    }

    /// On the bench that a bench file describes.
    #[track_caller]
    pub(crate) fn on(bench_file: &str) -> Self {
        Self(Module::on(bench_file))
    }

    /// With more lines of its bench file.
    pub(crate) fn with(lines: &str) -> Self {
        Self(Module::on(&format!("[[module]]\nkind = \"tmcm-1076\"\n{lines}")))
    }

    #[track_caller]
    pub(crate) fn sap(&mut self, parameter: AxisParameter, value: i32) {
        self.ok(Command::SetAxisParameter, parameter.number(), 0, value);
    }

    #[track_caller]
    pub(crate) fn gap(&mut self, parameter: AxisParameter) -> i32 {
        self.ok(Command::GetAxisParameter, parameter.number(), 0, 0)
    }

    /// Pulses at a frequency that is reached, and left before the last of them, by a ramp.
    pub(crate) fn move_by(&mut self, pulses: i32, frequency_hz: u32) {
        self.set("step_dir.acceleration_hz_per_s", frequency_hz * 4);
        self.set("step_dir.frequency_hz", i64::from(frequency_hz) * i64::from(pulses.signum()));
        self.set("step_dir.pulses", pulses.abs());
        let before = self.read("sensed.step_pulses");
        while self.read("sensed.step_pulses") - before != f64::from(pulses) {
            self.run_ms(1);
        }
        // The interpolated field of the last is as late as the last interval was long, and the rotor swings for a while.
        self.run_ms(800);
    }

    /// Turns at so many pulses a second, after a second in which they are reached.
    pub(crate) fn turn(&mut self, frequency_hz: f64) {
        self.set("step_dir.pulses", "endless");
        self.set("step_dir.acceleration_hz_per_s", 16_000);
        self.set("step_dir.frequency_hz", frequency_hz);
        self.run_ms(1000);
    }

    /// RMS of a coil's current in a sine whose amplitude is the length of the currents' vector.
    pub(crate) fn rms_a(&self) -> f64 {
        let physical = self.physical();
        physical.coil_a_a.hypot(physical.coil_b_a) / std::f64::consts::SQRT_2
    }

    /// RMS of the currents in coils A and B over so many control periods.
    pub(crate) fn coils_rms_a(&mut self, ticks: u32) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for _ in 0..ticks {
            self.run_ticks(1);
            let physical = self.physical();
            for (sum, current_a) in sums.iter_mut().zip([physical.coil_a_a, physical.coil_b_a]) {
                *sum += current_a * current_a;
            }
        }
        sums.map(|sum| (sum / f64::from(ticks)).sqrt())
    }
}
