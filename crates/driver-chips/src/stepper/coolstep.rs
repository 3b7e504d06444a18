//! coolStep: less current under light load (decisions §5.6).

/// A stallGuard2 reading's unit in SEMIN and SEMAX.
const THRESHOLD_UNIT: u16 = 32;

/// How the current follows the load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoolStep {
    /// SEMIN, 0 to 15: readings below 32 · SEMIN raise the current. 0 switches coolStep off.
    pub lower_threshold: u8,
    /// SEMAX, 0 to 15: readings from 32 · (SEMIN + SEMAX + 1) on lower the current.
    pub hysteresis: u8,
    /// SEUP, 0 to 3: the current rises by 1, 2, 4 or 8 a reading.
    pub up_step: u8,
    /// SEDN, 0 to 3: the current falls by 1 after 32, 8, 2 or 1 readings.
    pub down_step: u8,
    /// SEIMIN: the current may fall to a quarter of CS, instead of a half.
    pub quarter_minimum: bool,
}

/// The current scale that is in use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Regulator {
    scale: u8,
    /// The CS that [`Self::scale`] belongs to.
    commanded: u8,
    /// Readings above the upper threshold since the current last changed.
    high_readings: u8,
}

impl Regulator {
    pub(crate) fn scale(&self) -> u8 {
        self.scale
    }

    /// Starts at CS whenever CS is another one or coolStep is off, and keeps to the lower bound.
    pub(crate) fn follow(&mut self, commanded: u8, settings: CoolStep) {
        let commanded = commanded.min(31);
        if commanded != self.commanded || settings.lower_threshold == 0 {
            *self = Self { scale: commanded, commanded, high_readings: 0 };
        }
        self.scale = self.scale.max(lower_bound(commanded, settings));
    }

    /// Acts upon a new stallGuard2 reading; [`Self::follow`] came before.
    pub(crate) fn take(&mut self, reading: u16, settings: CoolStep) {
        let [lower, hysteresis] =
            [settings.lower_threshold, settings.hysteresis].map(|field| u16::from(field.min(15)));
        if lower == 0 {
            return;
        }
        if reading < THRESHOLD_UNIT * lower {
            self.scale = (self.scale + (1 << settings.up_step.min(3))).min(self.commanded);
            self.high_readings = 0;
        } else if reading >= THRESHOLD_UNIT * (lower + hysteresis + 1) {
            self.count_high(
                readings_per_decrement(settings.down_step),
                lower_bound(self.commanded, settings),
            );
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
fn lower_bound(commanded: u8, settings: CoolStep) -> u8 {
    commanded >> if settings.quarter_minimum { 2 } else { 1 }
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

    fn regulator(settings: CoolStep) -> Regulator {
        let mut regulator = Regulator::default();
        regulator.follow(31, settings);
        regulator
    }

    fn readings_until(regulator: &mut Regulator, settings: CoolStep, reading: u16, scale: u8) -> u32 {
        for count in 0..2000 {
            if regulator.scale() == scale {
                return count;
            }
            regulator.take(reading, settings);
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
                let settings = settings(0, down_step, quarter_minimum);
                let mut regulator = regulator(settings);
                let count = readings_until(&mut regulator, settings, 128, bound);
                assert_eq!(count, per_decrement * u32::from(31 - bound));
                for _ in 0..300 {
                    regulator.take(1023, settings);
                }
                assert_eq!(regulator.scale(), bound);
            }
        }
    }

    #[test]
    fn low_readings_raise_the_current_to_cs_at_every_up_step() {
        for (up_step, readings) in [(0, 16), (1, 8), (2, 4), (3, 2)] {
            let settings = settings(up_step, 3, false);
            let mut regulator = regulator(settings);
            readings_until(&mut regulator, settings, 128, 15);
            assert_eq!(readings_until(&mut regulator, settings, 63, 31), readings);
            regulator.take(0, settings);
            assert_eq!(regulator.scale(), 31);
        }
    }

    #[test]
    fn readings_between_the_thresholds_change_nothing() {
        let settings = settings(0, 3, false);
        let mut regulator = regulator(settings);
        readings_until(&mut regulator, settings, 128, 20);
        for reading in [64, 100, 127] {
            regulator.take(reading, settings);
            assert_eq!(regulator.scale(), 20);
        }
    }

    #[test]
    fn a_new_cs_or_coolstep_switched_off_starts_at_cs() {
        let mut settings = settings(0, 3, false);
        let mut regulator = regulator(settings);
        readings_until(&mut regulator, settings, 1023, 15);
        regulator.follow(24, settings);
        assert_eq!(regulator.scale(), 24);
        readings_until(&mut regulator, settings, 1023, 12);
        settings.lower_threshold = 0;
        regulator.follow(24, settings);
        regulator.take(1023, settings);
        assert_eq!(regulator.scale(), 24);
    }

    #[test]
    fn a_higher_bound_is_kept_at_once() {
        let mut settings = settings(0, 3, true);
        let mut regulator = regulator(settings);
        readings_until(&mut regulator, settings, 1023, 7);
        settings.quarter_minimum = false;
        regulator.follow(31, settings);
        assert_eq!(regulator.scale(), 15);
    }
}
