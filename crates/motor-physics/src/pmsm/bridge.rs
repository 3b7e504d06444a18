//! What the power stage does to the phases, down to the diodes of a stage that is switched off.

use super::frame::{AXES, vector_of};

/// A power stage for the time of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bridge {
    /// A voltage vector is held across the phases.
    Driven {
        /// The vector in the stationary frame, as long as the phase voltage's amplitude; α along phase U.
        voltage_alpha_beta_v: [f64; 2],
    },
    /// The same, but that the wire to one phase is off: the other two carry one current.
    DrivenOpen {
        /// Which: 0 to 2 for U to W.
        open_phase: usize,
        /// The vector that the power stage makes; only what lies across the open phase's axis acts.
        voltage_alpha_beta_v: [f64; 2],
    },
    /// All transistors are off. What current is left flows through the diodes against the bus voltage, and so does current
    /// of a rotor that is turned so fast that its voltage exceeds the bus's.
    Floating {
        /// The bus voltage.
        bus_voltage_v: f64,
    },
}

impl Bridge {
    /// A power stage that holds the terminals of U, V and W at these voltages against ground.
    #[must_use]
    pub fn at_terminals(terminals_v: [f64; 3]) -> Self {
        Self::Driven { voltage_alpha_beta_v: vector_of(terminals_v) }
    }

    /// The same with the wire to a phase off, 0 to 2 for U to W. A stage that is off stays as it is: its diodes are taken to
    /// reach all three phases.
    #[must_use]
    pub fn with_open(self, open_phase: usize) -> Self {
        match self {
            Self::Driven { voltage_alpha_beta_v } | Self::DrivenOpen { voltage_alpha_beta_v, .. } => {
                Self::DrivenOpen { open_phase, voltage_alpha_beta_v }
            }
            Self::Floating { .. } => self,
        }
    }
}

/// How the phases are connected until a diode begins or ceases to conduct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Connection {
    /// All three phases carry what this voltage vector drives.
    Closed([f64; 2]),
    /// The phase carries nothing; the other two see this voltage vector, which has no part along the phase's axis.
    OpenPhase(usize, [f64; 2]),
    /// No phase carries anything.
    Open,
}

/// Which diodes conduct: each phase's terminal is at the upper rail (1), at the lower (−1), or free (0).
pub(super) type Rails = [i8; 3];

/// The connection that these diodes make.
pub(super) fn connection(rails: Rails, bus_voltage_v: f64) -> Connection {
    let voltage = vector_of(rails.map(|rail| 0.5 * bus_voltage_v * f64::from(rail)));
    let mut free = rails.iter().enumerate().filter(|(_, rail)| **rail == 0);
    match (free.next(), free.next()) {
        (None, _) => Connection::Closed(voltage),
        (Some((phase, _)), None) => Connection::OpenPhase(phase, voltage),
        _ => Connection::Open,
    }
}

/// A phase's axis.
pub(super) fn axis(phase: usize) -> [f64; 2] {
    AXES.get(phase).copied().unwrap_or_default()
}
