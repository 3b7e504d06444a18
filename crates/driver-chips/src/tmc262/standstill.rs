//! STST: nothing was commanded for 2^20 clocks.

/// The chip's clock.
const CLOCK_HZ: f64 = 16e6;

/// 65.536 ms.
const STANDSTILL_CLOCKS: u32 = 1 << 20;

/// Clocks since the commanded vector changed, up to those of a standstill.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Standstill {
    clocks: u32,
}

impl Standstill {
    pub(super) fn advance(&mut self, changed: bool, period_s: f64) {
        let clocks = (period_s * CLOCK_HZ + 0.5) as u32;
        self.clocks = if changed { 0 } else { self.clocks.saturating_add(clocks).min(STANDSTILL_CLOCKS) };
    }

    pub(super) fn reached(self) -> bool {
        self.clocks == STANDSTILL_CLOCKS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_said_after_65_536_milliseconds_without_a_change() {
        let mut standstill = Standstill::default();
        for _ in 0..1310 {
            standstill.advance(false, 50e-6);
        }
        assert!(!standstill.reached(), "65.500 ms");
        standstill.advance(false, 50e-6);
        assert!(standstill.reached(), "65.550 ms");
        standstill.advance(true, 50e-6);
        assert!(!standstill.reached());
    }
}
