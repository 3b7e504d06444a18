//! Instants: `"1.5s"`, `"200ms"`, `"50us"`, or a number of seconds.

use super::quantity;

/// The units and their seconds; the longer name of two that end alike comes first.
const UNITS: [(&str, f64); 4] = [("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6), ("s", 1.0)];

/// A text like `"1.5s"` in nanoseconds, rounded to the nearest.
pub(super) fn parse(text: &str) -> Result<u64, String> {
    let unit = UNITS.iter().find_map(|(unit, scale)| Some((text.strip_suffix(unit)?, scale)));
    let number = unit.and_then(|(number, scale)| Some((number.trim().parse::<f64>().ok()?, scale)));
    let (number, scale) =
        number.ok_or_else(|| format!("\"{text}\" is no instant: write \"1.5s\", \"200ms\" or \"50us\""))?;
    from_seconds(number * scale)
}

/// A number of seconds in nanoseconds, rounded to the nearest.
pub(super) fn from_seconds(seconds: f64) -> Result<u64, String> {
    quantity::INSTANT.check("at", seconds).map(|seconds| libm::round(seconds * 1e9) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit() {
        assert_eq!(parse("1.5s"), Ok(1_500_000_000));
        assert_eq!(parse("200 ms"), Ok(200_000_000));
        assert_eq!(parse("50us"), Ok(50_000));
        assert_eq!(parse("0.05µs"), Ok(50));
        assert_eq!(parse("1e-3s"), Ok(1_000_000));
        assert_eq!(from_seconds(0.1), Ok(100_000_000));
    }

    #[test]
    fn no_unit_no_number_no_sense() {
        for text in ["", "s", "1.5", "1.5 min", "1.5S", "x ms", "-1s", "nan s", "inf s", "1e300s"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
