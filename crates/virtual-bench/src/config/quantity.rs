//! What physical quantities may be.
//!
//! The bounds are far outside what such modules meet; they keep out slips of unit and figures that no physics can bear
//! (zero inertia, a short-circuited winding, infinity).

use core::ops::RangeInclusive;

/// A quantity: its unit and the values it may take.
#[derive(Clone, Debug)]
pub(super) struct Quantity {
    unit: &'static str,
    allowed: RangeInclusive<f64>,
}

impl Quantity {
    const fn new(unit: &'static str, allowed: RangeInclusive<f64>) -> Self {
        Self { unit, allowed }
    }

    /// The value if it is allowed, else what is.
    pub(super) fn check(&self, name: &str, value: f64) -> Result<f64, String> {
        // NaN is in no range.
        if self.allowed.contains(&value) {
            return Ok(value);
        }
        let (low, high) = (plain(*self.allowed.start()), plain(*self.allowed.end()));
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        Err(format!("{name} must be from {low} to {high}{unit}, not {}", plain(value)))
    }
}

/// A number as people write it.
fn plain(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && magnitude.is_finite() && !(1e-3..1e9).contains(&magnitude) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

pub(super) const VOLTAGE: Quantity = Quantity::new("V", 0.0..=100.0);
pub(super) const SOURCE_RESISTANCE: Quantity = Quantity::new("ohm", 0.001..=100.0);
pub(super) const CAPACITANCE: Quantity = Quantity::new("F", 1e-6..=1.0);
pub(super) const TEMPERATURE: Quantity = Quantity::new("°C", -55.0..=150.0);

pub(super) const CURRENT: Quantity = Quantity::new("A", 0.01..=100.0);
pub(super) const WINDING_RESISTANCE: Quantity = Quantity::new("ohm", 0.01..=1000.0);
pub(super) const INDUCTANCE: Quantity = Quantity::new("H", 1e-5..=1.0);
pub(super) const HOLDING_TORQUE: Quantity = Quantity::new("Nm", 0.001..=100.0);
pub(super) const DETENT_TORQUE: Quantity = Quantity::new("Nm", 0.0..=100.0);
pub(super) const ROTOR_INERTIA: Quantity = Quantity::new("kgm²", 1e-8..=1.0);
pub(super) const TORQUE_CONSTANT: Quantity = Quantity::new("Nm/A", 1e-4..=10.0);

pub(super) const TIME_CONSTANT: Quantity = Quantity::new("s", 1.0..=1e6);

pub(super) const LOAD_INERTIA: Quantity = Quantity::new("kgm²", 0.0..=10.0);
pub(super) const FRICTION: Quantity = Quantity::new("Nm", 0.0..=100.0);
pub(super) const VISCOUS: Quantity = Quantity::new("Nm·s/rad", 0.0..=1.0);
pub(super) const TORQUE: Quantity = Quantity::new("Nm", -100.0..=100.0);
pub(super) const RESTITUTION: Quantity = Quantity::new("", 0.0..=1.0);

pub(super) const TURNS: Quantity = Quantity::new("turns", -1e6..=1e6);
pub(super) const TURNS_FROM_START: Quantity = Quantity::new("turns", 0.0..=1e6);
pub(super) const TURNS_TO_START: Quantity = Quantity::new("turns", -1e6..=0.0);
pub(super) const WIDTH: Quantity = Quantity::new("turns", 1e-4..=1e6);
pub(super) const ELECTRICAL_ANGLE: Quantity = Quantity::new("°", -360.0..=360.0);
/// Either direction.
pub(super) const PULSE_FREQUENCY: Quantity = Quantity::new("Hz", -1e6..=1e6);
pub(super) const PULSE_ACCELERATION: Quantity = Quantity::new("Hz/s", 0.0..=1e9);
/// Turns or seconds.
pub(super) const PROFILE_X: Quantity = Quantity::new("", -1e6..=1e6);
pub(super) const PERIOD: Quantity = Quantity::new("", 1e-4..=1e6);
/// In seconds: 115 days, which nanoseconds in an `f64` still resolve.
pub(super) const INSTANT: Quantity = Quantity::new("s", 0.0..=1e7);
pub(super) const BOUNCE: Quantity = Quantity::new("ms", 0.0..=1000.0);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_inclusive_and_named() {
        assert_eq!(CAPACITANCE.check("capacitance_f", 1e-6), Ok(1e-6));
        assert_eq!(
            CAPACITANCE.check("capacitance_f", 2200.0),
            Err("capacitance_f must be from 1e-6 to 1 F, not 2200".to_owned())
        );
        assert_eq!(
            RESTITUTION.check("restitution", -0.0001),
            Err("restitution must be from 0 to 1, not -1e-4".to_owned())
        );
    }

    #[test]
    fn nothing_but_finite_numbers_is_a_quantity() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(TORQUE.check("torque_nm", value).is_err());
        }
    }
}
