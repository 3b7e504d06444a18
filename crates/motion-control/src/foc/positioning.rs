//! How fast to go for a distance: the position regulator, without and with the slow-down point of the velocity ramp
//! (TMCM-1640 §7.5).
//!
//! This module must never know where the position is measured.

/// What a user sets. Any numbers will do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The largest velocity in rpm, in both directions; its magnitude counts (a decision).
    pub max_velocity_rpm: i32,
    /// The acceleration with which the motor slows down, in rpm/s; its magnitude counts (a decision).
    pub acceleration_rpm_per_s: i32,
    /// Proportional gain in 1/256 rpm for a count.
    pub p: i32,
    /// Counts in a turn of the shaft; 0 acts as 1 (a decision).
    pub counts_per_turn: u32,
    /// Whether the velocity ramp is on.
    pub ramp: bool,
}

/// The errors that the proportional regulator sees.
const MAX_ERROR: i32 = 65_535;

/// Counts in a turn for which the gain is as it stands when the ramp is on.
const GAIN_COUNTS: u64 = 4096;

/// The velocity in rpm to go `distance` counts, rounded towards 0.
///
/// Without the ramp it is P · distance/256, with the distance cut at 65 535 (TMCM-1640 §7.5, figure 7.4). With the ramp it is
/// as fast as the acceleration can stop within the distance, but near the target no faster than |P · distance|/256 of an
/// encoder with 4096 counts (a decision: so hall sensors are regulated as stiffly as an encoder).
#[must_use]
pub fn velocity_rpm(distance: i32, settings: &Settings) -> i32 {
    let top = settings.max_velocity_rpm.unsigned_abs().min(i32::MAX.unsigned_abs());
    if settings.ramp {
        let magnitude = stiff_velocity(distance, settings).min(braking_velocity(distance, settings));
        magnitude.min(top.into()) as i32 * distance.signum()
    } else {
        let error = distance.clamp(-MAX_ERROR, MAX_ERROR);
        let velocity = i64::from(settings.p) * i64::from(error) / 256;
        velocity.clamp(-i64::from(top), top.into()) as i32
    }
}

/// |P · distance · 4096/N|/256, or beyond all velocities.
fn stiff_velocity(distance: i32, settings: &Settings) -> u64 {
    let product = u64::from(settings.p.unsigned_abs()) * u64::from(distance.unsigned_abs());
    product.saturating_mul(GAIN_COUNTS / 256) / u64::from(settings.counts_per_turn.max(1))
}

/// The velocity in rpm from which `distance` counts are enough to stop: √(120 · acceleration · turns).
fn braking_velocity(distance: i32, settings: &Settings) -> u64 {
    let counts_per_turn = u64::from(settings.counts_per_turn.max(1));
    let product =
        u64::from(settings.acceleration_rpm_per_s.unsigned_abs()) * u64::from(distance.unsigned_abs());
    // 120 · product may not fit, but its quotient and remainder do, or are beyond all velocities.
    let whole = (product / counts_per_turn).saturating_mul(120);
    whole.saturating_add(product % counts_per_turn * 120 / counts_per_turn).isqrt()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// As they leave the factory.
    const DEFAULTS: Settings = Settings {
        max_velocity_rpm: 4000,
        acceleration_rpm_per_s: 2000,
        p: 300,
        counts_per_turn: 4096,
        ramp: true,
    };

    #[test]
    fn far_away_is_full_speed_then_the_braking_curve_then_the_gain() {
        // From 4000 rpm at 2000 rpm/s: 2 s at 2000 rpm, 66.7 turns.
        let velocities =
            [70 * 4096, 60 * 4096, 4096, 200, 100, 1, 0].map(|distance| velocity_rpm(distance, &DEFAULTS));
        assert_eq!(velocities, [4000, 3794, 489, 108, 76, 1, 0]);
    }

    #[test]
    fn halls_are_as_stiff_as_an_encoder() {
        let halls = Settings { counts_per_turn: 24, acceleration_rpm_per_s: i32::MAX, ..DEFAULTS };
        assert_eq!(velocity_rpm(-1, &halls), -200);
        let encoder = Settings { acceleration_rpm_per_s: i32::MAX, ..DEFAULTS };
        assert_eq!(velocity_rpm(-171, &encoder), -200);
    }

    #[test]
    fn without_the_ramp_the_gain_alone_counts() {
        let plain = Settings { ramp: false, ..DEFAULTS };
        assert_eq!(
            [1000, -1000, 4000, i32::MIN].map(|distance| velocity_rpm(distance, &plain)),
            [1171, -1171, 4000, -4000]
        );
        let weak = Settings { p: 1, ..plain };
        assert_eq!([i32::MAX, i32::MIN].map(|distance| velocity_rpm(distance, &weak)), [255, -255]);
        let astray = Settings { p: -256, max_velocity_rpm: -500, ..plain };
        assert_eq!([100, 1000].map(|distance| velocity_rpm(distance, &astray)), [-100, -500]);
    }

    #[test]
    fn a_shaft_that_keeps_to_the_braking_curve_stops_at_the_target() {
        // An ideal shaft in steps of a ms: it goes as it is told.
        let mut counts = 50.0 * 4096.0;
        let (mut before, mut hardest) = (4000.0, 0.0);
        for _ in 0..5000 {
            let now = f64::from(velocity_rpm(libm::ceil(counts) as i32, &DEFAULTS));
            hardest = libm::fmax(hardest, if before < 4000.0 { before - now } else { 0.0 });
            before = now;
            counts -= now * 4096.0 / 60_000.0;
        }
        assert!(counts.abs() < 2.0, "{counts}");
        assert!(hardest <= 4.0, "2 rpm in a ms and the rounding, not {hardest}");
    }

    proptest! {
        /// The exact law, for any numbers.
        #[test]
        fn it_is_the_law(distance: i32, velocity: i32, acceleration: i32, p: i32, n: u32, ramp: bool) {
            let settings = Settings {
                max_velocity_rpm: velocity, acceleration_rpm_per_s: acceleration, p, counts_per_turn: n, ramp,
            };
            let [d, top, a, gain] = [distance, velocity, acceleration, p].map(i128::from);
            let (top, n) = (top.abs().min(i32::MAX.into()), i128::from(n.max(1)));
            let wanted = if ramp {
                let braking = (120 * a.abs() * d.abs() / n).isqrt();
                d.signum() * top.min((gain * d * 16 / n).abs()).min(braking)
            } else {
                (gain * d.clamp(-65_535, 65_535) / 256).clamp(-top, top)
            };
            prop_assert_eq!(i128::from(velocity_rpm(distance, &settings)), wanted);
        }

        /// For numbers as they are set, and both directions are alike.
        #[test]
        fn nearer_is_never_faster(
            distance in 0_i32..300_000,
            nearer in 0_i32..300_000,
            p in 0..2000,
            n in 6_u32..9000,
            ramp: bool,
        ) {
            let settings = Settings { p, counts_per_turn: n, ramp, ..DEFAULTS };
            let (far, near) = (distance.max(nearer), distance.min(nearer));
            prop_assert!(velocity_rpm(near, &settings) <= velocity_rpm(far, &settings));
            prop_assert_eq!(velocity_rpm(-far, &settings), -velocity_rpm(far, &settings));
        }
    }
}
