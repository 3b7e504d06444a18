//! What the load asks of the motor: a torque, over position or over time.
//!
//! Positive torque drives the shaft to the right; a load that hangs on it and pulls it back is negative.

/// Points of a profile at most.
pub const MAX_POINTS: usize = 32;

/// A torque profile: points joined by straight lines, the end values beyond them, or the same again every `period`.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    points: [(f64, f64); MAX_POINTS],
    length: usize,
    period: Option<f64>,
}

impl Profile {
    /// A profile of `(x, torque)` points with ascending `x`; `None` when there are none, too many, or they do not ascend.
    #[must_use]
    pub fn new(points: &[(f64, f64)], period: Option<f64>) -> Option<Self> {
        let mut kept = [(0.0, 0.0); MAX_POINTS];
        kept.get_mut(..points.len())?.copy_from_slice(points);
        let ascending = points.windows(2).all(|pair| matches!(pair, [(a, _), (b, _)] if a < b));
        let positive = period.is_none_or(|period| period > 0.0);
        (ascending && positive && !points.is_empty()).then_some(Self {
            points: kept,
            length: points.len(),
            period,
        })
    }

    /// The torque at `x`.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        let x = self.period.map_or(x, |period| x - libm::floor(x / period) * period);
        let points = self.points.get(..self.length).unwrap_or(&[]);
        let right = points.partition_point(|&(at, _)| at <= x);
        let left = right.checked_sub(1).and_then(|index| points.get(index));
        match (left, points.get(right)) {
            (Some(&(x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
            (Some(&(_, y)), None) | (None, Some(&(_, y))) => y,
            (None, None) => 0.0,
        }
    }
}

/// The torque that the outside puts on the shaft.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadTorque {
    /// Always the same.
    Constant(f64),
    /// By the shaft's position in turns: a cam, a spring, a weight on a lever.
    ByPosition(Profile),
    /// By time in seconds.
    ByTime(Profile),
}

impl LoadTorque {
    /// The torque in Nm with the shaft at `turns`, `time_s` after power-on.
    #[must_use]
    pub fn at(&self, turns: f64, time_s: f64) -> f64 {
        match self {
            Self::Constant(torque_nm) => *torque_nm,
            Self::ByPosition(profile) => profile.at(turns),
            Self::ByTime(profile) => profile.at(time_s),
        }
    }

    /// Whether it may change while the shaft stands.
    #[must_use]
    pub fn changes_with_time(&self) -> bool {
        matches!(self, Self::ByTime(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_lines_between_points_and_constant_outside() {
        let profile = Profile::new(&[(0.0, 0.0), (1.0, 0.5), (2.0, -0.5)], None).expect("a profile");
        for (x, expected) in [(-1.0, 0.0), (0.5, 0.25), (1.0, 0.5), (1.5, 0.0), (9.0, -0.5)] {
            assert!((profile.at(x) - expected).abs() < 1e-12, "at {x}");
        }
    }

    #[test]
    fn a_periodic_profile_repeats_both_ways() {
        let profile = Profile::new(&[(0.0, 0.0), (1.0, 1.0)], Some(1.0)).expect("a profile");
        assert!((profile.at(7.25) - 0.25).abs() < 1e-12);
        assert!((profile.at(-0.75) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn points_must_ascend() {
        assert_eq!(Profile::new(&[(1.0, 0.0), (1.0, 1.0)], None), None);
        assert_eq!(Profile::new(&[], None), None);
        assert_eq!(Profile::new(&[(0.0, 0.0); 33], None), None);
    }
}
