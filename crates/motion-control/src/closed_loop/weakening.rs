//! Field weakening: at high speed the field may be more than 90° ahead, against back EMF and delays (TMCM-1311 §8.9).

/// Another 90°, in µsteps, and what the torque block adds at most.
pub const LARGEST: i32 = 255;

/// How much further than 90° the field may be ahead at this speed, 0 to 255 µsteps: nothing below the first corner velocity,
/// all of it from the second on, linear between. Corners that are no interval make a step at the first one.
#[must_use]
pub fn gamma(speed_pps: u32, from_pps: u32, to_pps: u32) -> i32 {
    let above_pps = speed_pps.saturating_sub(from_pps);
    if above_pps == 0 {
        return 0;
    }
    let width_pps = to_pps.saturating_sub(from_pps);
    if above_pps >= width_pps {
        return LARGEST;
    }
    let gamma = u64::from(above_pps) * LARGEST.unsigned_abs() as u64 / u64::from(width_pps);
    i32::try_from(gamma).unwrap_or(LARGEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rises_between_the_corners() {
        let gamma = |speed_pps| gamma(speed_pps, 300_000, 600_000);
        assert_eq!(
            [0, 300_000, 300_001, 450_000, 599_999, 600_000, u32::MAX].map(gamma),
            [0, 0, 0, 127, 254, 255, 255]
        );
    }

    #[test]
    fn corners_that_are_no_interval_make_a_step() {
        assert_eq!([99, 100, 101].map(|speed_pps| gamma(speed_pps, 100, 100)), [0, 0, 255]);
        assert_eq!([99, 100, 101].map(|speed_pps| gamma(speed_pps, 100, 50)), [0, 0, 255]);
    }
}
