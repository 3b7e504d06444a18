//! Times as people write them.

/// A number and its unit, in nanoseconds: `500us`, `1.5ms`, `10s`, `5min`, `1h`. `None` for anything else; what is too long, short
/// or negative is for the caller to say.
#[must_use]
pub fn nanoseconds(text: &str) -> Option<f64> {
    let number = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    let scale = match text.get(number.len()..)? {
        "us" => 1e3,
        "ms" => 1e6,
        "s" => 1e9,
        "min" => 60e9,
        "h" => 3.6e12,
        _ => return None,
    };
    Some(number.parse::<f64>().ok()? * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_a_number_and_its_unit() {
        let times = ["500us", "1.5ms", "10s", "5min", "1h"].map(nanoseconds);
        assert_eq!(times, [5e5, 1.5e6, 1e10, 3e11, 3.6e12].map(Some));
        for wrong in ["", "5", "ms", "5 s", "5S", "5min2s", "µs"] {
            assert_eq!(nanoseconds(wrong), None, "{wrong}");
        }
    }
}
