//! What a number token says.

/// Why a number token is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum BadNumber {
    /// A letter or `_` among decimal digits.
    #[error("a decimal number holds nothing but digits")]
    NotDecimal,
    /// A letter beyond F, or `_`, among hexadecimal digits.
    #[error("a hexadecimal number holds nothing but digits and the letters A to F")]
    NotHexadecimal,
    /// `$` or `0x` alone.
    #[error("hexadecimal digits are expected behind it")]
    NoDigits,
    /// It does not fit 32 bits.
    #[error("the largest is 4294967295 or $FFFFFFFF")]
    TooLarge,
}

/// The value of a number as it is written, without a sign.
pub(super) fn read(text: &[u8]) -> Result<u32, BadNumber> {
    let hexadecimal =
        text.strip_prefix(b"$").or_else(|| text.strip_prefix(b"0x")).or_else(|| text.strip_prefix(b"0X"));
    match hexadecimal {
        Some([]) => Err(BadNumber::NoDigits),
        Some(digits) => value(digits, 16).unwrap_or(Err(BadNumber::NotHexadecimal)),
        None => value(text, 10).unwrap_or(Err(BadNumber::NotDecimal)),
    }
}

/// None where there is something else than digits.
fn value(digits: &[u8], base: u32) -> Option<Result<u32, BadNumber>> {
    let mut value = Some(0u32);
    for digit in digits {
        let digit = char::from(*digit).to_digit(base)?;
        value = value.and_then(|value| value.checked_mul(base)?.checked_add(digit));
    }
    Some(value.ok_or(BadNumber::TooLarge))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_notations() {
        assert_eq!(read(b"007"), Ok(7));
        assert_eq!(read(b"$fF"), Ok(255));
        assert_eq!(read(b"0x10"), Ok(16));
        assert_eq!(read(b"0X10"), Ok(16));
        assert_eq!(read(b"4294967295"), Ok(u32::MAX));
        assert_eq!(read(b"$00FFFFFFFF"), Ok(u32::MAX));
    }

    #[test]
    fn all_that_can_be_wrong() {
        assert_eq!(read(b"12abc"), Err(BadNumber::NotDecimal));
        assert_eq!(read(b"1_000"), Err(BadNumber::NotDecimal));
        assert_eq!(read(b"99999999999x"), Err(BadNumber::NotDecimal));
        assert_eq!(read(b"$1G"), Err(BadNumber::NotHexadecimal));
        assert_eq!(read(b"0x"), Err(BadNumber::NoDigits));
        assert_eq!(read(b"$"), Err(BadNumber::NoDigits));
        assert_eq!(read(b"4294967296"), Err(BadNumber::TooLarge));
        assert_eq!(read(b"$100000000"), Err(BadNumber::TooLarge));
    }
}
