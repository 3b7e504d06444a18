//! STST: nothing was commanded for 2^20 clocks.

/// Clocks without a change that make a standstill.
pub(crate) const STANDSTILL_CLOCKS: u32 = 1 << 20;

/// Clocks since the commanded vector changed, up to those of a standstill.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Standstill {
    clocks: u32,
}

impl Standstill {
    pub(crate) fn advance(&mut self, changed: bool, clocks: u32) {
        self.clocks = if changed { 0 } else { self.clocks.saturating_add(clocks).min(STANDSTILL_CLOCKS) };
    }

    pub(crate) fn reached(self) -> bool {
        self.clocks == STANDSTILL_CLOCKS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_16_mhz_it_is_said_after_65_536_milliseconds_without_a_change() {
        let mut standstill = Standstill::default();
        for _ in 0..1310 {
            standstill.advance(false, 800);
        }
        assert!(!standstill.reached(), "65.500 ms");
        standstill.advance(false, 800);
        assert!(standstill.reached(), "65.550 ms");
        standstill.advance(true, 800);
        assert!(!standstill.reached());
    }
}
