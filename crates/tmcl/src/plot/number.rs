//! Numbers beside an axis: short, with SI prefixes, and no more digits than the step between them needs.

/// Powers of ten whose prefixes are used, in steps of 1000.
const PREFIXES: [&str; 9] = ["p", "n", "µ", "m", "", "k", "M", "G", "T"];

/// Units that are written with a prefix. With all others ("rpm", "steps", "°C") the prefix stands at the number.
const PREFIXABLE: [&str; 11] = ["s", "A", "V", "W", "J", "N", "N·m", "Nm", "Hz", "Ω", "m"];

/// 10 to the power of `exponent`: the nearest number there is, on every machine.
pub(super) fn power_of_ten(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().unwrap_or(f64::INFINITY)
}

/// The largest `n` with 10 to the power of `n` at most `|value|`; 0 for 0.
pub(super) fn exponent(value: f64) -> i32 {
    let text = format!("{value:e}");
    text.rsplit_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// How the numbers of one axis are written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Notation {
    exponent: i32,
    suffix: &'static str,
    scientific: bool,
    decimals: usize,
    /// The unit with its prefix.
    pub(super) unit: String,
}

impl Notation {
    /// For numbers up to `largest` that are `step` apart; both above 0.
    pub(super) fn new(largest: f64, step: f64, unit: &str) -> Self {
        let prefixable = PREFIXABLE.contains(&unit);
        let exponent = thousands(largest, unit);
        let prefix = usize::try_from(exponent / 3 + 4).ok().and_then(|index| PREFIXES.get(index).copied());
        let Some(prefix) = prefix else {
            let decimals = (self::exponent(largest) - self::exponent(step)).max(0);
            return Self {
                exponent: 0,
                suffix: "",
                scientific: true,
                decimals: decimals.unsigned_abs() as usize,
                unit: unit.to_owned(),
            };
        };
        let decimals = (exponent - self::exponent(step)).max(0).unsigned_abs() as usize;
        let (suffix, unit) =
            if prefixable { ("", format!("{prefix}{unit}")) } else { (prefix, unit.to_owned()) };
        Self { exponent, suffix, scientific: false, decimals, unit }
    }

    /// A number as it is written, with a real minus sign.
    pub(super) fn write(&self, value: f64) -> String {
        if value == 0.0 {
            return "0".to_owned();
        }
        let decimals = self.decimals;
        let text = if self.scientific {
            format!("{value:.decimals$e}")
        } else {
            format!("{:.decimals$}{}", shift(value, -self.exponent), self.suffix)
        };
        text.replace('-', "−")
    }
}

/// The power of 1000 that leaves the largest number with one to three digits, as an exponent of ten. Numbers of everyday
/// size stay as they are, and nobody counts in kiloseconds.
fn thousands(largest: f64, unit: &str) -> i32 {
    if (0.1..1e4).contains(&largest) || (unit == "s" && (1e4..1e7).contains(&largest)) {
        return 0;
    }
    exponent(largest).div_euclid(3) * 3
}

fn shift(value: f64, exponent: i32) -> f64 {
    if exponent < 0 { value / power_of_ten(-exponent) } else { value * power_of_ten(exponent) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_exact() {
        for n in -300..=300 {
            let power = power_of_ten(n);
            assert_eq!(exponent(power), n);
            assert_eq!(exponent(-power.next_down()), n - 1);
        }
        assert_eq!(exponent(0.0), 0);
    }

    #[test]
    fn digits_follow_the_step() {
        let write = |value, step, unit| {
            let notation = Notation::new(value, step, unit);
            (notation.write(value), notation.unit)
        };
        let owned = |number: &str, unit: &str| (number.to_owned(), unit.to_owned());
        assert_eq!(write(0.1, 0.05, "N·m"), owned("0.10", "N·m"));
        assert_eq!(write(400.0, 100.0, "rpm"), owned("400", "rpm"));
        assert_eq!(write(2000.0, 500.0, "V"), owned("2000", "V"));
        assert_eq!(write(51_200.0, 200.0, "pps"), owned("51.2k", "pps"));
        assert_eq!(write(0.02, 0.005, "A"), owned("20", "mA"));
        assert_eq!(write(0.02, 0.005, "turns"), owned("20m", "turns"));
        assert_eq!(write(2e-6, 5e-7, "s"), owned("2.0", "µs"));
        assert_eq!(write(20_000.0, 5000.0, "s"), owned("20000", "s"));
        assert_eq!(write(2.5e20, 5e19, "A"), owned("2.5e20", "A"));
        assert_eq!(write(1.5e-200, 5e-201, ""), owned("1.5e−200", ""));
    }

    #[test]
    fn below_zero() {
        let notation = Notation::new(1.5, 0.5, "A");
        assert_eq!((notation.write(-1.5), notation.write(-0.0)), ("−1.5".to_owned(), "0".to_owned()));
    }
}
