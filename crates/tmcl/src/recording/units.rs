//! Units: what the numbers of a curve count, and the same in another unit.
//!
//! Positions, and velocities, can all be compared once it is known how many steps a turn has: by the module's own account, at
//! the instant of the sample, for a program may change the resolution, and closed loop counts encoder steps.

use tmcl_tables::ModuleSpec;
use virtual_bench::{Probe, Quantity};

/// Units of an angle the shaft turned by; the first is drawn where several meet.
const ANGLES: [&str; 5] = ["turn", "full step", "µstep", "encoder step", "count"];

/// Units of a velocity of the shaft; likewise.
const VELOCITIES: [&str; 2] = ["rpm", "pps"];

/// Units that differ by a factor: this unit, the one it can be shown in, and the factor.
const FACTORS: [(&str, &str, f64); 5] =
    [("mA", "A", 1e-3), ("0.1 V", "V", 0.1), ("ms", "s", 1e-3), ("10 ms", "s", 1e-2), ("0.1 ms", "s", 1e-4)];

/// What a quantity is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// Always the same.
    Fixed(&'static str),
    /// Microsteps, in closed loop encoder steps.
    Steps,
}

impl Unit {
    /// Of a quantity, whose column has the unit `unit`.
    pub(super) fn of(probe: Probe, spec: Option<&ModuleSpec>, unit: &'static str) -> Self {
        let parameter = match probe.quantity {
            Quantity::Parameter(number) => spec.and_then(|spec| spec.axis_parameter(number)),
            _ => None,
        };
        match parameter {
            Some(parameter) if parameter.closed_loop_unit != parameter.unit => Self::Steps,
            _ => Self::Fixed(unit),
        }
    }

    fn is_one_of(self, family: &[&str]) -> bool {
        match self {
            Self::Fixed(unit) => family.contains(&unit),
            Self::Steps => family.contains(&ANGLES[0]),
        }
    }

    /// What to call it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Fixed("") => "a plain number",
            Self::Fixed(unit) => unit,
            Self::Steps => "steps",
        }
    }

    /// What it is shown in where units meet that differ by a factor.
    fn factor_unit(self) -> Option<&'static str> {
        let Self::Fixed(own) = self else { return None };
        FACTORS.iter().find(|(unit, shown, _)| *unit == own || *shown == own).map(|(_, shown, _)| *shown)
    }
}

/// The unit in which all of these can be shown.
pub(super) fn common(units: &[Unit]) -> Option<&'static str> {
    let (first, rest) = units.split_first()?;
    match *first {
        Unit::Fixed(unit) if rest.iter().all(|other| other == first) => return Some(unit),
        _ => {}
    }
    for family in [&ANGLES[..], &VELOCITIES[..]] {
        if units.iter().all(|unit| unit.is_one_of(family)) {
            return family.first().copied();
        }
    }
    let shown = first.factor_unit()?;
    rest.iter().all(|unit| unit.factor_unit() == Some(shown)).then_some(shown)
}

/// How many steps a turn has, at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Steps {
    /// AP 202.
    pub(super) full_steps: f64,
    /// AP 140.
    pub(super) resolution: f64,
    /// AP 210.
    pub(super) encoder_steps: f64,
    /// AP 133.
    pub(super) closed_loop: bool,
}

impl Steps {
    fn microsteps(self) -> f64 {
        self.full_steps * if self.closed_loop { 256.0 } else { self.resolution.exp2() }
    }

    /// How many of a unit make a turn, or a turn a second.
    fn in_a_turn(self, unit: &str) -> f64 {
        match unit {
            "turn" => 1.0,
            "rpm" => 60.0,
            "full step" => self.full_steps,
            "encoder step" | "count" => self.encoder_steps,
            _ => self.microsteps(),
        }
    }

