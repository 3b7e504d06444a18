//! Division of 64 bits for a processor that divides 32 in an instruction and 64 in some hundred.

/// Quotient, rounded down, and remainder, for a divisor above 0. What is divided in a control period mostly fits 32 bits.
pub(crate) fn divided(dividend: i64, divisor: i64) -> (i64, i64) {
    let divisor = divisor.max(1);
    match (i32::try_from(dividend), i32::try_from(divisor)) {
        (Ok(dividend), Ok(divisor)) => {
            let quotient = dividend.checked_div_euclid(divisor).unwrap_or(0);
            (quotient.into(), dividend.checked_rem_euclid(divisor).unwrap_or(0).into())
        }
        _ => (dividend.div_euclid(divisor), dividend.rem_euclid(divisor)),
    }
}

/// Quotient, rounded down, and remainder, for a constant divisor above 0. Its factors of two are shifted out first, and what is
/// left mostly fits 32 bits, too.
#[inline(always)]
pub(crate) fn divided_down(dividend: i64, divisor: i64) -> (i64, i64) {
    let twos = divisor.trailing_zeros();
    let quotient = match (i32::try_from(dividend >> twos), i32::try_from(divisor >> twos)) {
        (Ok(dividend), Ok(divisor)) => dividend.div_euclid(divisor).into(),
        _ => dividend.div_euclid(divisor),
    };
    // The product may lie below what 64 bits hold; the remainder does not.
    (quotient, dividend.wrapping_sub(quotient.wrapping_mul(divisor)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::TICKS_PER_SECOND;
    use crate::ramp::UNITS_PER_STEP;

    proptest! {
        #[test]
        fn thirty_two_bits_divide_like_sixty_four(
            dividend in -3_000_000_000_i64..3_000_000_000,
            divisor in 1_i64..3_000_000_000,
        ) {
            let expected = (dividend.div_euclid(divisor), dividend.rem_euclid(divisor));
            prop_assert_eq!(divided(dividend, divisor), expected);
        }

        #[test]
        fn dividing_by_way_of_shifts_is_dividing(
            dividend in prop_oneof![-1_i64 << 34..1 << 34, any::<i64>(), Just(i64::MIN)],
            divisor in prop_oneof![Just(UNITS_PER_STEP), Just(TICKS_PER_SECOND), 1_i64..1 << 40],
        ) {
            let expected = (dividend.div_euclid(divisor), dividend.rem_euclid(divisor));
            prop_assert_eq!(divided_down(dividend, divisor), expected);
        }
    }
}
