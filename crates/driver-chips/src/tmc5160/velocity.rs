//! The velocity thresholds: which chopper and which current control a speed gets.
//!
//! A threshold is a TSTEP: the larger, the slower. Slower again it switches at exactly the value set, faster at a velocity
//! that is 1/16 higher (datasheet, TSTEP: the second compare value is TSTEP · 15/16 − 1; with `small_hysteresis` 31/32).

use super::Registers;

/// Whether the motor is faster than a threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Threshold {
    faster: bool,
}

impl Threshold {
    /// Faster ends where TSTEP is `slower_from` or more.
    fn compare(&mut self, tstep: u32, slower_from: u32, hysteresis_shift: u32) {
        let faster_below = (slower_from - (slower_from >> hysteresis_shift)).saturating_sub(1);
        if tstep >= slower_from {
            self.faster = false;
        } else if tstep < faster_below {
            self.faster = true;
        }
    }
}

/// All three comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Velocity {
    pwm: Threshold,
    cool: Threshold,
    high: Threshold,
}

impl Velocity {
    pub(super) fn compare(&mut self, tstep: u32, registers: &Registers) {
        let shift = if registers.gconf.small_hysteresis { 5 } else { 4 };
        self.pwm.compare(tstep, registers.tpwmthrs, shift);
        // These two hold at the very value, too; 0 is never.
        for (threshold, value) in [(&mut self.cool, registers.tcoolthrs), (&mut self.high, registers.thigh)] {
            threshold.compare(tstep, if value == 0 { 0 } else { value.saturating_add(1) }, shift);
        }
    }

    /// Slow enough for stealthChop.
    pub(super) fn stealthchop(self) -> bool {
        !self.pwm.faster && !self.cool.faster && !self.high.faster
    }

    /// Fast enough for stallGuard2.
    pub(super) fn stallguard(self) -> bool {
        self.cool.faster
    }

    /// In the window of coolStep.
    pub(super) fn coolstep(self) -> bool {
        self.cool.faster && !self.high.faster
    }

    /// THIGH.
    pub(super) fn high(self) -> bool {
        self.high.faster
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The TSTEPs at which a quality changes, as the motor gets faster and slower again.
    fn switches(registers: &Registers, quality: fn(Velocity) -> bool) -> [Option<u32>; 2] {
        let mut velocity = Velocity::default();
        velocity.compare(1_048_575, registers);
        let mut changes = |tstep: u32| {
            let before = quality(velocity);
            velocity.compare(tstep, registers);
            quality(velocity) != before
        };
        let faster = (0..2000).rev().find(|&tstep| changes(tstep));
        [faster, (0..2000).find(|&tstep| changes(tstep))]
    }

    #[test]
    fn stealthchop_ends_at_a_velocity_a_sixteenth_higher_than_where_it_begins() {
        let registers = Registers { tpwmthrs: 480, ..Registers::default() };
        assert_eq!(
            switches(&registers, Velocity::stealthchop),
            [Some(448), Some(480)],
            "480 · 15/16 − 1 = 449"
        );
        let mut registers = registers;
        registers.gconf.small_hysteresis = true;
        assert_eq!(
            switches(&registers, Velocity::stealthchop),
            [Some(463), Some(480)],
            "480 · 31/32 − 1 = 464"
        );
    }

    #[test]
    fn no_threshold_is_stealthchop_at_all_velocities_and_coolstep_at_none() {
        let registers = Registers::default();
        for quality in [Velocity::stealthchop, Velocity::coolstep, Velocity::stallguard, Velocity::high] {
            assert_eq!(switches(&registers, quality), [None, None]);
        }
    }

    #[test]
    fn coolstep_has_a_window_in_which_there_is_no_stealthchop() {
        let registers = Registers { tcoolthrs: 480, thigh: 64, ..Registers::default() };
        assert_eq!(switches(&registers, Velocity::stallguard), [Some(449), Some(481)]);
        assert_eq!(switches(&registers, Velocity::stealthchop), [Some(449), Some(481)]);
        assert_eq!(switches(&registers, Velocity::high), [Some(59), Some(65)]);
        let mut velocity = Velocity::default();
        for (tstep, coolstep) in
            [(900, false), (460, false), (400, true), (60, true), (58, false), (64, false), (65, true)]
        {
            velocity.compare(tstep, &registers);
            assert_eq!(velocity.coolstep(), coolstep, "at {tstep}");
        }
    }
}
