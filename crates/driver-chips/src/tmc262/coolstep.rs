//! coolStep: less current under light load (decisions §5.6).

use super::Registers;

/// A stallGuard2 reading's unit in SEMIN and SEMAX.
const THRESHOLD_UNIT: u16 = 32;

/// The current scale that is in use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Regulator {
    scale: u8,
    /// The CS that [`Self::scale`] belongs to.
    commanded: u8,
    /// Readings above the upper threshold since the current last changed.
    high_readings: u8,
}

impl Regulator {
    pub(super) fn scale(&self) -> u8 {
        self.scale
    }

    /// Starts at CS whenever CS is another one or coolStep is off, and keeps to the lower bound.
    pub(super) fn follow(&mut self, registers: &Registers) {
        let commanded = registers.current_scale.min(31);
        if commanded != self.commanded || registers.coolstep.lower_threshold == 0 {
            *self = Self { scale: commanded, commanded, high_readings: 0 };
        }
        self.scale = self.scale.max(lower_bound(registers));
    }

    /// Acts upon a new stallGuard2 reading; [`Self::follow`] came before.
    pub(super) fn take(&mut self, reading: u16, registers: &Registers) {
        let settings = registers.coolstep;
        let [lower, hysteresis] =
            [settings.lower_threshold, settings.hysteresis].map(|field| u16::from(field.min(15)));
        if lower == 0 {
            return;
        }
        if reading < THRESHOLD_UNIT * lower {
            self.scale = (self.scale + (1 << settings.up_step.min(3))).min(self.commanded);
            self.high_readings = 0;
        } else if reading >= THRESHOLD_UNIT * (lower + hysteresis + 1) {
            self.count_high(readings_per_decrement(settings.down_step), lower_bound(registers));
        }
    }

    fn count_high(&mut self, needed: u8, lower_bound: u8) {
        // Counting goes on at the bound without an effect, and must come to rest there.
        self.high_readings = (self.high_readings + 1).min(needed);
        if self.high_readings == needed && self.scale > lower_bound {
            self.scale -= 1;
            self.high_readings = 0;
        }
    }
}

/// SEIMIN: CS/2 or CS/4.
fn lower_bound(registers: &Registers) -> u8 {
    registers.current_scale.min(31) >> if registers.coolstep.quarter_minimum { 2 } else { 1 }
}

/// SEDN.
fn readings_per_decrement(down_step: u8) -> u8 {
    match down_step {
        0 => 32,
        1 => 8,
        2 => 2,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tmc262::CoolStep;

    fn registers(coolstep: CoolStep) -> Registers {
        Registers { current_scale: 31, coolstep, ..Registers::default() }
    }

    fn regulator(registers: &Registers) -> Regulator {
        let mut regulator = Regulator::default();
        regulator.follow(registers);
        regulator
    }

    fn readings_until(regulator: &mut Regulator, registers: &Registers, reading: u16, scale: u8) -> u32 {
        for count in 0..2000 {
            if regulator.scale() == scale {
                return count;
            }
            regulator.take(reading, registers);
        }
        panic!("scale {scale} never reached, but {}", regulator.scale());
    }

    /// With SEMIN = 2 and SEMAX = 1 the band is 64 to 127.
    fn settings(up_step: u8, down_step: u8, quarter_minimum: bool) -> CoolStep {
        CoolStep { lower_threshold: 2, hysteresis: 1, up_step, down_step, quarter_minimum }
    }

    #[test]
    fn high_readings_lower_the_current_to_the_bound_at_every_down_step() {
        for (down_step, per_decrement) in [(0, 32), (1, 8), (2, 2), (3, 1)] {
            for (quarter_minimum, bound) in [(false, 15), (true, 7)] {
                let registers = registers(settings(0, down_step, quarter_minimum));
                let mut regulator = regulator(&registers);
                let count = readings_until(&mut regulator, &registers, 128, bound);
                assert_eq!(count, per_decrement * u32::from(31 - bound));
                for _ in 0..300 {
                    regulator.take(1023, &registers);
                }
                assert_eq!(regulator.scale(), bound);
            }
        }
    }

    #[test]
    fn low_readings_raise_the_current_to_cs_at_every_up_step() {
        for (up_step, readings) in [(0, 16), (1, 8), (2, 4), (3, 2)] {
            let registers = registers(settings(up_step, 3, false));
            let mut regulator = regulator(&registers);
            readings_until(&mut regulator, &registers, 128, 15);
            assert_eq!(readings_until(&mut regulator, &registers, 63, 31), readings);
            regulator.take(0, &registers);
            assert_eq!(regulator.scale(), 31);
        }
    }

    #[test]
    fn readings_between_the_thresholds_change_nothing() {
        let registers = registers(settings(0, 3, false));
        let mut regulator = regulator(&registers);
        readings_until(&mut regulator, &registers, 128, 20);
        for reading in [64, 100, 127] {
            regulator.take(reading, &registers);
            assert_eq!(regulator.scale(), 20);
        }
    }

    #[test]
    fn a_new_cs_or_coolstep_switched_off_starts_at_cs() {
        let mut registers = registers(settings(0, 3, false));
        let mut regulator = regulator(&registers);
        readings_until(&mut regulator, &registers, 1023, 15);
        registers.current_scale = 24;
        regulator.follow(&registers);
        assert_eq!(regulator.scale(), 24);
        readings_until(&mut regulator, &registers, 1023, 12);
        registers.coolstep.lower_threshold = 0;
        regulator.follow(&registers);
        regulator.take(1023, &registers);
        assert_eq!(regulator.scale(), 24);
    }

    #[test]
    fn a_higher_bound_is_kept_at_once() {
        let mut registers = registers(settings(0, 3, true));
        let mut regulator = regulator(&registers);
        readings_until(&mut regulator, &registers, 1023, 7);
        registers.coolstep.quarter_minimum = false;
        regulator.follow(&registers);
        assert_eq!(regulator.scale(), 15);
    }
}
