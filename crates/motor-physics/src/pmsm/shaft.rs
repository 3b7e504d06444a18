//! When a shaft stops, sticks, starts, and meets the ends of its travel.

use crate::mechanics::{Friction, Mechanics};

/// Nearer than this to an end of travel is at it.
const RESOLUTION_TURNS: f64 = 1e-9;
/// What moves more slowly than this does not move on after a bounce, or has not yet turned round.
const RESOLUTION_RAD_S: f64 = 1e-9;

/// What holds or brakes the shaft from here on. An end of travel holds whatever torque pushes against it.
pub(super) fn friction(mechanics: &Mechanics, turns: f64, velocity_rad_s: f64, torque_nm: f64) -> Friction {
    if velocity_rad_s == 0.0 && leans(mechanics, turns, torque_nm) {
        return Friction::Sticks;
    }
    mechanics.friction(velocity_rad_s, torque_nm)
}

/// Whether what held or braked the shaft does so still in this state.
pub(super) fn stays(
    mechanics: &Mechanics,
    friction: Friction,
    turns: f64,
    velocity: f64,
    torque_nm: f64,
) -> bool {
    match friction {
        Friction::Sticks => {
            libm::fabs(torque_nm) <= mechanics.friction_nm || leans(mechanics, turns, torque_nm)
        }
        Friction::Acts(friction_nm) => !turned_round(friction_nm, velocity) && within(mechanics, turns),
    }
}

/// The shaft's position and velocity where it has just come to a stop, or to an end of its travel.
pub(super) fn stopped(
    mechanics: &Mechanics,
    friction: Friction,
    turns: f64,
    velocity_rad_s: f64,
) -> (f64, f64) {
    let velocity_rad_s = match friction {
        Friction::Acts(friction_nm) if !turned_round(friction_nm, velocity_rad_s) => velocity_rad_s,
        _ => 0.0,
    };
    let (allowed_turns, allowed_velocity) = mechanics.within_travel(turns, velocity_rad_s);
    if libm::fabs(allowed_velocity) > RESOLUTION_RAD_S {
        (allowed_turns, allowed_velocity)
    } else {
        (allowed_turns, 0.0)
    }
}

/// Whether the velocity has become one that friction of this sign does not brake but drive.
fn turned_round(friction_nm: f64, velocity_rad_s: f64) -> bool {
    friction_nm != 0.0 && libm::copysign(1.0, friction_nm) * velocity_rad_s > RESOLUTION_RAD_S
}

fn within(mechanics: &Mechanics, turns: f64) -> bool {
    mechanics.hard_stops.is_none_or(|stops| {
        (stops.low_turns - RESOLUTION_TURNS..=stops.high_turns + RESOLUTION_TURNS).contains(&turns)
    })
}

/// Whether this torque pushes against an end of travel.
fn leans(mechanics: &Mechanics, turns: f64, torque_nm: f64) -> bool {
    mechanics.hard_stops.is_some_and(|stops| {
        turns >= stops.high_turns - RESOLUTION_TURNS && torque_nm >= 0.0
            || turns <= stops.low_turns + RESOLUTION_TURNS && torque_nm <= 0.0
    })
}
