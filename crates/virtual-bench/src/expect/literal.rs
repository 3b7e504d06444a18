//! Numbers, masks and times as expectations write them.

use crate::TICK_NS;

/// The units of time and their seconds; where one ends like another, the longer one comes first.
const UNITS: [(&str, f64); 6] =
    [("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6), ("μs", 1e-6), ("s", 1.0), ("min", 60.0)];

/// The longest time, in seconds: 115 days.
const LONGEST_S: f64 = 1e7;

/// Whether a word is meant to be a number: names do not begin like this.
pub(super) fn looks_like_a_number(word: &str) -> bool {
    let digits = word.strip_prefix('-').unwrap_or(word);
    digits.starts_with(|first: char| first.is_ascii_digit() || first == '$' || first == '.')
}

/// A number: `10000`, `-3`, `0.5`, `1e-3`, `0x200`, `$200`. None where the word is no such thing.
pub(super) fn number(word: &str) -> Option<f64> {
    if !looks_like_a_number(word) {
        return None;
    }
    let (negative, digits) = match word.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, word),
    };
    let magnitude = match hexadecimal(digits) {
        Some(value) => f64::from(value?),
        None => digits.parse::<f64>().ok().filter(|value| value.is_finite())?,
    };
    Some(if negative { -magnitude } else { magnitude })
}

/// A mask: a whole number of at most 32 bits.
pub(super) fn mask(word: &str) -> Option<u32> {
    match hexadecimal(word) {
        Some(value) => value,
        // `parse` takes a sign too.
        None => looks_like_a_number(word).then(|| word.parse().ok()).flatten(),
    }
}

/// The digits after `0x` or `$`; None where there is neither, Some(None) where what follows is no number of 32 bits.
fn hexadecimal(word: &str) -> Option<Option<u32>> {
    let digits = ["0x", "0X", "$"].iter().find_map(|prefix| word.strip_prefix(prefix))?;
    let clean = digits.chars().all(|digit| digit.is_ascii_hexdigit());
    Some(clean.then(|| u32::from_str_radix(digits, 16).ok()).flatten())
}

/// Whether a word is a unit of time.
pub(super) fn is_unit(word: &str) -> bool {
    UNITS.iter().any(|(unit, _)| *unit == word)
}

/// A time such as `500us`, `10ms`, `1.5s`, `2min`, in nanoseconds. What lies within a control period counts as its
/// beginning: nothing is seen in between.
pub(super) fn time_ns(word: &str) -> Option<u64> {
    let split = |(unit, scale): &(&str, f64)| Some((word.strip_suffix(unit)?, *scale));
    let (digits, scale) = UNITS.iter().find_map(split)?;
    let unsigned = digits.starts_with(|first: char| first.is_ascii_digit() || first == '.');
    let seconds = digits.parse::<f64>().ok().filter(|_| unsigned)? * scale;
    (seconds <= LONGEST_S).then(|| libm::round(seconds * 1e9) as u64 / TICK_NS * TICK_NS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers() {
        let good = [
            ("0", 0.0),
            ("10000", 10_000.0),
            ("-3", -3.0),
            (".5", 0.5),
            ("-0.25", -0.25),
            ("1e-3", 1e-3),
            ("0x200", 512.0),
            ("-0x10", -16.0),
            ("$ff", 255.0),
            ("0xFFFFFFFF", 4_294_967_295.0),
        ];
        for (word, value) in good {
            assert_eq!(number(word), Some(value), "{word}");
        }
        for word in [
            "",
            "-",
            "x",
            "inf",
            "nan",
            "-inf",
            "1e999",
            "0x",
            "$",
            "0x100000000",
            "0x+1",
            "1,5",
            "--1",
            "+1",
        ] {
            assert_eq!(number(word), None, "{word}");
        }
    }

    #[test]
    fn masks() {
        assert_eq!((mask("0x200"), mask("$80000000"), mask("3")), (Some(512), Some(1 << 31), Some(3)));
        for word in ["", "-1", "1.0", "+1", "0x1FFFFFFFF", "$", "x"] {
            assert_eq!(mask(word), None, "{word}");
        }
    }

    #[test]
    fn times_are_cut_to_control_periods() {
        let good = [
            ("500us", 500_000),
            ("50µs", 50_000),
            ("50μs", 50_000),
            ("10ms", 10_000_000),
            ("1.5s", 1_500_000_000),
            (".5s", 500_000_000),
            ("2min", 120_000_000_000),
            ("0s", 0),
            ("0.1s", 100_000_000),
            ("49us", 0),
            ("149.9us", 100_000),
        ];
        for (word, value) in good {
            assert_eq!(time_ns(word), Some(value), "{word}");
        }
        for word in ["", "s", "2", "2h", "-1s", "+1s", "1e300s", "infs", "nan s", "2 s", "0x2s", "1.5.5s"] {
            assert_eq!(time_ns(word), None, "{word}");
        }
    }
}
