//! Currents and voltages of three phases as the stator sees them (Clarke), and as the rotor does (Park).
//!
//! Both are amplitude-invariant. Results that do not fit saturate; none do for phase currents and voltages of 16 bits.
//!
//! This module must never know whether a vector is a current or a voltage.

use super::angle::{cosine, sine};

/// 1/√3 in 32 fractional bits.
const INVERSE_ROOT_3: i64 = 2_479_700_525;

/// A vector in the coordinates of the stator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StatorVector {
    /// Along phase U's axis.
    pub alpha: i32,
    /// A quarter of an electrical turn ahead of it.
    pub beta: i32,
}

/// A vector in the coordinates of the rotor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RotorVector {
    /// Along the magnet's axis: field.
    pub d: i32,
    /// A quarter of an electrical turn ahead of it: torque.
    pub q: i32,
}

impl RotorVector {
    /// What the stator sees of this vector when the rotor stands at `angle`: the inverse Park transform.
    #[must_use]
    pub fn to_stator(self, angle: u16) -> StatorVector {
        let (alpha, beta) = rotate(self.d, self.q, sine(angle), cosine(angle));
        StatorVector { alpha, beta }
    }
}

impl StatorVector {
    /// The vector of the currents in phases U, V and W: the Clarke transform, rounded to the nearest. What is common to
    /// the three, such as an offset of their measurement, drops out.
    #[must_use]
    pub fn from_phases([u, v, w]: [i16; 3]) -> Self {
        let [u, v, w] = [u, v, w].map(i32::from);
        let thrice_alpha = 2 * u - v - w;
        let alpha = (thrice_alpha + thrice_alpha.signum()) / 3;
        let beta = ((i64::from(v - w) * INVERSE_ROOT_3 + (1 << 31)) >> 32) as i32;
        Self { alpha, beta }
    }

    /// What the rotor at `angle` sees of this vector: the Park transform.
    #[must_use]
    pub fn to_rotor(self, angle: u16) -> RotorVector {
        let (d, q) = rotate(self.alpha, self.beta, -sine(angle), cosine(angle));
        RotorVector { d, q }
    }
}

/// The vector turned by an angle of this sine and cosine.
fn rotate(x: i32, y: i32, sine: i16, cosine: i16) -> (i32, i32) {
    let [x, y, sine, cosine] = [x, y, sine.into(), cosine.into()].map(i64::from);
    (scaled(x * cosine - y * sine), scaled(x * sine + y * cosine))
}

/// `product` / 32 767, rounded to the nearest, without a division: 1/32 767 is 1/32 768 and a 32 768th of that.
fn scaled(product: i64) -> i32 {
    let value = (product + (product >> 15) + (1 << 14)) >> 15;
    value.clamp(i32::MIN.into(), i32::MAX.into()) as i32
}

/// The vector, shortened to the length `limit` where it is longer: both parts in proportion, so that it keeps its direction
/// (a decision). A negative limit is 0.
#[must_use]
pub fn limit_circle(vector: RotorVector, limit: i32) -> RotorVector {
    let (d, q, limit) = (vector.d.unsigned_abs(), vector.q.unsigned_abs(), limit.max(0).unsigned_abs());
    // Voltages have 16 bits, for which 32 do.
    let fits = (d | q | limit) < 1 << 15;
    let (d, q) = if fits { shortened(d, q, limit) } else { shortened_long(d, q, limit) };
    RotorVector { d: with_sign(d, vector.d), q: with_sign(q, vector.q) }
}

/// Of magnitudes below 2¹⁵.
fn shortened(d: u32, q: u32, limit: u32) -> (u32, u32) {
    let square = d * d + q * q;
    if square <= limit * limit {
        return (d, q);
    }
    // Rounded up, so that what is left is never too long; not 0, as the square is above another.
    let length = (square - 1).isqrt() + 1;
    (d * limit / length, q * limit / length)
}

/// Of any magnitudes up to 2³¹.
fn shortened_long(d: u32, q: u32, limit: u32) -> (u32, u32) {
    let [wide_d, wide_q, limit] = [d, q, limit].map(u64::from);
    let square = wide_d * wide_d + wide_q * wide_q;
    if square <= limit * limit {
        return (d, q);
    }
    let length = (square - 1).isqrt() + 1;
    ((wide_d * limit / length) as u32, (wide_q * limit / length) as u32)
}

fn with_sign(magnitude: u32, sign: i32) -> i32 {
    if sign < 0 { 0_i32.wrapping_sub_unsigned(magnitude) } else { magnitude as i32 }
}

