//! Where the energy went. Counted in whole picojoules, so that adding a thousand equal amounts one by one or at once gives
//! the same, and a bench at rest can be advanced in one go.

/// Energies since the beginning, in picojoules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Energy {
    /// Into the windings from the power stage; negative when braking feeds back.
    pub electrical_pj: i64,
    /// Heat in the windings.
    pub copper_pj: i64,
    /// Heat in bearings: Coulomb and viscous friction, and what hard stops swallow.
    pub friction_pj: i64,
    /// Against the load's torque.
    pub load_pj: i64,
}

/// Picojoules in a joule.
const PJ_PER_J: f64 = 1e12;
const J_PER_PJ: f64 = 1e-12;

impl Energy {
    /// These amounts in joules, cut to whole picojoules: a watt for an hour loses less than 0.1 mJ by it.
    #[must_use]
    pub fn from_joules(electrical_j: f64, copper_j: f64, friction_j: f64, load_j: f64) -> Self {
        let pj = |joules: f64| (joules * PJ_PER_J) as i64;
        Self {
            electrical_pj: pj(electrical_j),
            copper_pj: pj(copper_j),
            friction_pj: pj(friction_j),
            load_pj: pj(load_j),
        }
    }

    /// `times` times these amounts and what was there.
    #[must_use]
    pub fn plus(self, amount: Self, times: i64) -> Self {
        let sum = |total: i64, each: i64| total.wrapping_add(each.wrapping_mul(times));
        Self {
            electrical_pj: sum(self.electrical_pj, amount.electrical_pj),
            copper_pj: sum(self.copper_pj, amount.copper_pj),
            friction_pj: sum(self.friction_pj, amount.friction_pj),
            load_pj: sum(self.load_pj, amount.load_pj),
        }
    }
}

/// Where the energy went in a step: into the windings, as heat in them, into friction, against the load.
#[derive(Clone, Copy, Default)]
pub(crate) struct Work {
    pub(crate) electrical_j: f64,
    pub(crate) copper_j: f64,
    pub(crate) friction_j: f64,
    pub(crate) load_j: f64,
}

impl Work {
    /// Both.
    pub(crate) fn plus(self, more: Self) -> Self {
        Self {
            electrical_j: self.electrical_j + more.electrical_j,
            copper_j: self.copper_j + more.copper_j,
            friction_j: self.friction_j + more.friction_j,
            load_j: self.load_j + more.load_j,
        }
    }

    /// With what an end of travel swallows, which counts as friction.
    pub(crate) fn swallowing(self, swallowed_j: f64) -> Self {
        Self { friction_j: self.friction_j + swallowed_j, ..self }
    }

    /// The same in whole picojoules.
    pub(crate) fn energy(self) -> Energy {
        Energy::from_joules(self.electrical_j, self.copper_j, self.friction_j, self.load_j)
    }
}

/// An amount in joules.
#[must_use]
pub fn joules(picojoules: i64) -> f64 {
    picojoules as f64 * J_PER_PJ
}

/// The average power of an amount within `dt_s`.
#[must_use]
#[inline]
pub fn watts(picojoules: i64, dt_s: f64) -> f64 {
    picojoules as f64 * (J_PER_PJ / dt_s)
}
