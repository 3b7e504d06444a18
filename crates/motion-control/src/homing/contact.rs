//! When a contact that may bounce is steady.

/// How long a contact must keep its level to be taken for steady, in control periods: 2 ms.
pub(super) const STEADY_TICKS: u16 = 40;

/// A level, and for how many control periods it has been that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) active: bool,
    pub(super) ticks: u16,
}

impl Run {
    pub(super) fn see(&mut self, active: bool) {
        let ticks = if active == self.active { self.ticks.saturating_add(1) } else { 1 };
        *self = Self { active, ticks };
    }

    pub(super) fn is_steady(self, active: bool) -> bool {
        self.active == active && self.ticks >= STEADY_TICKS
    }
}
