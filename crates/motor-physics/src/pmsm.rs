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
mod equations;
mod frame;
mod shaft;
mod step;

pub use bridge::Bridge;

use crate::angle::{Direction, RotorAngle};
use crate::energy::{Energy, Work, watts};
use crate::mechanics::Mechanics;
use bridge::Rails;
use equations::State;
use frame::{SQRT_3, phases_of};

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

/// A brushless motor on its shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct Pmsm {
    /// The datasheet.
    pub parameters: PmsmParameters,
    /// What turns, the rotor included.
    pub mechanics: Mechanics,
    angle: RotorAngle,
    /// That of `angle`, which is asked for often.
    direction: Direction,
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
            direction: Direction::of(0.0),
            velocity_rad_s: 0.0,
            current_d_a: 0.0,
            current_q_a: 0.0,
            torque_nm: 0.0,
            energy: Energy::default(),
            step_energy: Energy::default(),
            rails: [0; 3],
        }
    }

    /// Where the rotor is.
    #[must_use]
    pub fn angle(&self) -> RotorAngle {
        self.angle
    }

    /// Where the shaft is, in turns since 0.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.angle.turns(self.parameters.pole_pairs)
    }

    /// The currents into phases U, V and W.
    #[must_use]
    pub fn phase_currents_a(&self) -> [f64; 3] {
        phases_of(self.direction.to_stator([self.current_d_a, self.current_q_a]))
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
        watts(self.step_energy.electrical_pj, dt_s)
    }

    /// Average heat in the windings in the last step.
    #[must_use]
    pub fn copper_power_w(&self, dt_s: f64) -> f64 {
        watts(self.step_energy.copper_pj, dt_s)
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
        let (state, work) = self.stepped(bridge, load_torque_nm, dt_s);
        self.settle(state, work);
        self.energy = self.energy.plus(self.step_energy, 1);
        before != (self.angle, self.velocity_rad_s, self.current_d_a, self.current_q_a)
    }

    /// `steps` further steps like the last one, in which nothing changed: only energy goes on.
    pub fn rest(&mut self, steps: u64) {
        let steps = i64::try_from(steps).unwrap_or(i64::MAX);
        self.energy = self.energy.plus(self.step_energy, steps);
    }

    /// Puts the rotor elsewhere, as if it had always been there.
    pub fn place(&mut self, angle: RotorAngle) {
        self.angle = angle;
        self.direction = Direction::of(angle.electrical_rad());
    }

    /// Takes over what the integrator found, but for changes too small to matter.
    fn settle(&mut self, [d, q, velocity, turned_rad]: State, work: Work) {
        let angle_moved = libm::fabs(turned_rad) > ANGLE_RESOLUTION_RAD;
        if angle_moved {
            self.place(self.angle.advanced_to(self.angle.electrical_rad() + turned_rad));
        }
        let velocity_rad_s = settled(self.velocity_rad_s, velocity, VELOCITY_RESOLUTION_RAD_S);
        let rests = !angle_moved && velocity_rad_s == self.velocity_rad_s;
        self.velocity_rad_s = if rests { 0.0 } else { velocity_rad_s };
        self.current_d_a = settled(self.current_d_a, d, CURRENT_RESOLUTION_A);
        self.current_q_a = settled(self.current_q_a, q, CURRENT_RESOLUTION_A);
        self.torque_nm = self.parameters.torque_nm(self.current_d_a, self.current_q_a);
        self.step_energy = work.energy();
    }
}

/// A value after a step: a change too small to matter is none, unless it ends at zero.
fn settled(before: f64, after: f64, resolution: f64) -> f64 {
    let matters = after == 0.0 || libm::fabs(after - before) > resolution;
    if matters { after } else { before }
}

#[cfg(test)]
mod tests;
