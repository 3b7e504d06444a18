//! A rotor's angle, kept exact over any number of turns.

use core::f64::consts::{PI, TAU};

/// Whole electrical periods and the rest, so that a motor that turns for days loses no precision.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorAngle {
    periods: i64,
    electrical_rad: f64,
}

impl RotorAngle {
    /// The electrical angle, from −π to π.
    #[must_use]
    pub fn electrical_rad(self) -> f64 {
        self.electrical_rad
    }

    /// Mechanical turns since 0, for a motor of `pole_pairs`.
    #[must_use]
    pub fn turns(self, pole_pairs: f64) -> f64 {
        (self.periods as f64 + self.electrical_rad * (1.0 / TAU)) / pole_pairs
    }

    /// The angle at so many mechanical turns.
    #[must_use]
    pub fn from_turns(turns: f64, pole_pairs: f64) -> Self {
        Self::default().advanced_to(turns * pole_pairs * TAU)
    }

    /// The angle whose electrical part, not yet brought back to one period, is `electrical_rad`.
    #[must_use]
    pub fn advanced_to(self, electrical_rad: f64) -> Self {
        if (-PI..=PI).contains(&electrical_rad) {
            return Self { electrical_rad, ..self };
        }
        let whole = libm::round(electrical_rad / TAU);
        Self { periods: self.periods + whole as i64, electrical_rad: electrical_rad - whole * TAU }
    }
}

/// A direction: sine and cosine of an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Direction {
    pub(crate) sine: f64,
    pub(crate) cosine: f64,
}

impl Direction {
    /// The direction of an angle.
    pub(crate) fn of(angle_rad: f64) -> Self {
        let (sine, cosine) = libm::sincos(angle_rad);
        Self { sine, cosine }
    }

    /// The direction `by_rad` further on. Small turns, as within a step, go by a power series whose error is below the last
    /// bit: an integrator asks four times a step, and a whole sine costs more than all the rest of it.
    #[inline]
    pub(crate) fn turned(self, by_rad: f64) -> Self {
        if by_rad == 0.0 {
            return self;
        }
        let turn = if libm::fabs(by_rad) < 0.5 { small(by_rad) } else { Self::of(by_rad) };
        Self {
            sine: self.sine * turn.cosine + self.cosine * turn.sine,
            cosine: self.cosine * turn.cosine - self.sine * turn.sine,
        }
    }
}

/// Taylor's series, as long as the angle needs it for an error below 3e-16: to the eighth and ninth power up to an eighth of a
/// radian, else to the twelfth and thirteenth for half a radian. Cut in the middle, for the halves do not wait for each other.
#[inline]
fn small(angle_rad: f64) -> Direction {
    let square = angle_rad * angle_rad;
    let fourth = square * square;
    let mut cosine =
        (-1.0 / 2.0 + square * (1.0 / 24.0)) + fourth * (-1.0 / 720.0 + square * (1.0 / 40_320.0));
    let mut sine =
        (-1.0 / 6.0 + square * (1.0 / 120.0)) + fourth * (-1.0 / 5_040.0 + square * (1.0 / 362_880.0));
    if square > SHORT_SERIES_RAD * SHORT_SERIES_RAD {
        let eighth = fourth * fourth;
        cosine += eighth * (-1.0 / 3_628_800.0 + square * (1.0 / 479_001_600.0));
        sine += eighth * (-1.0 / 39_916_800.0 + square * (1.0 / 6_227_020_800.0));
    }
    Direction { sine: angle_rad + angle_rad * square * sine, cosine: 1.0 + square * cosine }
}

/// Up to which angle the short series does.
const SHORT_SERIES_RAD: f64 = 0.125;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_turn_is_as_exact_as_a_whole_sine() {
        for step in -400..400 {
            let by_rad = f64::from(step) * 0.003;
            let (turned, direct) = (Direction::of(1.0).turned(by_rad), Direction::of(1.0 + by_rad));
            assert!((turned.sine - direct.sine).abs() < 4e-16 * 4.0, "sine at {by_rad}");
            assert!((turned.cosine - direct.cosine).abs() < 4e-16 * 4.0, "cosine at {by_rad}");
        }
    }

    #[test]
    fn turns_come_back_over_many_periods() {
        for turns in [0.0, 0.123, -7.5, 123_456.789] {
            assert!((RotorAngle::from_turns(turns, 50.0).turns(50.0) - turns).abs() < 1e-9);
        }
        let angle = RotorAngle::default().advanced_to(3.0 * TAU + 0.1);
        assert!((angle.electrical_rad() - 0.1).abs() < 1e-12);
    }
}
