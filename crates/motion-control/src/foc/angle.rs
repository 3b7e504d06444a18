//! Sine and cosine of an electrical angle, from a quarter wave with straight lines between its points.
//!
//! This module must never know what turns.

use crate::sine::{QUARTER, quarter_wave};

/// The sine of 90°.
pub const ONE: i16 = 32_767;

/// A quarter turn as an angle.
const QUARTER_TURN: u16 = 0x4000;

/// Bits of an angle between two points of the table.
const FRACTION_BITS: u32 = (QUARTER_TURN as usize / QUARTER).trailing_zeros();

static QUARTER_WAVE: [i16; QUARTER + 1] = quarter_wave(ONE);

/// The sine of an angle of 65 536 to a turn, in parts of 1/[`ONE`]; off by at most 1.2 of them.
#[must_use]
pub fn sine(angle: u16) -> i16 {
    let within = angle % QUARTER_TURN;
    match angle / QUARTER_TURN {
        0 => rising(within),
        1 => rising(QUARTER_TURN - within),
        2 => -rising(within),
        _ => -rising(QUARTER_TURN - within),
    }
}

/// The cosine, like [`sine`].
#[must_use]
pub fn cosine(angle: u16) -> i16 {
    sine(angle.wrapping_add(QUARTER_TURN))
}

/// The sine of an angle from 0 to 90°.
fn rising(angle: u16) -> i16 {
    let index = usize::from(angle >> FRACTION_BITS);
    let fraction = i32::from(angle % (1 << FRACTION_BITS));
    // Behind the last point the fraction is 0.
    let at = |index: usize| QUARTER_WAVE.get(index).copied().map_or(0, i32::from);
    let (here, next) = (at(index), at(index + 1));
    (here + (((next - here) * fraction + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS)) as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_true_within_1_2_units() {
        for angle in 0..=u16::MAX {
            let radians = f64::from(angle) * core::f64::consts::TAU / 65_536.0;
            assert!((f64::from(sine(angle)) - 32_767.0 * libm::sin(radians)).abs() < 1.2, "sine of {angle}");
            assert!(
                (f64::from(cosine(angle)) - 32_767.0 * libm::cos(radians)).abs() < 1.2,
                "cosine of {angle}"
            );
        }
    }

    #[test]
    fn the_quarters_are_alike_and_the_axes_exact() {
        assert_eq!([0, 0x4000, 0x8000, 0xC000].map(sine), [0, ONE, 0, -ONE]);
        for angle in 0..=u16::MAX {
            assert_eq!(sine(angle), -sine(angle.wrapping_neg()));
            assert_eq!(sine(angle), sine(0x8000_u16.wrapping_sub(angle)));
        }
    }
}
