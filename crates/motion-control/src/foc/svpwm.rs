//! Space vector modulation: the duty cycles whose mean phase voltages are a vector (TMCM-1640 §7.2).
//!
//! The star point is free, so that all three phases may be moved together. Moved so that the largest and the smallest
//! are equally far from the rails, they reach 2/√3 as far as sines around the middle.
//!
//! This module must never know the supply voltage.

/// 2⁴⁴ / (32 767·√3): parts of the supply in a unit of voltage.
const SUPPLY_PER_UNIT: i64 = 309_972_025;

/// √3/2 in 31 fractional bits.
const HALF_ROOT_3: i64 = 1_859_775_393;

/// More than this is taken for this, in each coordinate; everything within the circle is far below.
const MAX_VOLTAGE: i32 = 131_071;

/// Fractional bits of a duty cycle while it is computed.
const FRACTION_BITS: u32 = 10;

/// For how much of `period` the upper transistors of phases U, V and W are on, to have phase voltages of the vector
/// (`alpha`, `beta`) in stator coordinates. 32 767 is 1/√3 of the supply, which all vectors of that length or less get.
/// A phase that would need more than the supply stays at the rail.
#[must_use]
pub fn duties(alpha: i32, beta: i32, period: u16) -> [u16; 3] {
    let period = i32::from(period);
    let gain = (i64::from(period) * SUPPLY_PER_UNIT) >> 16; // in 28 fractional bits
    let scaled = |voltage: i32| {
        let voltage = voltage.clamp(-MAX_VOLTAGE, MAX_VOLTAGE);
        ((i64::from(voltage) * gain) >> (28 - FRACTION_BITS)) as i32
    };
    let u = scaled(alpha);
    let across = ((i64::from(scaled(beta)) * HALF_ROOT_3) >> 31) as i32;
    let (v, w) = (-u / 2 + across, -u / 2 - across);
    let common = (u.max(v).max(w) + u.min(v).min(w)) / 2;
    let middle = (period << (FRACTION_BITS - 1)) + (1 << (FRACTION_BITS - 1)) - common;
    [u, v, w].map(|phase| ((phase + middle) >> FRACTION_BITS).clamp(0, period) as u16)
}

#[cfg(test)]
#[expect(clippy::float_arithmetic, reason = "the truth to check against")]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PERIOD: u16 = 32_768;

    /// The voltages U to V and V to W in parts of the supply, which a vector asks for.
    fn wanted(alpha: i32, beta: i32) -> [f64; 2] {
        let unit = 32_767.0 * libm::sqrt(3.0);
        let (alpha, beta) = (f64::from(alpha) / unit, f64::from(beta) * libm::sqrt(3.0) / unit);
        [1.5 * alpha - beta / 2.0, beta]
    }

    fn got([u, v, w]: [u16; 3], period: u16) -> [f64; 2] {
        [f64::from(u) - f64::from(v), f64::from(v) - f64::from(w)].map(|line| line / f64::from(period))
    }

    #[test]
    fn no_voltage_is_half_the_period_on_all_phases() {
        assert_eq!(duties(0, 0, PERIOD), [PERIOD / 2; 3]);
        assert_eq!(duties(i32::MIN, i32::MAX, 0), [0; 3]);
    }

    #[test]
    fn the_longest_vector_reaches_both_rails() {
        assert_eq!(duties(0, 32_767, PERIOD), [PERIOD / 2, PERIOD, 0]);
        assert_eq!(duties(32_767, 0, PERIOD), [30_573, 2195, 2195]);
        assert_eq!(duties(0, i32::MIN, PERIOD), [PERIOD / 2, 0, PERIOD]);
    }

    proptest! {
        /// Within the circle: the voltages between the phases are true within 2 parts of the period, and the largest and
        /// the smallest duty cycle are as far from the rails.
        #[test]
        fn line_voltages_are_exact(radius in 0.0..=32_767.0, turns in 0.0..1.0, period in 1000_u16..) {
            let (sine, cosine) = libm::sincos(turns * core::f64::consts::TAU);
            let (alpha, beta) = (libm::trunc(radius * cosine) as i32, libm::trunc(radius * sine) as i32);
            let duties = duties(alpha, beta, period);
            for (got, wanted) in got(duties, period).into_iter().zip(wanted(alpha, beta)) {
                prop_assert!((got - wanted).abs() * f64::from(period) <= 1.1, "{got} for {wanted}");
            }
            let highest = i32::from(*duties.iter().max().unwrap());
            let lowest = i32::from(*duties.iter().min().unwrap());
            prop_assert!((highest + lowest - i32::from(period)).abs() <= 2);
        }

        #[test]
        fn nothing_overflows(alpha: i32, beta: i32, period: u16) {
            prop_assert!(duties(alpha, beta, period).into_iter().all(|duty| duty <= period));
        }
    }
}
