//! How fast pulses come: counts between control periods in which some came, over the time between them.
//!
//! Knows pulses and control periods, and never what they do.

use crate::{TICKS_PER_MS, TICKS_PER_SECOND};

/// For how long pulses are counted before a rate is made of them: at 51 200 pulses a second 0.2 % are one pulse (chosen).
const GATE_TICKS: u32 = 10 * TICKS_PER_MS as u32;

/// After so long without a pulse the rate is 0: slower than ten a second is none (chosen).
const SILENCE_TICKS: u32 = 100 * TICKS_PER_MS as u32;

/// A rate meter for pulses of either sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PulseMeter {
    run: Option<Run>,
}

/// Pulses that follow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Run {
    rate_pps: i32,
    /// Since the gate opened, which it did with a pulse that does not count.
    pulses: i32,
    gate_ticks: u32,
    /// Since the last pulse.
    silent_ticks: u32,
}

impl PulseMeter {
    /// Another control period, with so many pulses.
    pub(super) fn tick(&mut self, pulses: i32) {
        self.run = match self.run {
            None => (pulses != 0).then(Run::default),
            Some(run) => run.after(pulses),
        };
    }

    /// Whether a pulse came in the last 100 ms.
    pub(super) fn is_running(&self) -> bool {
        self.run.is_some()
    }

    /// Pulses a second, signed: the last measurement, or less where pulses that fast would have come by now.
    pub(super) fn rate_pps(&self) -> i32 {
        self.run.map_or(0, |run| {
            let limit_pps = (TICKS_PER_SECOND as u32).checked_div(run.silent_ticks);
            let limit_pps = limit_pps.and_then(|limit| i32::try_from(limit).ok()).unwrap_or(i32::MAX);
            run.rate_pps.clamp(-limit_pps, limit_pps)
        })
    }
}

impl Run {
    fn after(self, pulses: i32) -> Option<Self> {
        let gate_ticks = self.gate_ticks.saturating_add(1);
        if pulses == 0 {
            let silent_ticks = self.silent_ticks + 1;
            return (silent_ticks < SILENCE_TICKS).then_some(Self { gate_ticks, silent_ticks, ..self });
        }
        let pulses = self.pulses.saturating_add(pulses);
        if gate_ticks < GATE_TICKS {
            return Some(Self { pulses, gate_ticks, silent_ticks: 0, ..self });
        }
        let rate_pps = i64::from(pulses) * TICKS_PER_SECOND.cast_signed() / i64::from(gate_ticks);
        let rate_pps = i32::try_from(rate_pps).unwrap_or(i32::MAX * pulses.signum());
        Some(Self { rate_pps, ..Self::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A meter after so many control periods at a pulse rate, which a sum of whole numbers keeps.
    fn after(meter: &mut PulseMeter, rate_pps: i32, ticks: u32) {
        let mut phase = 0;
        for _ in 0..ticks {
            phase += rate_pps;
            let pulses = phase / 20_000;
            phase -= pulses * 20_000;
            meter.tick(pulses);
        }
    }

    #[test]
    fn reads_what_comes_to_a_pulse_in_the_gate() {
        for rate_pps in [20, 100, 999, 1000, 15_000, 19_999, 20_000, 51_200, 1_000_000] {
            for sign in [1, -1] {
                let mut meter = PulseMeter::default();
                after(&mut meter, sign * rate_pps, 20_000);
                let error = (meter.rate_pps() - sign * rate_pps).abs();
                assert!(error <= 100 + rate_pps / 200, "{rate_pps}: {}", meter.rate_pps());
            }
        }
    }

    #[test]
    fn falls_with_the_silence_and_ends_after_100_ms() {
        let mut meter = PulseMeter::default();
        after(&mut meter, 10_000, 2000);
        let running = meter.rate_pps();
        assert!((running - 10_000).abs() < 100, "{running}");
        after(&mut meter, 0, 20);
        assert!(meter.rate_pps() <= 1000, "{}", meter.rate_pps());
        after(&mut meter, 0, 2000 - 21);
        assert!(meter.is_running() && meter.rate_pps() == 10, "{meter:?}");
        after(&mut meter, 0, 1);
        assert!(!meter.is_running());
        assert_eq!((meter, meter.rate_pps()), (PulseMeter::default(), 0));
    }

    #[test]
    fn one_pulse_has_no_rate() {
        let mut meter = PulseMeter::default();
        assert!(!meter.is_running());
        meter.tick(1);
        assert!(meter.is_running());
        assert_eq!(meter.rate_pps(), 0);
    }
}
