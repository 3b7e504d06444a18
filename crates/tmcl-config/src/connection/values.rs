//! What the settings take, wherever they are written.

use std::fmt;
use std::time::Duration;

use tmcl_tables::tmcm_1311;

use crate::time::nanoseconds;

/// The largest identifier of a CAN bus with 11 bits.
const MAX_ID: u16 = 0x7FF;

/// The rates to talk at: one, or several to look for a module at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BaudRates(Vec<u32>);

impl fmt::Display for BaudRates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rates: Vec<String> = self.0.iter().map(u32::to_string).collect();
        f.write_str(&rates.join(","))
    }
}

impl BaudRates {
    /// Each of them.
    #[must_use]
    pub fn rates(&self) -> Vec<u32> {
        self.0.clone()
    }
}

/// Rates of a serial port: `9600`; several as in `9600,115200`, or `all` that modules can be set to.
///
/// # Errors
/// What is expected, in words.
pub fn baud_rates(text: &str) -> Result<BaudRates, String> {
    const EXPECTED: &str = "a number of bits per second is expected, such as 9600 or 115200; \
                            `tmcl scan` also takes several, and `all`";
    if text.eq_ignore_ascii_case("all") {
        return Ok(BaudRates(known_rates()));
    }
    let rates = text.split(',').map(|rate| rate.trim().parse::<u32>().ok().filter(|rate| *rate > 0));
    let rates: Option<Vec<u32>> = rates.collect();
    rates.map(BaudRates).ok_or_else(|| EXPECTED.to_owned())
}

/// Those that the tables name, the factory's first.
fn known_rates() -> Vec<u32> {
    let (bank, number) = tmcl_tables::GlobalParameter::BaudRate.address();
    let values =
        tmcm_1311::SPEC.global_parameter(bank, number).map_or(&[][..], |entry| entry.parameter.values);
    values.iter().filter_map(|named| named.name.split(' ').next()?.parse().ok()).collect()
}

/// An address, which is an identifier on a CAN bus; whether it is too large for the port, that is seen later.
///
/// # Errors
/// What is expected, in words.
pub fn address(text: &str) -> Result<u16, String> {
    const EXPECTED: &str =
        "an address from 0 to 255 is expected, or an identifier on a CAN bus, from 0 to 0x7FF (2047)";
    let hexadecimal = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    let is_digits = |digits: &str| digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    let number = match hexadecimal {
        Some(digits) if is_digits(digits) => u16::from_str_radix(digits, 16),
        _ => text.parse(),
    };
    number.ok().filter(|id| *id <= MAX_ID).ok_or_else(|| EXPECTED.to_owned())
}

/// How long to wait for a reply: 1 ms to 1 h.
///
/// # Errors
/// What is expected, in words.
pub fn timeout(text: &str) -> Result<Duration, String> {
    const EXPECTED: &str = "a time from 1ms to 1h is expected, such as 500ms or 1s";
    nanoseconds(text)
        .filter(|time_ns| (1e6..=3.6e12).contains(time_ns))
        .map_or_else(|| Err(EXPECTED.to_owned()), |time_ns| Ok(Duration::from_nanos(time_ns as u64)))
}

/// How often to ask again: 0 to 100.
///
/// # Errors
/// What is expected, in words.
pub fn retries(text: &str) -> Result<u32, String> {
    text.parse()
        .ok()
        .filter(|retries| *retries <= 100)
        .ok_or_else(|| "a number from 0 to 100 is expected".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates() {
        assert_eq!(baud_rates("9600"), Ok(BaudRates(vec![9600])));
        assert_eq!(baud_rates("9600, 115200"), Ok(BaudRates(vec![9600, 115_200])));
        let all = baud_rates("all").expect("they are known").rates();
        assert_eq!((all.first(), all.last(), all.len()), (Some(&9600), Some(&1_000_000), 12));
        for wrong in ["", "0", "fast", "9600,", "-1"] {
            assert!(baud_rates(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn addresses_are_decimal_or_hexadecimal() {
        let addresses = ["0", "255", "256", "0x304", "0X7ff"].map(address);
        assert_eq!(addresses, [0, 255, 256, 0x304, 0x7FF].map(Ok));
        for wrong in ["", "2048", "0x800", "-1", "0x", "0x+1", "1.5", "7FF"] {
            assert!(address(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn times_have_units() {
        assert_eq!(timeout("1s"), Ok(Duration::from_secs(1)));
        assert_eq!(timeout("1.5ms"), Ok(Duration::from_micros(1500)));
        for wrong in ["1", "0s", "500us", "2h", "ms", "-1s"] {
            assert!(timeout(wrong).is_err(), "{wrong}");
        }
    }
}
