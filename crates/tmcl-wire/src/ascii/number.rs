//! Numbers as they are typed: decimal, `$1F` or `0x1F`, with a sign or without; 32 bits.

/// A number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Number {
    value: i64,
    /// Written in hexadecimal without a sign: it may use all 32 bits.
    is_pattern: bool,
}

impl Number {
    /// The number that a word is, or None.
    pub(super) fn read(word: &[u8]) -> Option<Self> {
        let (sign, word) = match word {
            [b'-', rest @ ..] => (Some(-1), rest),
            [b'+', rest @ ..] => (Some(1), rest),
            _ => (None, word),
        };
        let (base, digits) = match word {
            [b'$', rest @ ..] | [b'0', b'x' | b'X', rest @ ..] => (16, rest),
            _ => (10, word),
        };
        let magnitude = i64::from(magnitude(digits, base)?);
        Some(Self { value: sign.unwrap_or(1) * magnitude, is_pattern: base == 16 && sign.is_none() })
    }

    /// As a byte.
    pub(super) fn byte(self) -> Option<u8> {
        u8::try_from(self.value).ok()
    }

    /// As the 32 bits of a value. What needs all of them without a sign is a pattern, or `unsigned`.
    pub(super) fn bits(self, unsigned: bool) -> Option<i32> {
        let signed = i32::try_from(self.value).ok();
        let whole = u32::try_from(self.value).ok().filter(|_| unsigned || self.is_pattern);
        signed.or(whole.map(u32::cast_signed))
    }
}

fn magnitude(digits: &[u8], base: u32) -> Option<u32> {
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0_u32, |value, digit| {
        value.checked_mul(base)?.checked_add(char::from(*digit).to_digit(base)?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bits(word: &str) -> Option<i32> {
        Number::read(word.as_bytes())?.bits(false)
    }

    #[test]
    fn all_notations() {
        assert_eq!(["0", "007", "+5", "-5"].map(bits), [Some(0), Some(7), Some(5), Some(-5)]);
        assert_eq!(["$fF", "0x10", "0X10", "-$10"].map(bits), [Some(255), Some(16), Some(16), Some(-16)]);
        assert_eq!(
            ["2147483647", "-2147483648", "$FFFFFFFF"].map(bits),
            [Some(i32::MAX), Some(i32::MIN), Some(-1)]
        );
    }

    #[test]
    fn what_is_no_number_or_does_not_fit() {
        for word in
            ["", "-", "+", "$", "0x", "--5", "5-", "1_000", "12abc", "$1G", "1.5", "4294967296", "$100000000"]
        {
            assert_eq!(Number::read(word.as_bytes()), None, "{word}");
        }
        assert_eq!(["2147483648", "-2147483649", "-$80000001"].map(bits), [None; 3]);
    }

    #[test]
    fn a_byte_is_not_negative() {
        let byte = |word: &str| Number::read(word.as_bytes()).and_then(Number::byte);
        assert_eq!(["0", "255", "256", "-1"].map(byte), [Some(0), Some(255), None, None]);
    }

    #[test]
    fn an_unsigned_value_may_use_all_bits() {
        assert_eq!(Number::read(b"4294967295").and_then(|number| number.bits(true)), Some(-1));
    }
}
