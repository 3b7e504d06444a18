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
        (self.periods as f64 + self.electrical_rad / TAU) / pole_pairs
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_come_back_over_many_periods() {
        for turns in [0.0, 0.123, -7.5, 123_456.789] {
            assert!((RotorAngle::from_turns(turns, 50.0).turns(50.0) - turns).abs() < 1e-9);
        }
        let angle = RotorAngle::default().advanced_to(3.0 * TAU + 0.1);
        assert!((angle.electrical_rad() - 0.1).abs() < 1e-12);
    }
}
