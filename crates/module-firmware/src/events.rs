//! What interrupts a program: timers, edges, and stops of the motor (TMCM-1311 §5.6.3, §10.4).
//!
//! Timers count from the write of their period, whatever the program does. Levels are compared only while a program has
//! their interrupts enabled; enabling one takes the level as it is, so that only a later change counts.

use tmcl_tables::{GlobalParameter, Interrupt};
use tmcl_vm::ErrorFlag;

use crate::TICKS_PER_MS;
use crate::axis::Axis;
use crate::firmware::Firmware;
use crate::jobs::Job;
use crate::storage::RecordKey;

/// The bank that configures interrupts.
const INTERRUPT_BANK: u8 = 3;

/// What happened to the motor in a control period besides what its parameters show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events {
    /// It was stopped because it stalled.
    pub stall_stop: bool,
    /// It was stopped because the encoder deviates.
    pub deviation_stop: bool,
    /// Its driver began to report an error.
    pub alarm: bool,
    /// This axis parameter is to be stored.
    pub store: Option<u8>,
}

/// A timer interrupt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Timer {
    /// 0 while it is off.
    period_ticks: u64,
    next_tick: u64,
}

impl Timer {
    /// A timer whose period, the 32 unsigned bits of a value in milliseconds, begins now.
    fn starting(period_ms: i32, now: u64) -> Self {
        let period_ticks = u64::from(period_ms.cast_unsigned()) * TICKS_PER_MS;
        Self { period_ticks, next_tick: now.saturating_add(period_ticks) }
    }

    /// Whether a period ended, at `now` or since it was last asked.
    fn expires(&mut self, now: u64) -> bool {
        let expires = self.period_ticks != 0 && now >= self.next_tick;
        if expires {
            let periods = (now - self.next_tick) / self.period_ticks + 1;
            self.next_tick = self.next_tick.saturating_add(periods.saturating_mul(self.period_ticks));
        }
        expires
    }
}

/// What the interrupts' sources were like when they were last looked at.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sources {
    timers: [Timer; 3],
    /// A bit for each interrupt with a level.
    levels: u64,
    /// The interrupts whose bit in `levels` counts.
    known: u64,
}

impl Sources {
    const TIMERS: [Interrupt; 3] = [Interrupt::Timer0, Interrupt::Timer1, Interrupt::Timer2];

    /// A period was written.
    pub(crate) fn set_timer(&mut self, timer: usize, period_ms: i32, now: u64) {
        if let Some(slot) = self.timers.get_mut(timer) {
            *slot = Timer::starting(period_ms, now);
        }
    }

    /// When the next of the enabled timers expires.
    pub(crate) fn next_timer_tick(&self, enabled: u64) -> u64 {
        let timers = Self::TIMERS.iter().zip(&self.timers);
        let running =
            timers.filter(|(interrupt, timer)| enabled & bit(**interrupt) != 0 && timer.period_ticks != 0);
        running.map(|(_, timer)| timer.next_tick).min().unwrap_or(u64::MAX)
    }
}

impl<A: Axis> Firmware<A> {
    /// Raises the timers that expired.
    pub(crate) fn notice_timers(&mut self) {
        let now = self.ticks;
        for (interrupt, timer) in Sources::TIMERS.iter().zip(&mut self.sources.timers) {
            if timer.expires(now) {
                self.vm.raise(interrupt.number());
            }
        }
    }

    /// Control periods have passed in which no enabled timer expired: the others go on with their beat.
    pub(crate) fn pass_timers(&mut self) {
        if let Some(last) = self.ticks.checked_sub(1).filter(|_| self.vm.is_active()) {
            for timer in &mut self.sources.timers {
                timer.expires(last);
            }
        }
    }

    /// Raises the enabled interrupts whose level changed the way they are set to.
    pub(crate) fn notice_edges(&mut self) {
        let enabled = self.vm.enabled_interrupts();
        if enabled == 0 {
            self.sources.known = 0;
            return;
        }
        let levels = self.levels(enabled);
        let mut changed = (levels ^ self.sources.levels) & self.sources.known;
        self.sources.levels = levels;
        self.sources.known = enabled;
        while changed != 0 {
            let number = u8::try_from(changed.trailing_zeros()).unwrap_or(0);
            if self.counts(number, (levels >> number) & 1 != 0) {
                self.vm.raise(number);
            }
            changed &= changed - 1;
        }
    }

    /// Whether a level changed since [`Firmware::notice_edges`].
    pub(crate) fn has_unnoticed_edge(&self) -> bool {
        let known = self.vm.enabled_interrupts() & self.sources.known;
        known != 0 && (self.levels(known) ^ self.sources.levels) & known != 0
    }

    /// The levels of some interrupts, a bit each.
    fn levels(&self, mut interrupts: u64) -> u64 {
        let mut levels = 0;
        while interrupts != 0 {
            let number = interrupts.trailing_zeros();
            let interrupt = u8::try_from(number).ok().and_then(|number| Interrupt::try_from(number).ok());
            levels |= u64::from(interrupt.is_some_and(|interrupt| self.axis.level(interrupt))) << number;
            interrupts &= interrupts - 1;
        }
        levels
    }

    /// Whether this edge is one that the interrupt is for: what bank 3 says, and where it says nothing, the rising one.
    fn counts(&self, number: u8, rising: bool) -> bool {
        match GlobalParameter::from_address(INTERRUPT_BANK, number) {
            None => rising,
            Some(edge) => self.globals.setting(edge) & if rising { 1 } else { 2 } != 0,
        }
    }

    /// What the axis reported of its control period.
    pub(crate) fn take_note(&mut self, events: Events) {
        if events.stall_stop {
            self.vm.set_error(ErrorFlag::Shutdown);
            self.vm.raise(Interrupt::Stallguard2.number());
        }
        if events.deviation_stop {
            self.vm.set_error(ErrorFlag::Deviation);
            self.vm.raise(Interrupt::Deviation.number());
        }
        if events.alarm {
            self.vm.set_error(ErrorFlag::ExternalAlarm);
        }
        if let Some(number) = events.store
            && let Ok(parameter) = A::Parameter::try_from(number)
        {
            self.upkeep = Some(Job::Write(RecordKey::Axis(number), self.axis.get(parameter)));
        }
    }
}

fn bit(interrupt: Interrupt) -> u64 {
    1 << interrupt.number()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timer_keeps_its_beat_from_the_write_on() {
        let mut timer = Timer::starting(1, 7);
        assert!(!timer.expires(26) && timer.expires(27) && !timer.expires(27));
        assert!(timer.expires(90), "nobody asked at 47, 67 and 87");
        assert!(!timer.expires(106) && timer.expires(107));
        assert!(!Timer::starting(0, 7).expires(u64::MAX));
    }

    #[test]
    fn a_period_is_unsigned() {
        let mut timer = Timer::starting(-1, 0);
        assert!(!timer.expires(4_294_967_295 * 20 - 1) && timer.expires(4_294_967_295 * 20));
    }
}
