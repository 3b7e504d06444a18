//! Interrupts: which are enabled, where their routines are, which wait for their turn (TMCM-1311 §5.6).
//!
//! The lower the number, the higher the priority. There is no nesting. Each interrupt is remembered once until it is served.

use crate::registers::Registers;
use crate::wait::Wait;

/// Numbers of interrupts are 0 to 63; the modules' highest is 46.
const NUMBERS: usize = 64;

/// The number that stands for all interrupts in EI and DI.
pub(crate) const ALL: u8 = 255;

/// What an interrupt routine must leave as it was: saved at its beginning, restored by RETI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Context {
    pub(crate) address: u16,
    pub(crate) registers: Registers,
    /// What is left of the WAIT that was interrupted; its deadline is the time that was left.
    pub(crate) wait: Option<Wait>,
}

/// The interrupts' state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Interrupts {
    global: bool,
    enabled: u64,
    pending: u64,
    has_vector: u64,
    vectors: [u16; NUMBERS],
    /// The interrupted program, while a routine runs.
    pub(crate) context: Option<Context>,
}

impl Default for Interrupts {
    fn default() -> Self {
        Self { global: false, enabled: 0, pending: 0, has_vector: 0, vectors: [0; NUMBERS], context: None }
    }
}

impl Interrupts {
    /// VECT.
    pub(crate) fn set_vector(&mut self, number: u8, address: u16) {
        if let Some(vector) = self.vectors.get_mut(usize::from(number)) {
            *vector = address;
            self.has_vector |= bit(number);
        }
    }

    /// EI and DI. What is disabled is no longer pending.
    pub(crate) fn enable(&mut self, number: u8, on: bool) {
        match (number, on) {
            (ALL, _) => self.global = on,
            (_, true) => self.enabled |= bit(number),
            (_, false) => {
                self.enabled &= !bit(number);
                self.pending &= !bit(number);
            }
        }
    }

    /// The event of an interrupt happened: it is remembered if the interrupt is enabled, be it globally or not.
    pub(crate) fn raise(&mut self, number: u8) {
        self.pending |= bit(number) & self.enabled;
    }

    /// The enabled interrupts, a bit each.
    pub(crate) fn enabled(&self) -> u64 {
        self.enabled
    }

    /// Whether a routine is to begin now.
    pub(crate) fn is_due(&self) -> bool {
        self.global && self.context.is_none() && self.pending & self.has_vector != 0
    }

    /// The first address of the most urgent routine. Interrupts without a vector are forgotten.
    pub(crate) fn take_due(&mut self) -> Option<u16> {
        if self.pending == 0 || !self.global || self.context.is_some() {
            return None;
        }
        self.pending &= self.has_vector;
        let number = self.pending.trailing_zeros();
        let vector = *self.vectors.get(usize::try_from(number).ok()?)?;
        self.pending &= self.pending.wrapping_sub(1);
        Some(vector)
    }
}

fn bit(number: u8) -> u64 {
    1_u64.checked_shl(u32::from(number)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn enabled(numbers: &[u8]) -> Interrupts {
        let mut interrupts = Interrupts::default();
        for &number in numbers {
            interrupts.set_vector(number, 100 + u16::from(number));
            interrupts.enable(number, true);
        }
        interrupts.enable(ALL, true);
        interrupts
    }

    #[test]
    fn the_lowest_number_goes_first_and_each_is_remembered_once() {
        let mut interrupts = enabled(&[3, 46, 0]);
        for number in [46, 3, 3, 0] {
            interrupts.raise(number);
        }
        let served = [(); 4].map(|()| interrupts.take_due());
        assert_eq!(served, [Some(100), Some(103), Some(146), None]);
    }

    #[test]
    fn what_is_not_enabled_is_not_remembered_but_what_waits_for_ei_255_is() {
        let mut interrupts = enabled(&[3]);
        interrupts.raise(0);
        interrupts.enable(0, true);
        interrupts.set_vector(0, 7);
        assert_eq!(interrupts.take_due(), None);
        interrupts.enable(ALL, false);
        interrupts.raise(3);
        assert_eq!(interrupts.take_due(), None);
        interrupts.enable(ALL, true);
        assert_eq!(interrupts.take_due(), Some(103));
        interrupts.raise(3);
        interrupts.enable(3, false);
        interrupts.enable(3, true);
        assert_eq!(interrupts.take_due(), None, "DI forgets");
    }

    #[test]
    fn an_interrupt_without_a_vector_is_ignored() {
        let mut interrupts = enabled(&[3]);
        interrupts.enable(1, true);
        interrupts.raise(1);
        assert!(!interrupts.is_due());
        assert_eq!(interrupts.take_due(), None);
        interrupts.set_vector(1, 5);
        assert_eq!(interrupts.take_due(), None, "it is not kept until there is one");
    }
}
