//! What the chip watches on each coil: open load and shorts to ground.

use super::pins::{CoilFault, CoilPins};
use super::table::AMPLITUDE;

/// Only a current above 1/16 of the largest can clear the open load flag (datasheet, OLA and OLB).
const OPEN_LOAD_PART: i16 = 16;

/// A current this near to its target has made the comparator switch (decision: the averaged chopper has no ripple).
const CHOPPER_EVENT: f64 = 0.9;

/// The short counter's limit: the bridges are shut off (datasheet, S2GA and S2GB).
const SHORT_LIMIT: u8 = 3;

/// A coil's diagnostics.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CoilMonitor {
    shorts: u8,
    open_load: bool,
    half_wave: HalfWave,
}

/// The time since the commanded current changed its sign.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct HalfWave {
    /// The sign, 0 before the first current.
    polarity: i16,
    /// The target of the period before, if it is large enough to judge by; else 0.
    awaited_a: f64,
    awaited_any: bool,
    chopper_event: bool,
}

impl CoilMonitor {
    /// OLA or OLB.
    pub(crate) fn open_load(&self) -> bool {
        self.open_load
    }

    /// S2GA or S2GB.
    pub(crate) fn shorted(&self) -> bool {
        self.shorts == SHORT_LIMIT
    }

    /// Nothing flows on purpose: the half-wave ends without a verdict.
    pub(crate) fn rest(&mut self) {
        self.half_wave = HalfWave::default();
    }

    /// A bridge meets its coil's short once in a period, and gives up the cycle.
    pub(crate) fn count_short(&mut self, coil: CoilPins, protected: bool) {
        if coil.fault == CoilFault::ShortToGround && protected {
            self.shorts = (self.shorts + 1).min(SHORT_LIMIT);
        }
    }

    /// Compares the current with the target of the period before, and takes the next: `value` of
    /// [`AMPLITUDE`], which is `target_a`.
    pub(crate) fn observe(&mut self, current_a: f64, value: i16, target_a: f64) {
        let wave = &mut self.half_wave;
        if wave.awaited_a != 0.0 {
            wave.awaited_any = true;
            if current_a * wave.awaited_a >= CHOPPER_EVENT * wave.awaited_a * wave.awaited_a {
                wave.chopper_event = true;
                self.open_load = false;
            }
        }
        let polarity = value.signum();
        if polarity != 0 && polarity != self.half_wave.polarity {
            self.change_polarity(polarity);
        }
        self.half_wave.awaited_a = if value.abs() > AMPLITUDE / OPEN_LOAD_PART { target_a } else { 0.0 };
    }

    fn change_polarity(&mut self, polarity: i16) {
        if self.half_wave.awaited_any {
            self.open_load = !self.half_wave.chopper_event;
        }
        self.shorts = self.shorts.saturating_sub(1);
        self.half_wave = HalfWave { polarity, ..HalfWave::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half-waves of alternating sign and 40 periods, the current `part` of its target with one period's delay.
    fn run(monitor: &mut CoilMonitor, half_waves: i16, amplitude: i16, part: f64) {
        let mut current_a = 0.0;
        for period in 0..40 * half_waves {
            let sign = if (period / 40) % 2 == 0 { 1 } else { -1 };
            let target_a = f64::from(sign * amplitude) / 100.0;
            monitor.observe(current_a, sign * amplitude, target_a);
            current_a = part * target_a;
        }
    }

    #[test]
    fn a_half_wave_without_a_chopper_event_is_an_open_load() {
        let mut monitor = CoilMonitor::default();
        run(&mut monitor, 1, 200, 0.0);
        assert!(!monitor.open_load(), "the half-wave is not over");
        run(&mut monitor, 2, 200, 0.0);
        assert!(monitor.open_load());
        run(&mut monitor, 1, 200, 1.0);
        assert!(!monitor.open_load(), "one event clears it");
        run(&mut monitor, 4, 200, 1.0);
        assert!(!monitor.open_load());
    }

    #[test]
    fn a_small_current_neither_sets_nor_clears_open_load() {
        let mut monitor = CoilMonitor::default();
        run(&mut monitor, 4, 15, 0.0);
        assert!(!monitor.open_load());
        run(&mut monitor, 4, 200, 0.0);
        run(&mut monitor, 4, 15, 1.0);
        assert!(monitor.open_load());
    }

    #[test]
    fn three_shorts_shut_off_and_a_change_of_polarity_takes_one_back() {
        let short = CoilPins { current_a: 0.0, back_emf_v: 0.0, fault: CoilFault::ShortToGround };
        let mut monitor = CoilMonitor::default();
        for (shorts, value) in [(2, 100), (1, -100), (1, -100)] {
            assert!(!monitor.shorted());
            monitor.observe(0.0, value, 0.0);
            for _ in 0..shorts {
                monitor.count_short(short, true);
            }
            monitor.count_short(short, false);
        }
        assert!(monitor.shorted(), "2, less one, and two more");
    }
}
