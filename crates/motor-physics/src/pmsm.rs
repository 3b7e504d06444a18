//! The permanent-magnet synchronous motor, in the frame of its rotor (decisions §8.2).
//!
//! ```text
//! Ld did/dt = ud − R id + ωe Lq iq
//! Lq diq/dt = uq − R iq − ωe (Ld id + ψ)
//! T = 3/2 p (ψ + (Ld − Lq) id) iq
//! J dω/dt = T − B ω − friction + load
//! ```
//!
//! The electrical angle is that of the d axis from phase U's axis, and rises as the motor turns to the right. Voltages are
//! held in the stationary frame, as a power stage does, and so turn backwards in the rotor's within a step.

mod bridge;
mod currents;
mod diodes;
mod frame;
mod shaft;
mod step;

pub use bridge::Bridge;

use crate::angle::{Direction, RotorAngle};
use crate::energy::{Energy, joules};
use crate::mechanics::{Friction, Mechanics};
use bridge::{Connection, Rails};
use currents::CurrentSlopes;
use frame::{SQRT_3, dot, phases_of};

/// A brushless motor's datasheet, as a star of three phases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PmsmParameters {
    /// Pole pairs.
    pub pole_pairs: f64,
    /// Resistance of a phase: half of what is measured between two terminals.
    pub resistance_ohm: f64,
    /// Inductance of a phase along the magnets.
    pub d_inductance_h: f64,
    /// Inductance of a phase across the magnets.
    pub q_inductance_h: f64,
    /// Flux of the magnets through a phase, amplitude.
    pub flux_linkage_wb: f64,
    /// Moment of inertia of the rotor.
    pub rotor_inertia_kgm2: f64,
    /// Voltage of the supply it is made for.
    pub rated_voltage_v: f64,
    /// Velocity at the rated voltage and torque.
    pub rated_velocity_rad_s: f64,
    /// Current into one phase and out of another for the rated torque; its vector is 2/√3 times as long.
    pub rated_current_a: f64,
    /// Torque it can give for ever.
    pub rated_torque_nm: f64,
    /// As the rated current, for the peak torque.
    pub peak_current_a: f64,
    /// Torque it can give for a moment.
    pub peak_torque_nm: f64,
    /// Thermal time constant of the winding.
    pub winding_time_constant_s: f64,
}

impl PmsmParameters {
    /// The flux linkage that makes a datasheet's torque constant: ψ = Kt / (√3 p).
    ///
    /// A current I into one phase and out of another is a vector of 2/√3 · I, and 3/2 p ψ · 2/√3 · I = Kt · I. Likewise the
    /// voltage between two terminals peaks at √3 p ψ ω = Kt · ω.
    #[must_use]
    pub const fn flux_linkage_from(torque_constant_nm_per_a: f64, pole_pairs: f64) -> f64 {
        torque_constant_nm_per_a / (SQRT_3 * pole_pairs)
    }

    /// Torque that these currents make.
    #[must_use]
    pub fn torque_nm(&self, current_d_a: f64, current_q_a: f64) -> f64 {
        let flux_wb = self.flux_linkage_wb + (self.d_inductance_h - self.q_inductance_h) * current_d_a;
        1.5 * self.pole_pairs * flux_wb * current_q_a
    }
}

/// Changes smaller than these are none, so that a motor at rest comes to rest.
const CURRENT_RESOLUTION_A: f64 = 1e-9;
const VELOCITY_RESOLUTION_RAD_S: f64 = 1e-9;
const ANGLE_RESOLUTION_RAD: f64 = 1e-12;

/// What acts on the shaft from outside during a step.
#[derive(Clone, Copy)]
struct Outside {
    load_torque_nm: f64,
    friction: Friction,
}

/// (id, iq, ω, θ) and the energies (electrical, copper, friction, load) since the step began.
type State = [f64; 8];

/// A brushless motor on its shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct Pmsm {
    /// The datasheet.
    pub parameters: PmsmParameters,
    /// What turns, the rotor included.
    pub mechanics: Mechanics,
    /// Where the rotor is.
    pub angle: RotorAngle,
    /// How fast the shaft turns; positive to the right.
    pub velocity_rad_s: f64,
    /// Current along the magnets, amplitude.
    pub current_d_a: f64,
    /// Current across the magnets, amplitude: what makes torque.
    pub current_q_a: f64,
    /// Torque between rotor and stator at the end of the last step.
    pub torque_nm: f64,
    /// Where the energy went.
    pub energy: Energy,
    /// What the last step added to `energy`.
    step_energy: Energy,
    /// Which diodes conduct while the power stage is off.
    rails: Rails,
}

impl Pmsm {
    /// A motor at rest without current, its rotor at 0.
    #[must_use]
    pub fn new(parameters: PmsmParameters, mechanics: Mechanics) -> Self {
        Self {
            parameters,
            mechanics,
            angle: RotorAngle::default(),
            velocity_rad_s: 0.0,
            current_d_a: 0.0,
            current_q_a: 0.0,
            torque_nm: 0.0,
            energy: Energy::default(),
            step_energy: Energy::default(),
            rails: [0; 3],
        }
    }

