//! Units: what the numbers of a curve count, and the same in another unit.
//!
//! Positions, and velocities, can all be compared once it is known how many steps a turn has: by the module's own account, at
//! the instant of the sample, for a program may change the resolution, and closed loop counts encoder steps, as a brushless
//! motor's module does or not by what commutates.

use tmcl_tables::ModuleSpec;
use virtual_bench::{ModuleKind, Probe, Quantity};

/// Units of an angle the shaft turned by; the first is drawn where several meet.
const ANGLES: [&str; 5] = ["turn", "full step", "µstep", "encoder step", "count"];

/// Units of a velocity of the shaft; likewise.
const VELOCITIES: [&str; 2] = ["rpm", "pps"];

/// Units that only steppers have.
const OF_STEPPERS: [&str; 3] = ["full step", "µstep", "pps"];

/// Units that differ by a factor: this unit, the one it can be shown in, and the factor.
const FACTORS: [(&str, &str, f64); 5] =
    [("mA", "A", 1e-3), ("0.1 V", "V", 0.1), ("ms", "s", 1e-3), ("10 ms", "s", 1e-2), ("0.1 ms", "s", 1e-4)];

/// What a quantity is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// Always the same.
    Fixed(&'static str),
    /// What the module counts positions in: microsteps, in closed loop encoder steps; a brushless motor's encoder steps or hall
    /// sectors.
    Steps,
}

impl Unit {
    /// Of a quantity, whose column has the unit `unit`.
    pub(super) fn of(probe: Probe, spec: Option<&'static ModuleSpec>, unit: &'static str) -> Self {
        let parameter = match probe.quantity {
            Quantity::Parameter(number) => spec.and_then(|spec| spec.axis_parameter(number)),
            _ => None,
        };
        let brushless = Counting::of(spec) == Counting::Brushless;
        match parameter {
            Some(parameter) if parameter.closed_loop_unit != parameter.unit => Self::Steps,
            Some(parameter) if brushless && parameter.unit == "count" => Self::Steps,
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

/// How a module counts the turns of its motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counting {
    /// In microsteps and encoder steps.
    Stepper,
    /// In encoder steps or hall sectors.
    Brushless,
    /// Not at all: it follows pulses.
    None,
}

impl Counting {
    /// Of a module.
    pub(super) fn of(spec: Option<&'static ModuleSpec>) -> Self {
        match spec.map(ModuleKind::try_from) {
            Some(Ok(ModuleKind::Tmcm1640)) => Self::Brushless,
            Some(Ok(ModuleKind::Tmcm1076)) => Self::None,
            Some(Ok(ModuleKind::Tmcm1311) | Err(_)) | None => Self::Stepper,
        }
    }

    /// The columns that say how many steps a turn has.
    pub(super) const fn columns(self) -> &'static [&'static str] {
        match self {
            // AP 202, 140, 210 and 133.
            Self::Stepper => {
                &["motor_full_steps", "microstep_resolution", "encoder_resolution", "closed_loop_initialized"]
            }
            // AP 250, 253 and 159.
            Self::Brushless => &["encoder_resolution", "motor_poles", "commutation_mode"],
            Self::None => &[],
        }
    }

    /// How many steps a turn has where the columns read this.
    pub(super) fn steps(self, values: &[f64]) -> Steps {
        match (self, values) {
            (Self::Stepper, &[full_steps, resolution, encoder_steps, closed_loop]) => {
                let closed_loop = closed_loop != 0.0;
                let microsteps = full_steps * if closed_loop { 256.0 } else { resolution.exp2() };
                let position_steps = if closed_loop { encoder_steps } else { microsteps };
                Steps { full_steps, microsteps, encoder_steps, position_steps }
            }
            (Self::Brushless, &[encoder_steps, poles, commutation]) => {
                let position_steps =
                    if commutation == BY_ENCODER { encoder_steps } else { SECTORS_A_POLE * poles };
                Steps { encoder_steps, position_steps, ..Steps::default() }
            }
            _ => Steps::default(),
        }
    }

    /// Whether its motor turns in such units.
    pub(super) fn knows(self, unit: &str) -> bool {
        match self {
            Self::Stepper => true,
            Self::Brushless => !OF_STEPPERS.contains(&unit),
            Self::None => {
                ["turn", "rpm"].contains(&unit) || !(ANGLES.contains(&unit) || VELOCITIES.contains(&unit))
            }
        }
    }
}

/// AP 159 of the TMCM-1640 where the encoder commutates.
const BY_ENCODER: f64 = 7.0;

/// Hall sectors for each pole of a turn: six to a pair.
const SECTORS_A_POLE: f64 = 3.0;

/// How many steps a turn has, at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Steps {
    full_steps: f64,
    microsteps: f64,
    encoder_steps: f64,
    /// Of what positions are counted in.
    position_steps: f64,
}

