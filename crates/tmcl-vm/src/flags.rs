//! The error flags that JC tests and CLE clears (TMCM-1311 §5.7.18, §5.7.31; numbers 9 to 12 and 4, 5 as in sibling manuals).

/// An error that a program can ask for. It stays set until CLE clears it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorFlag {
    /// ETO: a WAIT timed out.
    Timeout,
    /// EAL: an external alarm.
    ExternalAlarm,
    /// EDV: the motor was stopped because the encoder deviates.
    Deviation,
    /// EPO: a position error.
    Position,
    /// ESD: the motor was stopped because it stalled.
    Shutdown,
}

impl ErrorFlag {
    /// The flag that condition `kind` of JC tests.
    pub(crate) fn from_condition(kind: u8) -> Option<Self> {
        Self::from_index(kind.checked_sub(8)?)
    }

    /// The flag that CLE with type `kind` clears; 0 clears all.
    pub(crate) fn from_cle(kind: u8) -> Option<Self> {
        Self::from_index(kind.checked_sub(1)?)
    }

    fn from_index(index: u8) -> Option<Self> {
        Some(match index {
            0 => Self::Timeout,
            1 => Self::ExternalAlarm,
            2 => Self::Deviation,
            3 => Self::Position,
            4 => Self::Shutdown,
            _ => return None,
        })
    }

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// The error flags that are set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ErrorFlags(u8);

impl ErrorFlags {
    pub(crate) fn set(&mut self, flag: ErrorFlag) {
        self.0 |= flag.bit();
    }

    pub(crate) fn clear(&mut self, flag: ErrorFlag) {
        self.0 &= !flag.bit();
    }

    pub(crate) fn clear_all(&mut self) {
        self.0 = 0;
    }

    pub(crate) fn contains(self, flag: ErrorFlag) -> bool {
        self.0 & flag.bit() != 0
    }
}
