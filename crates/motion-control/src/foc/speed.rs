//! How fast the shaft turns, in rpm (a decision for the TMCM-1640: counts over the time between edges within 4 ms).
//!
//! Hall sensors are measured like an encoder, though a motor's sectors are not exactly equal. To average over a whole
//! electrical turn would hide that, but below 4000 rpm of a motor with 8 poles a turn takes longer than the 4 ms, and the
//! velocity regulator cannot stand the delay with the gains that suit it above.
//!
//! This module must never know which of the two sensors commutates.

use crate::TICKS_PER_SECOND;
use crate::tachometer::{CountRate, Tachometer};

/// Of an encoder: it looks back 4 ms, and 100 ms without an edge are standstill.
pub type EncoderTachometer = Tachometer<16, 2000>;

/// Of [hall sensors](super::hall): it looks back 4 ms, and 500 ms without an edge are standstill.
pub type HallTachometer = Tachometer<16, 10_000>;

/// A rate as a velocity, to the nearest rpm, half of one away from 0. It saturates. A shaft without counts in a turn stands.
#[must_use]
pub fn rpm(rate: CountRate, counts_per_turn: u32) -> i32 {
    const TICKS_PER_MINUTE: u64 = TICKS_PER_SECOND.unsigned_abs() * 60;
    let divisor = u64::from(rate.ticks) * u64::from(counts_per_turn);
    let dividend = u64::from(rate.counts.unsigned_abs()) * TICKS_PER_MINUTE;
    let magnitude = (dividend + divisor / 2).checked_div(divisor).unwrap_or(0);
    i32::try_from(magnitude).unwrap_or(i32::MAX) * rate.counts.signum()
}

#[cfg(test)]
#[expect(clippy::float_arithmetic, reason = "the truth to check against")]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The counter of a shaft that turns at `speed_rpm`, at control period `tick`.
    fn count(speed_rpm: f64, counts_per_turn: f64, tick: u32) -> i32 {
        libm::floor(speed_rpm * counts_per_turn * f64::from(tick) / 1_200_000.0 + 0.3) as i32
    }

    #[test]
    fn a_count_rate_is_rounded_to_the_nearest_rpm() {
        let rate = |counts, ticks| CountRate { counts, ticks };
        assert_eq!(rpm(rate(4096, 400), 4096), 3000);
        assert_eq!(rpm(rate(-1, 1000), 24), -50);
        assert_eq!([rpm(rate(1, 799_999), 1), rpm(rate(1, 800_000), 1), rpm(rate(1, 800_001), 1)], [2, 2, 1]);
        assert_eq!(rpm(rate(-1, 800_000), 1), -2);
        assert_eq!(rpm(CountRate::STANDING, 4096), 0);
        assert_eq!(rpm(rate(5, 5), 0), 0);
    }

    #[test]
    fn a_stop_is_seen_at_once_and_over_after_its_time() {
        fn ticks_to_rest<const STANDSTILL: u32>() -> u32 {
            let mut tachometer = Tachometer::<16, STANDSTILL>::new(0);
            (0..200).for_each(|tick| tachometer.tick(tick));
            let mut ticks = 0;
            while !tachometer.is_at_rest() {
                tachometer.tick(199);
                ticks += 1;
                assert!(rpm(tachometer.rate(), 4096) <= 2 * 1_200_000 / 4096 / ticks as i32 + 1);
            }
            ticks
        }
        assert_eq!((ticks_to_rest::<2000>(), ticks_to_rest::<10_000>()), (2000, 10_000));
    }

    proptest! {
        /// 5 ms after a step the new speed is read, but for the 50 µs by which an edge is uncertain.
        #[test]
        fn an_encoder_reads_true_within_4_ms(speed in 60.0_f64..4000.0, before in -4000.0..4000.0) {
            let mut tachometer = EncoderTachometer::new(0);
            (1..200).for_each(|tick| tachometer.tick(count(before, 4096.0, tick)));
            let start = count(before, 4096.0, 199);
            for tick in 1..400 {
                tachometer.tick(start + count(speed, 4096.0, tick));
                let error = (f64::from(rpm(tachometer.rate(), 4096)) - speed).abs();
                prop_assert!(tick <= 100 || error <= speed * 0.02 + 0.6, "{error} at {tick}");
            }
        }

        /// From the third edge on, at any time, but for the 50 µs by which an edge is uncertain.
        #[test]
        fn halls_read_true_down_to_6_rpm(speed in 6.0_f64..4000.0, forward: bool) {
            let speed = if forward { speed } else { -speed };
            let mut tachometer = HallTachometer::new(0);
            let settled = (3.0 * 50_000.0 / libm::fabs(speed)) as u32 + 100;
            for tick in 1..settled + 3000 {
                tachometer.tick(count(speed, 24.0, tick));
                let error = (f64::from(rpm(tachometer.rate(), 24)) - speed).abs();
                prop_assert!(tick <= settled || error <= speed.abs() * 0.04 + 0.6, "{error} at {tick}");
            }
        }

        #[test]
        fn nothing_overflows(counts: i32, ticks in 1_u32.., counts_per_turn: u32) {
            let speed = rpm(CountRate { counts, ticks }, counts_per_turn);
            prop_assert!(i64::from(speed) * i64::from(counts.signum()) >= 0);
            prop_assert!(speed != i32::MIN);
        }
    }
}
