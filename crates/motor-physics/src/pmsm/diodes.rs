//! A power stage that is switched off: six diodes; and phases that carry nothing.
//!
//! What current is left flows from the lower rail or into the upper one until it has died; and where a terminal's voltage
//! would leave the rails, it begins to.

use super::bridge::{Connection, Rails, axis, connection};
use super::equations::{Equations, State};
use super::frame::{dot, phases_of};
use super::{CURRENT_RESOLUTION_A, Pmsm};
use crate::angle::Direction;

/// A terminal that is further than this beyond a rail conducts.
const RESOLUTION_V: f64 = 1e-9;

impl Pmsm {
    /// Whether the same diodes conduct in this state.
    pub(super) fn diodes_stay(&self, state: State, bus_voltage_v: f64, equations: &Equations) -> bool {
        let rotor = equations.rotor(state);
        let ended = conducted(self.rails, phase_currents(state, rotor));
        ended == self.rails && conducting_from(ended, state, bus_voltage_v, equations) == ended
    }

    /// Lets diodes go out whose current has died, and others come on whose terminal is beyond a rail.
    pub(super) fn switch_diodes(
        &mut self,
        state: State,
        bus_voltage_v: f64,
        equations: &Equations,
    ) -> (State, Connection) {
        let rotor = equations.rotor(state);
        let currents = phase_currents(state, rotor);
        let rails = if self.rails == [0; 3] { currents.map(rail_of) } else { self.rails };
        self.rails = conducted(rails, currents);
        let state = residue_removed(state, self.rails, rotor);
        self.rails = conducting_from(self.rails, state, bus_voltage_v, equations);
        (state, connection(self.rails, bus_voltage_v))
    }
}

/// The state and the connection once the wire of a phase is off: it carries nothing, and the other two see what is left of
/// the voltage vector.
pub(super) fn opened(state: State, phase: usize, voltage: [f64; 2], rotor: Direction) -> (State, Connection) {
    let along = axis(phase);
    let ([alpha, beta], [along_alpha, along_beta]) = (voltage, along);
    let part = dot(voltage, along);
    let across = [alpha - part * along_alpha, beta - part * along_beta];
    (without_current(state, phase, rotor), Connection::OpenPhase(phase, across))
}

/// The state without what rounding left of currents that have died.
fn residue_removed(state: State, rails: Rails, rotor: Direction) -> State {
    let [_, _, velocity, turned_rad] = state;
    match connection(rails, 0.0) {
        Connection::Closed(_) => state,
        Connection::OpenPhase(phase, _) => without_current(state, phase, rotor),
        Connection::Open => [0.0, 0.0, velocity, turned_rad],
    }
}

/// The state without the current in a phase.
fn without_current([d, q, velocity, turned_rad]: State, phase: usize, rotor: Direction) -> State {
    let along = rotor.to_rotor(axis(phase));
    let current_a = dot([d, q], along);
    let [along_d, along_q] = along;
    [d - current_a * along_d, q - current_a * along_q, velocity, turned_rad]
}

/// These diodes and those that come on in this state.
fn conducting_from(rails: Rails, state: State, bus_voltage_v: f64, equations: &Equations) -> Rails {
    let (slopes, rotor) = (equations.current_slopes(state), equations.rotor(state));
    match connection(rails, bus_voltage_v) {
        Connection::Closed(_) => rails,
        Connection::OpenPhase(phase, voltage) => {
            // The star point is where the three terminals' voltages average, and the other two are at opposite rails.
            let terminal_v = 1.5 * slopes.open_phase_v(phase, voltage, rotor);
            let rail_v = 0.5 * bus_voltage_v + RESOLUTION_V;
            with_rail(rails, phase, i8::from(terminal_v > rail_v) - i8::from(terminal_v < -rail_v))
        }
        Connection::Open => rectifying(phases_of(rotor.to_stator(slopes.opposing_v())), bus_voltage_v),
    }
}

fn phase_currents([d, q, ..]: State, rotor: Direction) -> [f64; 3] {
    phases_of(rotor.to_stator([d, q]))
}

/// The rail through whose diode a current flows.
fn rail_of(current_a: f64) -> i8 {
    i8::from(current_a < -CURRENT_RESOLUTION_A) - i8::from(current_a > CURRENT_RESOLUTION_A)
}

/// The diodes that still conduct: those whose current has not turned round, unless only one is left.
fn conducted(rails: Rails, currents: [f64; 3]) -> Rails {
    let mut left = rails;
    for (rail, current_a) in left.iter_mut().zip(currents) {
        if f64::from(*rail) * current_a > CURRENT_RESOLUTION_A {
            *rail = 0;
        }
    }
    let conducting = left.iter().filter(|rail| **rail != 0).count();
    if conducting < 2 { [0; 3] } else { left }
}

/// The two diodes through which a turned rotor feeds the bus, if its voltage exceeds the bus's.
fn rectifying(emf_v: [f64; 3], bus_voltage_v: f64) -> Rails {
    let highest_v = emf_v.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let lowest_v = emf_v.into_iter().fold(f64::INFINITY, f64::min);
    if highest_v - lowest_v <= bus_voltage_v + RESOLUTION_V {
        return [0; 3];
    }
    emf_v.map(|emf_v| i8::from(emf_v == highest_v) - i8::from(emf_v == lowest_v))
}

fn with_rail(mut rails: Rails, phase: usize, rail: i8) -> Rails {
    if let Some(at) = rails.get_mut(phase) {
        *at = rail;
    }
    rails
}