#[cfg(test)]
#[expect(clippy::float_arithmetic, reason = "the truth to check against")]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn length(x: i32, y: i32) -> f64 {
        libm::hypot(x.into(), y.into())
    }

    #[test]
    fn the_axes_are_where_the_phases_are() {
        assert_eq!(StatorVector::from_phases([1000, -500, -500]), StatorVector { alpha: 1000, beta: 0 });
        assert_eq!(StatorVector::from_phases([0, 866, -866]), StatorVector { alpha: 0, beta: 1000 });
        let field = RotorVector { d: 1000, q: 0 };
        assert_eq!(field.to_stator(0x4000), StatorVector { alpha: 0, beta: 1000 });
        let torque = RotorVector { d: 0, q: 1000 };
        assert_eq!(torque.to_stator(0x4000), StatorVector { alpha: -1000, beta: 0 });
        assert_eq!(StatorVector { alpha: 0, beta: 1000 }.to_rotor(0x4000), field);
    }

    #[test]
    fn a_limit_keeps_the_direction() {
        let limited = limit_circle(RotorVector { d: -30_000, q: 40_000 }, 32_767);
        assert_eq!(limited, RotorVector { d: -19_660, q: 26_213 });
        let small = limit_circle(RotorVector { d: -30_000, q: 20_000 }, 10_000);
        assert_eq!(small, RotorVector { d: -8_320, q: 5_546 });
        assert_eq!(limit_circle(RotorVector { d: 3, q: -4 }, 5), RotorVector { d: 3, q: -4 });
        assert_eq!(limit_circle(RotorVector { d: 3, q: -4 }, -5), RotorVector::default());
    }

    proptest! {
        #[test]
        fn clarke_is_true_of_sinusoids(amplitude in 0.0..32_000.0, turns in 0.0..1.0, offset in -700_i16..700) {
            let phase = |third: f64| amplitude * libm::cos((turns - third / 3.0) * core::f64::consts::TAU);
            let phases = [0.0, 1.0, 2.0].map(|third| libm::round(phase(third)) as i16 + offset);
            let vector = StatorVector::from_phases(phases);
            prop_assert!((f64::from(vector.alpha) - phase(0.0)).abs() < 1.2);
            prop_assert!((f64::from(vector.beta) - phase(0.75)).abs() < 1.2);
        }

        #[test]
        fn park_is_true_and_undone_by_its_inverse(alpha in -65_536..=65_536, beta in -65_536..=65_536, angle: u16) {
            let vector = StatorVector { alpha, beta };
            let turned = vector.to_rotor(angle);
            let (sine, cosine) = libm::sincos(f64::from(angle) * core::f64::consts::TAU / 65_536.0);
            let (alpha, beta) = (f64::from(alpha), f64::from(beta));
            prop_assert!((f64::from(turned.d) - (alpha * cosine + beta * sine)).abs() < 6.0);
            prop_assert!((f64::from(turned.q) - (beta * cosine - alpha * sine)).abs() < 6.0);
            let back = turned.to_stator(angle);
            prop_assert!(length(back.alpha - vector.alpha, back.beta - vector.beta) < 8.0, "{back:?} of {vector:?}");
        }

        /// Any vector, also of 16 bits: never longer than the limit, never shorter than it must be, in its direction.
        #[test]
        fn the_limit_is_never_exceeded(
            (d, q, limit) in prop_oneof![
                any::<(i32, i32, i32)>(),
                (-32_768..=32_768, -32_768..=32_768, 0..=32_768),
            ]
        ) {
            let limited = limit_circle(RotorVector { d, q }, limit);
            let [x, y, radius] = [limited.d, limited.q, limit.max(0)].map(i128::from);
            prop_assert!(x * x + y * y <= radius * radius);
            let inside = length(d, q) <= f64::from(limit);
            prop_assert!(!inside || (limited.d, limited.q) == (d, q));
            prop_assert!(inside || length(limited.d, limited.q) > f64::from(limit) - 3.5);
            prop_assert!(x * i128::from(d) >= 0 && y * i128::from(q) >= 0);
            let sideways = (f64::from(limited.d) * f64::from(q) - f64::from(limited.q) * f64::from(d)) / length(d, q).max(1.0);
            prop_assert!(sideways.abs() < 2.0, "{limited:?}");
        }

        #[test]
        fn nothing_overflows(x: i32, y: i32, angle: u16, phases: [i16; 3]) {
            let turned = StatorVector { alpha: x, beta: y }.to_rotor(angle);
            prop_assert!((f64::from(turned.d)).abs() <= 1.42 * length(x, y) + 1.0);
            let _ = RotorVector { d: x, q: y }.to_stator(angle);
            let vector = StatorVector::from_phases(phases);
            prop_assert!(vector.alpha.abs() <= 43_691 && vector.beta.abs() <= 37_838);
        }
    }
}
