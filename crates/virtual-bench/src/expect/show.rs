//! Numbers and times as reports write them.

/// Whole numbers up to here are exact.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// A number: whole ones in full, others to nine digits.
pub(super) fn number(value: f64) -> String {
    if libm::trunc(value) == value && value.abs() < EXACT {
        // Not -0.
        return (value + 0.0).to_string();
    }
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    if (1e-4..1e9).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// A time in seconds, to the millisecond or as far as it has digits.
#[must_use]
pub fn time(time_ns: u64) -> String {
    let text = format!("{}.{:09}", time_ns / 1_000_000_000, time_ns % 1_000_000_000);
    let least = text.len() - 6;
    let kept = text.trim_end_matches('0').len().max(least);
    format!("{} s", text.get(..kept).unwrap_or(&text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers() {
        let shown =
            [0.0, -0.0, -5.0, 4_294_967_295.0, 0.5, 0.1 + 0.2, 1e-7, 1e300, 123_456.789_012_3].map(number);
        assert_eq!(shown, ["0", "0", "-5", "4294967295", "0.5", "0.3", "1e-7", "1e300", "123456.789"]);
    }

    #[test]
    fn times() {
        let shown = [0, 50_000, 2_000_000_000, 1_900_050_000, 61_100_000_000, 1].map(time);
        assert_eq!(shown, ["0.000 s", "0.00005 s", "2.000 s", "1.90005 s", "61.100 s", "0.000000001 s"]);
    }
}
