//! What a program waits for (TMCM-1311 §5.7.22).

/// Events that WAIT knows besides the passing of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WaitEvent {
    /// POS: the target position is reached.
    PositionReached,
    /// REFSW: the reference switch is active.
    ReferenceSwitch,
    /// LIMSW: a limit switch is active.
    LimitSwitch,
    /// RFS: no reference search runs.
    ReferenceSearch,
}

/// A WAIT that has not ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Wait {
    /// The event; None for TICKS.
    pub(crate) event: Option<WaitEvent>,
    /// When it ends of itself.
    pub(crate) deadline: Option<u64>,
}

impl Wait {
    /// The same wait with its deadline counted from `now` instead of from 0, or the other way round.
    pub(crate) fn map_deadline(self, change: impl FnOnce(u64) -> u64) -> Self {
        Self { deadline: self.deadline.map(change), ..self }
    }
}