impl Steps {
    /// How many of a unit make a turn, or a turn a second.
    fn in_a_turn(self, unit: &str) -> f64 {
        match unit {
            "turn" => 1.0,
            "rpm" => 60.0,
            "full step" => self.full_steps,
            "encoder step" | "count" => self.encoder_steps,
            _ => self.microsteps,
        }
    }

    fn of(self, unit: Unit) -> f64 {
        match unit {
            Unit::Fixed(unit) => self.in_a_turn(unit),
            Unit::Steps => self.position_steps,
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

    fn stepper(closed_loop: f64) -> Steps {
        Counting::Stepper.steps(&[200.0, 4.0, 4000.0, closed_loop])
    }

    fn converted(value: f64, from: Unit, to: &str, steps: Steps) -> Option<f64> {
        Conversion::new(from, to).map(|conversion| conversion.convert(value, steps))
    }

    #[test]
    fn positions_and_velocities() {
        let (open, closed) = (stepper(0.0), stepper(1.0));
        assert_eq!(converted(3200.0, Unit::Steps, "turn", open), Some(1.0));
        assert_eq!(converted(4000.0, Unit::Steps, "turn", closed), Some(1.0));
        assert_eq!(converted(51_200.0, Unit::Fixed("µstep"), "turn", closed), Some(1.0));
        assert_eq!(converted(51_200.0, Unit::Fixed("pps"), "rpm", closed), Some(60.0));
        assert_eq!(converted(0.5, Unit::Fixed("turn"), "encoder step", open), Some(2000.0));
        assert_eq!(converted(1000.0, Unit::Fixed("count"), "full step", open), Some(50.0));
        assert_eq!(converted(20.0, Unit::Steps, "encoder step", closed), Some(20.0));
    }

    #[test]
    fn a_brushless_motors_positions_are_by_what_commutates() {
        let [halls, encoder] = [6.0, 7.0].map(|mode| Counting::Brushless.steps(&[4096.0, 8.0, mode]));
        assert_eq!(converted(24.0, Unit::Steps, "turn", halls), Some(1.0));
        assert_eq!(converted(4096.0, Unit::Steps, "turn", encoder), Some(1.0));
        assert_eq!(converted(4096.0, Unit::Fixed("encoder step"), "turn", halls), Some(1.0));
        assert_eq!(converted(6.0, Unit::Steps, "count", halls), Some(1024.0));
        for unit in ["turn", "count", "encoder step", "rpm", "A"] {
            assert!(Counting::Brushless.knows(unit), "{unit}");
        }
        for unit in ["turn", "rpm", "A", "Nm", "pulse"] {
            assert!(Counting::None.knows(unit), "{unit}");
        }
        for unit in ["pps", "count", "full step"] {
            assert!(!Counting::None.knows(unit), "{unit}");
        }
        for unit in OF_STEPPERS {
            assert!(!Counting::Brushless.knows(unit) && Counting::Stepper.knows(unit), "{unit}");
        }
    }

    #[test]
    fn factors_and_what_cannot_be() {
        let open = stepper(0.0);
        assert_eq!(converted(480.0, Unit::Fixed("0.1 V"), "V", open), Some(48.0));
        assert_eq!(converted(1.0, Unit::Fixed("Nm"), "Nm", open), Some(1.0));
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
