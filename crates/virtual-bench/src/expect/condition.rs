//! Conditions on quantities, and what the values were.

use super::show;
use crate::bench::Bench;
use crate::probe::Probe;

/// Something that is or is not the case.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Condition {
    /// All of these hold.
    Comparisons(Vec<Comparison>),
    /// A quantity differs from what it was a control period before.
    Edge(Operand, Edge),
}

/// Which way it differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Edge {
    Rises,
    Falls,
    Changes,
}

impl Edge {
    /// Whether a quantity that was `before` and is `now` did this.
    pub(super) fn is_met(self, before: f64, now: f64) -> bool {
        match self {
            Self::Rises => now > before,
            Self::Falls => now < before,
            Self::Changes => now != before,
        }
    }

    /// "it never …"
    pub(super) fn past(self) -> &'static str {
        match self {
            Self::Rises => "rose",
            Self::Falls => "fell",
            Self::Changes => "changed",
        }
    }
}

/// A quantity, or some of its bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Operand {
    /// As it was asked for.
    pub(super) name: String,
    pub(super) probe: Probe,
    pub(super) mask: Option<u32>,
}

impl Operand {
    pub(super) fn read(&self, bench: &Bench) -> f64 {
        let value = bench.read(self.probe);
        match self.mask {
            None => value,
            Some(mask) => (value as i64 & i64::from(mask)) as f64,
        }
    }

    /// The name, with its mask.
    pub(super) fn shown(&self) -> String {
        self.mask.map_or_else(|| self.name.clone(), |mask| format!("{} & {mask:#x}", self.name))
    }

    /// A value of it; bits in hexadecimal.
    pub(super) fn shown_value(&self, value: f64) -> String {
        self.mask.map_or_else(|| show::number(value), |_| format!("{:#x}", value as i64))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    Equal,
    NotEqual,
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// What a quantity is compared with.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Reference {
    Number(f64),
    Operand(Operand),
}

/// A quantity against a number or another quantity.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Comparison {
    pub(super) left: Operand,
    pub(super) relation: Relation,
    pub(super) right: Reference,
    /// How far values that count as equal may be apart.
    pub(super) tolerance: f64,
}

/// Both sides of a comparison at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sides {
    pub(super) left: f64,
    right: f64,
}

impl Comparison {
    pub(super) fn sides(&self, bench: &Bench) -> Sides {
        let right = match &self.right {
            Reference::Number(value) => *value,
            Reference::Operand(operand) => operand.read(bench),
        };
        Sides { left: self.left.read(bench), right }
    }

    pub(super) fn holds(&self, Sides { left, right }: Sides) -> bool {
        let equal = (left - right).abs() <= self.tolerance;
        match self.relation {
            Relation::Equal => equal,
            Relation::NotEqual => !equal,
            Relation::Less => left < right,
            Relation::AtMost => left <= right,
            Relation::Greater => left > right,
            Relation::AtLeast => left >= right,
        }
    }

    /// How far values for which it does not hold are from where it would; None where one is no nearer than another.
    pub(super) fn distance(&self, Sides { left, right }: Sides) -> Option<f64> {
        (self.left.mask.is_none() && self.relation != Relation::NotEqual).then(|| (left - right).abs())
    }

    /// "actual_position was 9987"
    pub(super) fn described(&self, sides: Sides) -> String {
        let left = format!("{} was {}", self.left.shown(), self.left.shown_value(sides.left));
        match &self.right {
            Reference::Number(_) => left,
            Reference::Operand(right) => {
                format!("{left} and {} {}", right.shown(), right.shown_value(sides.right))
            }
        }
    }

    /// "9987", or "9987 against 9990" where both sides can change.
    pub(super) fn values(&self, sides: Sides) -> String {
        let left = self.left.shown_value(sides.left);
        match &self.right {
            Reference::Number(_) => left,
            Reference::Operand(right) => format!("{left} against {}", right.shown_value(sides.right)),
        }
    }
}

impl Condition {
    /// Whether what it looks at changes while everything is at rest.
    pub(super) fn changes_at_rest(&self) -> bool {
        let operand = |operand: &Operand| operand.probe.quantity.changes_at_rest();
        match self {
            Self::Edge(changed, _) => operand(changed),
            Self::Comparisons(comparisons) => comparisons.iter().any(|comparison| {
                operand(&comparison.left)
                    || matches!(&comparison.right, Reference::Operand(right) if operand(right))
            }),
        }
    }
}

/// The comparisons that do not hold, with their values; all of them where all hold.
pub(super) fn described(comparisons: &[Comparison], bench: &Bench) -> String {
    let wrong = comparisons.iter().filter(|comparison| !comparison.holds(comparison.sides(bench)));
    let mut parts: Vec<_> = wrong.map(|comparison| comparison.described(comparison.sides(bench))).collect();
    if parts.is_empty() {
        let all = comparisons.iter().map(|comparison| comparison.described(comparison.sides(bench)));
        parts = all.collect();
    }
    parts.join(", ")
}
