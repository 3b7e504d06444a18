//! The bit rates that have a command.

/// The bit rates that an adapter can be told with `S` and a digit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitRate {
    /// `S0`: 10 kbit/s.
    Kbit10,
    /// `S1`: 20 kbit/s.
    Kbit20,
    /// `S2`: 50 kbit/s.
    Kbit50,
    /// `S3`: 100 kbit/s.
    Kbit100,
    /// `S4`: 125 kbit/s.
    Kbit125,
    /// `S5`: 250 kbit/s.
    Kbit250,
    /// `S6`: 500 kbit/s.
    Kbit500,
    /// `S7`: 800 kbit/s.
    Kbit800,
    /// `S8`: 1 Mbit/s.
    Kbit1000,
}

impl BitRate {
    /// All of them, in the order of their digits.
    pub const ALL: [Self; 9] = [
        Self::Kbit10,
        Self::Kbit20,
        Self::Kbit50,
        Self::Kbit100,
        Self::Kbit125,
        Self::Kbit250,
        Self::Kbit500,
        Self::Kbit800,
        Self::Kbit1000,
    ];

    /// The one with this many bits per second.
    #[must_use]
    pub fn from_bits_per_second(wanted: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|rate| rate.bits_per_second() == wanted)
    }

    /// Bits per second.
    #[must_use]
    pub const fn bits_per_second(self) -> u32 {
        match self {
            Self::Kbit10 => 10_000,
            Self::Kbit20 => 20_000,
            Self::Kbit50 => 50_000,
            Self::Kbit100 => 100_000,
            Self::Kbit125 => 125_000,
            Self::Kbit250 => 250_000,
            Self::Kbit500 => 500_000,
            Self::Kbit800 => 800_000,
            Self::Kbit1000 => 1_000_000,
        }
    }

    /// The digit behind `S`.
    pub(super) const fn digit(self) -> u8 {
        b'0' + self as u8
    }

    pub(super) fn from_digit(digit: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|rate| rate.digit() == digit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_and_rates_go_together() {
        for (rate, digit) in BitRate::ALL.into_iter().zip(b'0'..) {
            assert_eq!((rate.digit(), BitRate::from_digit(digit)), (digit, Some(rate)));
            assert_eq!(BitRate::from_bits_per_second(rate.bits_per_second()), Some(rate));
        }
        assert_eq!(BitRate::from_digit(b'9'), None);
        assert_eq!(BitRate::from_bits_per_second(83_333), None);
    }
}