    /// Where the shaft is, in turns since 0.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.angle.turns(self.parameters.pole_pairs)
    }

    /// The currents into phases U, V and W.
    #[must_use]
    pub fn phase_currents_a(&self) -> [f64; 3] {
        phases_of(Direction::of(self.angle.electrical_rad()).to_stator([self.current_d_a, self.current_q_a]))
    }

    /// The voltage that the turning magnets induce between two terminals, amplitude.
    #[must_use]
    pub fn line_to_line_emf_v(&self) -> f64 {
        let PmsmParameters { pole_pairs, flux_linkage_wb, .. } = self.parameters;
        SQRT_3 * pole_pairs * flux_linkage_wb * libm::fabs(self.velocity_rad_s)
    }

    /// Average power taken from the power stage in the last step.
    #[must_use]
    pub fn electrical_power_w(&self, dt_s: f64) -> f64 {
        joules(self.step_energy.electrical_pj) / dt_s
    }

    /// Average heat in the windings in the last step.
    #[must_use]
    pub fn copper_power_w(&self, dt_s: f64) -> f64 {
        joules(self.step_energy.copper_pj) / dt_s
    }

    /// Energy in the magnetic field and in the motion.
    #[must_use]
    pub fn stored_j(&self) -> f64 {
        let PmsmParameters { d_inductance_h, q_inductance_h, .. } = self.parameters;
        let (d, q) = (self.current_d_a, self.current_q_a);
        0.75 * (d_inductance_h * d * d + q_inductance_h * q * q)
            + self.mechanics.kinetic_j(self.velocity_rad_s)
    }

    /// A step with the bridge held and `load_torque_nm` from outside. Returns whether anything but time changed.
    pub fn advance(&mut self, bridge: Bridge, load_torque_nm: f64, dt_s: f64) -> bool {
        let before = (self.angle, self.velocity_rad_s, self.current_d_a, self.current_q_a);
        let electrical_rad = self.angle.electrical_rad();
        let start =
            [self.current_d_a, self.current_q_a, self.velocity_rad_s, electrical_rad, 0.0, 0.0, 0.0, 0.0];
        let next = self.stepped(start, bridge, load_torque_nm, dt_s);
        self.settle(next);
        self.energy = self.energy.plus(self.step_energy, 1);
        before != (self.angle, self.velocity_rad_s, self.current_d_a, self.current_q_a)
    }

    /// `steps` further steps like the last one, in which nothing changed: only energy goes on.
    pub fn rest(&mut self, steps: u64) {
        let steps = i64::try_from(steps).unwrap_or(i64::MAX);
        self.energy = self.energy.plus(self.step_energy, steps);
    }

    /// Rates of change, with the d axis pointing along `rotor`.
    fn derivative(&self, state: State, rotor: Direction, connection: Connection, outside: Outside) -> State {
        let [d, q, velocity, ..] = state;
        let slopes = CurrentSlopes::new(&self.parameters, [d, q], velocity);
        let voltage = slopes.voltage(connection, rotor);
        let [slope_d, slope_q] = voltage.map_or([0.0; 2], |voltage| slopes.under(voltage));
        let torque = self.parameters.torque_nm(d, q);
        let friction_power = match outside.friction {
            Friction::Sticks => 0.0,
            Friction::Acts(friction_nm) => {
                velocity * (self.mechanics.viscous_nm_s_per_rad * velocity - friction_nm)
            }
        };
        [
            slope_d,
            slope_q,
            self.mechanics.acceleration(velocity, torque + outside.load_torque_nm, outside.friction),
            self.parameters.pole_pairs * velocity,
            1.5 * dot(voltage.unwrap_or_default(), [d, q]),
            1.5 * self.parameters.resistance_ohm * (d * d + q * q),
            friction_power,
            -outside.load_torque_nm * velocity,
        ]
    }

    /// Takes over what the integrator found, but for changes too small to matter.
    fn settle(&mut self, next: State) {
        let [d, q, velocity, angle, electrical_j, copper_j, friction_j, load_j] = next;
        let angle_moved = libm::fabs(angle - self.angle.electrical_rad()) > ANGLE_RESOLUTION_RAD;
        if angle_moved {
            self.angle = self.angle.advanced_to(angle);
        }
        let velocity_rad_s = settled(self.velocity_rad_s, velocity, VELOCITY_RESOLUTION_RAD_S);
        let rests = !angle_moved && velocity_rad_s == self.velocity_rad_s;
        self.velocity_rad_s = if rests { 0.0 } else { velocity_rad_s };
        self.current_d_a = settled(self.current_d_a, d, CURRENT_RESOLUTION_A);
        self.current_q_a = settled(self.current_q_a, q, CURRENT_RESOLUTION_A);
        self.torque_nm = self.parameters.torque_nm(self.current_d_a, self.current_q_a);
        self.step_energy = Energy::from_joules(electrical_j, copper_j, friction_j, load_j);
    }
}

/// A value after a step: a change too small to matter is none, unless it ends at zero.
fn settled(before: f64, after: f64, resolution: f64) -> f64 {
    let matters = after == 0.0 || libm::fabs(after - before) > resolution;
    if matters { after } else { before }
}

#[cfg(test)]
mod tests;