    fn of(self, unit: Unit) -> f64 {
        match unit {
            Unit::Fixed(unit) => self.in_a_turn(unit),
            Unit::Steps if self.closed_loop => self.encoder_steps,
            Unit::Steps => self.microsteps(),
        }
    }
}

/// How to show numbers in another unit.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Conversion {
    /// Times a factor.
    Factor(f64),
    /// By the steps of a turn.
    Motion { from: Unit, to: String },
}

impl Conversion {
    /// From a unit to another, where there is a way.
    pub(super) fn new(from: Unit, to: &str) -> Option<Self> {
        if matches!(from, Unit::Fixed(unit) if unit == to) {
            return Some(Self::Factor(1.0));
        }
        let within = |family: &[&str]| from.is_one_of(family) && family.contains(&to);
        if within(&ANGLES) || within(&VELOCITIES) {
            return Some(Self::Motion { from, to: to.to_owned() });
        }
        let (_, _, factor) =
            FACTORS.iter().find(|(unit, shown, _)| from == Unit::Fixed(unit) && *shown == to)?;
        Some(Self::Factor(*factor))
    }

    /// A number in the other unit.
    pub(super) fn convert(&self, value: f64, steps: Steps) -> f64 {
        match self {
            Self::Factor(factor) => value * factor,
            Self::Motion { from, to } => value / steps.of(*from) * steps.in_a_turn(to),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: Steps =
        Steps { full_steps: 200.0, resolution: 4.0, encoder_steps: 4000.0, closed_loop: false };

    fn converted(value: f64, from: Unit, to: &str, steps: Steps) -> Option<f64> {
        Conversion::new(from, to).map(|conversion| conversion.convert(value, steps))
    }

    #[test]
    fn positions_and_velocities() {
        let closed = Steps { closed_loop: true, ..OPEN };
        assert_eq!(converted(3200.0, Unit::Steps, "turn", OPEN), Some(1.0));
        assert_eq!(converted(4000.0, Unit::Steps, "turn", closed), Some(1.0));
        assert_eq!(converted(51_200.0, Unit::Fixed("µstep"), "turn", closed), Some(1.0));
        assert_eq!(converted(51_200.0, Unit::Fixed("pps"), "rpm", closed), Some(60.0));
        assert_eq!(converted(0.5, Unit::Fixed("turn"), "encoder step", OPEN), Some(2000.0));
        assert_eq!(converted(1000.0, Unit::Fixed("count"), "full step", OPEN), Some(50.0));
        assert_eq!(converted(20.0, Unit::Steps, "encoder step", closed), Some(20.0));
    }

    #[test]
    fn factors_and_what_cannot_be() {
        assert_eq!(converted(480.0, Unit::Fixed("0.1 V"), "V", OPEN), Some(48.0));
        assert_eq!(converted(1.0, Unit::Fixed("Nm"), "Nm", OPEN), Some(1.0));
        for (from, to) in [("mA", "V"), ("", "A"), ("turn", "rpm"), ("Nm", ""), ("A", "mA")] {
            assert_eq!(Conversion::new(Unit::Fixed(from), to), None, "{from} in {to}");
        }
    }

    #[test]
    fn one_unit_for_all() {
        let of =
            |units: &[&'static str]| common(&units.iter().map(|unit| Unit::Fixed(unit)).collect::<Vec<_>>());
        assert_eq!(of(&["encoder step", "encoder step"]), Some("encoder step"));
        assert_eq!(of(&["µstep", "encoder step"]), Some("turn"));
        assert_eq!(of(&["pps", "rpm"]), Some("rpm"));
        assert_eq!(of(&["A", "mA"]), Some("A"));
        assert_eq!(of(&["", ""]), Some(""));
        assert_eq!(common(&[Unit::Steps]), Some("turn"), "not the same all the time");
        for apart in [&["A", "V"][..], &["turn", "rpm"], &["", "A"], &[]] {
            assert_eq!(of(apart), None, "{apart:?}");
        }
    }
}
