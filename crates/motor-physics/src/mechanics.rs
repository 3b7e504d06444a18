//! What turns: inertia, friction, and the ends of travel.
//!
//! Coulomb friction changes its sign where the shaft turns round, which no integrator likes. So its direction is chosen first
//! ([`Mechanics::friction`]), and a step ends where the shaft would turn round ([`Friction::would_drive`]). There it stops,
//! and only starts again when the torque on it exceeds the friction: it sticks, as real shafts do, and does not creep.

/// The ends of travel, and how much of its speed a shaft keeps when it bounces off them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HardStops {
    /// Where travel ends to the left.
    pub low_turns: f64,
    /// Where travel ends to the right.
    pub high_turns: f64,
    /// Speed after over speed before a bounce, 0 to 1.
    pub restitution: f64,
}

/// Everything rigidly coupled to the rotor, the rotor's own inertia included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mechanics {
    /// Moment of inertia of rotor and load.
    pub inertia_kgm2: f64,
    /// Coulomb friction.
    pub friction_nm: f64,
    /// Viscous friction.
    pub viscous_nm_s_per_rad: f64,
    /// Ends of travel, where there are any.
    pub hard_stops: Option<HardStops>,
}

/// What Coulomb friction does during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Friction {
    /// The shaft stands, and the torque on it does not overcome the friction.
    Sticks,
    /// This much torque acts, against the motion.
    Acts(f64),
}

impl Friction {
    /// Whether a shaft at this velocity has turned round since the friction was chosen: it would drive it on.
    #[must_use]
    pub fn would_drive(self, velocity_rad_s: f64) -> bool {
        match self {
            Self::Sticks => false,
            Self::Acts(friction_nm) => friction_nm * velocity_rad_s > 0.0,
        }
    }
}

impl Mechanics {
    /// What Coulomb friction does to a shaft that moves at `velocity_rad_s` while `torque_nm` acts on it.
    #[must_use]
    pub fn friction(&self, velocity_rad_s: f64, torque_nm: f64) -> Friction {
        if velocity_rad_s != 0.0 {
            Friction::Acts(-libm::copysign(self.friction_nm, velocity_rad_s))
        } else if libm::fabs(torque_nm) <= self.friction_nm {
            Friction::Sticks
        } else {
            Friction::Acts(-libm::copysign(self.friction_nm, torque_nm))
        }
    }

    /// Angular acceleration under `torque_nm`; viscous friction is added here.
    #[must_use]
    pub fn acceleration(&self, velocity_rad_s: f64, torque_nm: f64, friction: Friction) -> f64 {
        match friction {
            Friction::Sticks => 0.0,
            Friction::Acts(friction_nm) => {
                (torque_nm + friction_nm - self.viscous_nm_s_per_rad * velocity_rad_s) / self.inertia_kgm2
            }
        }
    }

    /// Where a shaft is and how fast it moves once the ends of travel have had their say.
    #[must_use]
    pub fn within_travel(&self, turns: f64, velocity_rad_s: f64) -> (f64, f64) {
        let Some(stops) = self.hard_stops else { return (turns, velocity_rad_s) };
        let bounced = -stops.restitution * velocity_rad_s;
        if turns > stops.high_turns {
            (stops.high_turns, if velocity_rad_s > 0.0 { bounced } else { velocity_rad_s })
        } else if turns < stops.low_turns {
            (stops.low_turns, if velocity_rad_s < 0.0 { bounced } else { velocity_rad_s })
        } else {
            (turns, velocity_rad_s)
        }
    }

    /// Kinetic energy at a velocity.
    #[must_use]
    pub fn kinetic_j(&self, velocity_rad_s: f64) -> f64 {
        0.5 * self.inertia_kgm2 * velocity_rad_s * velocity_rad_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAFT: Mechanics =
        Mechanics { inertia_kgm2: 1e-5, friction_nm: 0.02, viscous_nm_s_per_rad: 0.0, hard_stops: None };

    #[test]
    fn friction_holds_what_does_not_overcome_it() {
        assert_eq!(SHAFT.friction(0.0, 0.02), Friction::Sticks);
        assert_eq!(SHAFT.friction(0.0, -0.03), Friction::Acts(0.02));
        assert_eq!(SHAFT.friction(1.0, 0.0), Friction::Acts(-0.02));
    }

    #[test]
    fn a_hard_stop_holds_and_bounces() {
        let stops = HardStops { low_turns: -1.0, high_turns: 2.0, restitution: 0.5 };
        let shaft = Mechanics { hard_stops: Some(stops), ..SHAFT };
        assert_eq!(shaft.within_travel(2.1, 10.0), (2.0, -5.0));
        assert_eq!(shaft.within_travel(-1.1, -10.0), (-1.0, 5.0));
        assert_eq!(shaft.within_travel(-1.1, 1.0), (-1.0, 1.0));
        assert_eq!(shaft.within_travel(0.0, 10.0), (0.0, 10.0));
    }
}
