//! The regulator of currents (TMCM-1640 §7.2) and velocity (§7.3): proportional and integral, with both the integral part
//! and the whole limited.
//!
//! The sum of errors never grows beyond what makes the integral part alone the limit, so that it falls at once when the error
//! changes its sign (a decision). With an integral gain of 0 the sum stays 0: a gain that is raised later begins afresh.
//!
//! This module must never know what is regulated.

/// The gains. Negative ones are taken as they are: they make the regulator drive away from its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gains {
    /// Proportional gain in 1/256.
    pub p: i32,
    /// Integral gain in 1/65 536 for each call.
    pub i: i32,
}

/// The state of a regulator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pi {
    error: i32,
    sum: i64,
}

impl Pi {
    /// Without any error so far.
    #[must_use]
    pub const fn new() -> Self {
        Self { error: 0, sum: 0 }
    }

    /// One regulation with the error, target minus actual value: what to put out, from `-limit` to `limit`. A negative limit
    /// is 0.
    pub fn tick(&mut self, error: i32, gains: Gains, limit: i32) -> i32 {
        let limit = limit.max(0);
        self.error = error;
        self.sum = limited_sum(self.sum + i64::from(error), gains.i, limit.unsigned_abs());
        let proportional = i64::from(gains.p) * i64::from(error) / 256;
        let integral = i64::from(gains.i) * self.sum / 65_536;
        (proportional + integral).clamp((-limit).into(), limit.into()) as i32
    }

    /// The error of the last call.
    #[must_use]
    pub fn error(&self) -> i32 {
        self.error
    }

    /// The sum of errors, limited. It saturates: with small gains the regulator's own goes further.
    #[must_use]
    pub fn error_sum(&self) -> i32 {
        self.sum.clamp(i32::MIN.into(), i32::MAX.into()) as i32
    }

    /// Forgets all errors.
    pub fn reset(&mut self) {
        *self = Self::new();
    }
}

/// The sum, cut where `gain`·sum/65 536 would be beyond the limit.
fn limited_sum(sum: i64, gain: i32, limit: u32) -> i64 {
    let gain = gain.unsigned_abs();
    let top = u64::from(limit) << 16;
    if gain == 0 {
        0
    } else if sum.unsigned_abs().saturating_mul(gain.into()) > top {
        // Only a regulator at its limit comes here, and one of 16 bits without a division of 64.
        let bound = u32::try_from(top).map_or_else(|_| top / u64::from(gain), |top| u64::from(top / gain));
        bound as i64 * sum.signum()
    } else {
        sum
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn gains_are_in_256ths_and_65536ths() {
        let mut pi = Pi::new();
        let gains = Gains { p: 512, i: 6554 };
        assert_eq!([100, 100, -30].map(|error| pi.tick(error, gains, 1000)), [210, 220, -43]);
        assert_eq!((pi.error(), pi.error_sum()), (-30, 170));
        pi.reset();
        assert_eq!(pi, Pi::new());
    }

    #[test]
    fn without_gains_nothing_is_put_out_or_summed() {
        let mut pi = Pi::new();
        for error in [i32::MIN, i32::MAX, i32::MAX] {
            assert_eq!(pi.tick(error, Gains::default(), i32::MAX), 0);
        }
        assert_eq!(pi.error_sum(), 0);
        assert_eq!(pi.tick(100, Gains { p: 0, i: 65_536 }, 1000), 100);
    }

    #[test]
    fn a_plant_of_first_order_comes_to_its_target() {
        let (mut pi, mut plant) = (Pi::new(), 0);
        for _ in 0..20_000 {
            plant += (pi.tick(1000 - plant / 256, Gains { p: 600, i: 600 }, 32_767) * 16 - plant) / 64;
        }
        assert!((plant / 256 - 1000).abs() <= 4, "{plant}");
    }

    proptest! {
        /// Whatever the errors, gains and limits: within the limit, and so the integral part alone.
        #[test]
        fn the_limit_holds(steps in proptest::collection::vec(any::<(i32, i32, i32, i32)>(), 1..50)) {
            let mut pi = Pi::new();
            for (error, p, i, limit) in steps {
                let output = pi.tick(error, Gains { p, i }, limit);
                prop_assert!(output.unsigned_abs() <= limit.max(0).unsigned_abs());
                let product = i128::from(pi.sum) * i128::from(i);
                prop_assert!(product.unsigned_abs() <= u128::from(limit.max(0).unsigned_abs()) << 16);
                prop_assert_eq!(pi.error(), error);
            }
        }

        /// However long it has been at its limit, the first error the other way takes it off.
        #[test]
        fn it_leaves_its_limit_at_once(
            windup in 1..100_000,
            ticks in 1..2000,
            p in 0..100_000,
            i in 1_i32..100_000,
            limit in 1..100_000,
            forward: bool,
        ) {
            let (mut pi, gains) = (Pi::new(), Gains { p, i });
            let sign = if forward { 1 } else { -1 };
            for _ in 0..ticks {
                pi.tick(sign * windup, gains, limit);
            }
            // An error that alone takes two parts off the integral.
            let back = 131_072 / i + 1;
            let output = sign * pi.tick(-sign * back, gains, limit);
            prop_assert!(output < limit, "{output}");
        }

        /// Below its limit it is the plain law.
        #[test]
        fn small_errors_are_summed_exactly(
            errors in proptest::collection::vec(-1000..1000, 1..100),
            p in -999..999,
            i in -999..999,
        ) {
            let mut pi = Pi::new();
            let mut sum = 0;
            for error in errors {
                sum += error;
                let output = pi.tick(error, Gains { p, i }, i32::MAX);
                prop_assert_eq!(output, p * error / 256 + i * sum / 65_536);
            }
        }
    }
}
