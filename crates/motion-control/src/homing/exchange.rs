//! What the search is told, and what it answers, once a control period.

use crate::ramp::Goal;

/// Which switches are active; whatever that means electrically is settled before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    /// The stop switch in negative direction.
    pub left: bool,
    /// The stop switch in positive direction.
    pub right: bool,
    /// The home switch.
    pub home: bool,
}

/// What the search is told once a control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// Which switches are active.
    pub switches: Switches,
    /// Where the ramp is.
    pub position: i32,
    /// Where the axis is, in the ramp's coordinates: the ramp's position where nothing measures it.
    pub measured: i32,
    /// Whether the ramp stands.
    pub standing: bool,
}

/// How the search moves. Speeds are magnitudes in pps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// Until a switch is found.
    pub search_pps: i32,
    /// While it is measured, and to the new zero.
    pub switch_pps: i32,
    /// Slow down with the ramp where a switch is found, instead of stopping at once.
    pub soft_stop: bool,
}

/// What the ramp shall do in this control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Drive at a goal, within a velocity.
    Drive {
        /// At what.
        goal: Goal,
        /// Largest velocity in pps.
        max_velocity_pps: i32,
    },
    /// Stop at once.
    Halt,
    /// Nothing more: a stop switch lies in the way that should not be there, such as one whose wire is cut.
    Blocked,
    /// Nothing more: the ramp stands on the new zero.
    Finished {
        /// How far the right stop switch lies from the new zero, where the search measured both.
        distance: Option<i32>,
    },
}
