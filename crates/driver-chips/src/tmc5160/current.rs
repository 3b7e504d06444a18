//! IRUN in motion, IHOLD at standstill, and the way down between them.

use super::Registers;

/// The unit of TPOWERDOWN and IHOLDDELAY.
const DELAY_SHIFT: u32 = 18;

/// Which of the two currents it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    /// IRUN: there are steps, or the last one is not long enough ago.
    Running {
        /// Clocks since standstill was detected.
        stood: u32,
    },
    /// On the way to IHOLD, a step of the scale at a time.
    PoweringDown {
        /// Clocks since the last step.
        since_step: u32,
    },
    /// IHOLD. So it is after power-on (decision).
    #[default]
    Holding,
}

/// The current scale before coolStep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct RunOrHold {
    phase: Phase,
    scale: u8,
}

impl RunOrHold {
    /// 0 to 31.
    pub(super) fn scale(self) -> u8 {
        self.scale
    }

    /// Whether it is IRUN.
    pub(super) fn runs(self) -> bool {
        matches!(self.phase, Phase::Running { .. })
    }

    /// A control period of so many clocks at the end of which the motor stands or does not.
    pub(super) fn advance(&mut self, stands: bool, registers: &Registers, clocks: u32) {
        let settings = registers.ihold_irun;
        let [run, hold] = [settings.irun, settings.ihold].map(|scale| scale.min(31));
        if !stands {
            *self = Self { phase: Phase::Running { stood: 0 }, scale: run };
            return;
        }
        match &mut self.phase {
            Phase::Running { stood } => {
                self.scale = run;
                *stood += clocks;
                if *stood >= u32::from(registers.tpowerdown) << DELAY_SHIFT {
                    self.phase = Phase::PoweringDown { since_step: 0 };
                }
            }
            Phase::PoweringDown { since_step } => {
                let delay = u32::from(settings.iholddelay.min(15)) << DELAY_SHIFT;
                *since_step += clocks;
                if delay == 0 {
                    self.scale = hold;
                } else if *since_step >= delay {
                    *since_step -= delay;
                    self.scale = if self.scale > hold { self.scale - 1 } else { (self.scale + 1).min(hold) };
                }
            }
            Phase::Holding => self.scale = hold,
        }
        if matches!(self.phase, Phase::PoweringDown { .. }) && self.scale == hold {
            self.phase = Phase::Holding;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tmc5160::IHoldIRun;

    fn registers(iholddelay: u8, tpowerdown: u8) -> Registers {
        let ihold_irun = IHoldIRun { ihold: 3, irun: 24, iholddelay };
        Registers { ihold_irun, tpowerdown, ..Registers::default() }
    }

    /// Multiples of 2^18 clocks at standstill until the scale is first this, counted to 1/64.
    fn delays_until(current: &mut RunOrHold, registers: &Registers, scale: u8) -> f64 {
        let mut count = 0;
        while current.scale() != scale {
            current.advance(true, registers, 1 << 12);
            count += 1;
            assert!(count < 64 * 1000, "never");
        }
        f64::from(count) / 64.0
    }

    #[test]
    fn after_tpowerdown_the_current_falls_by_one_each_iholddelay() {
        for (iholddelay, tpowerdown, expected) in [(1, 10, 31.0), (15, 10, 10.0 + 15.0 * 21.0), (2, 0, 42.0)]
        {
            let (mut current, registers) = (RunOrHold::default(), registers(iholddelay, tpowerdown));
            current.advance(false, &registers, 600);
            assert_eq!(current.scale(), 24);
            let delays = delays_until(&mut current, &registers, 3);
            assert!((delays - expected).abs() <= 1.0 / 32.0, "{delays} with {iholddelay}, {tpowerdown}");
            assert_eq!(current.phase, Phase::Holding);
        }
    }

    #[test]
    fn without_a_delay_the_current_falls_at_once() {
        let (mut current, registers) = (RunOrHold::default(), registers(0, 10));
        current.advance(false, &registers, 600);
        assert!((delays_until(&mut current, &registers, 3) - 10.0).abs() <= 1.0 / 32.0);
    }

    #[test]
    fn a_step_brings_irun_back_at_once_and_power_on_begins_with_ihold() {
        let (mut current, registers) = (RunOrHold::default(), registers(15, 255));
        current.advance(true, &registers, 600);
        assert_eq!((current.scale(), current.runs()), (3, false));
        current.advance(false, &registers, 600);
        assert_eq!((current.scale(), current.runs()), (24, true));
    }

    #[test]
    fn a_higher_hold_current_is_approached_from_below() {
        let (mut current, mut registers) = (RunOrHold::default(), registers(1, 0));
        registers.ihold_irun.ihold = 31;
        current.advance(false, &registers, 600);
        assert!((delays_until(&mut current, &registers, 31) - 7.0).abs() <= 1.0 / 32.0);
    }
}
