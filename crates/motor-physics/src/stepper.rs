//! The two-phase hybrid stepper (decision: physics).
//!
//! With the electrical angle θ = Nr times the shaft's, the coils see back EMFs −Km·ω·sin θ and Km·ω·cos θ, and the torque is
//! −Km·iA·sin θ + Km·iB·cos θ − Td·sin 4θ. At rest with a current vector at angle φ the rotor stands where θ = φ; it resists
//! being pushed away until θ is 90° off.

mod equations;
mod step;

use crate::Terminal;
use crate::angle::{Direction, RotorAngle};
use crate::energy::Energy;
use crate::mechanics::Mechanics;
use step::Reached;

/// A stepper's datasheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepperParameters {
    /// RMS phase current for the holding torque.
    pub rated_current_rms_a: f64,
    /// Resistance of a phase.
    pub resistance_ohm: f64,
    /// Inductance of a phase.
    pub inductance_h: f64,
    /// Torque that holds both phases at the rated current against being pushed away.
    pub holding_torque_nm: f64,
    /// Torque of the magnets without current.
    pub detent_torque_nm: f64,
    /// Moment of inertia of the rotor.
    pub rotor_inertia_kgm2: f64,
    /// Pole pairs: a quarter of the full steps in a turn.
    pub pole_pairs: f64,
    /// Thermal time constant of the winding.
    pub winding_time_constant_s: f64,
}

impl StepperParameters {
    /// Torque per ampere of current vector, and volts per rad/s: Km = Th / (√2 · I_rms).
    #[must_use]
    pub fn motor_constant(&self) -> f64 {
        self.holding_torque_nm / (core::f64::consts::SQRT_2 * self.rated_current_rms_a)
    }
}

/// How far the rotor may turn, electrically, in a part of a step; and the most parts of a step.
const PART_RAD: f64 = 0.5;
const MAX_PARTS: f64 = 31.0;

/// Changes smaller than these are none, so that a motor at rest comes to rest.
const CURRENT_RESOLUTION_A: f64 = 1e-9;
const VELOCITY_RESOLUTION_RAD_S: f64 = 1e-9;
const ANGLE_RESOLUTION_RAD: f64 = 1e-12;

/// A stepper on its shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct Stepper {
    parameters: StepperParameters,
    /// Torque per ampere, and volts per rad/s.
    motor_constant: f64,
    /// What turns, the rotor included.
    pub mechanics: Mechanics,
    angle: RotorAngle,
    /// That of `angle`, which is asked for often.
    direction: Direction,
    /// How fast the shaft turns; positive to the right.
    pub velocity_rad_s: f64,
    /// Currents in coils A and B.
    pub currents_a: [f64; 2],
    /// Torque between rotor and stator at the end of the last step.
    pub torque_nm: f64,
    /// Where the energy went.
    pub energy: Energy,
    /// What the last step added to `energy`.
    step_energy: Energy,
}

impl Stepper {
    /// A motor at rest without current, its rotor at 0.
    #[must_use]
    pub fn new(parameters: StepperParameters, mechanics: Mechanics) -> Self {
        Self {
            motor_constant: parameters.motor_constant(),
            parameters,
            mechanics,
            angle: RotorAngle::default(),
            direction: Direction::of(0.0),
            velocity_rad_s: 0.0,
            currents_a: [0.0; 2],
            torque_nm: 0.0,
            energy: Energy::default(),
            step_energy: Energy::default(),
        }
    }

    /// The datasheet.
    #[must_use]
    pub fn parameters(&self) -> &StepperParameters {
        &self.parameters
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

    /// The voltages that the turning rotor induces in the coils.
    #[must_use]
    pub fn back_emf_v(&self) -> [f64; 2] {
        let Direction { sine, cosine } = self.direction;
        let peak_v = self.motor_constant * self.velocity_rad_s;
        [-peak_v * sine, peak_v * cosine]
    }

    /// Average power taken from the power stage in the last step.
    #[must_use]
    pub fn electrical_power_w(&self, dt_s: f64) -> f64 {
        crate::energy::watts(self.step_energy.electrical_pj, dt_s)
    }

    /// Average heat in the windings in the last step.
    #[must_use]
    pub fn copper_power_w(&self, dt_s: f64) -> f64 {
        crate::energy::watts(self.step_energy.copper_pj, dt_s)
    }

    /// Energy in the magnetic field and in the motion.
    #[must_use]
    pub fn stored_j(&self) -> f64 {
        let [a, b] = self.currents_a;
        let magnetic_j = 0.5 * self.parameters.inductance_h * (a * a + b * b);
        // The detent torque is that of a potential.
        let period = self.parameters.detent_torque_nm / (4.0 * self.parameters.pole_pairs);
        let detent_j = -period * libm::cos(4.0 * self.angle.electrical_rad());
        magnetic_j + detent_j + self.mechanics.kinetic_j(self.velocity_rad_s)
    }

    /// A step with the terminals held and `load_torque_nm` from outside. Returns whether anything but time changed.
    pub fn advance(&mut self, terminals: [Terminal; 2], load_torque_nm: f64, dt_s: f64) -> bool {
        let before = (self.angle, self.velocity_rad_s, self.currents_a);
        let parts = self.parts(dt_s);
        let part_s = if parts == 1 { dt_s } else { dt_s / f64::from(parts) };
        let mut energy = Energy::default();
        for _ in 0..parts {
            let voltages = self.voltages(terminals);
            let reached = self.stepped(voltages, load_torque_nm, part_s);
            energy = energy.plus(self.settle(reached, terminals, voltages), 1);
        }
        self.step_energy = energy;
        self.energy = self.energy.plus(energy, 1);
        before != (self.angle, self.velocity_rad_s, self.currents_a)
    }

    /// Into how many parts a step is cut, so that the rotor turns by no more than half an electrical radian in each. One, but
    /// for a rotor that a load drags along faster than any field could.
    fn parts(&self, dt_s: f64) -> u32 {
        let turned_rad = libm::fabs(self.velocity_rad_s) * self.parameters.pole_pairs * dt_s;
        1 + (turned_rad / PART_RAD).min(MAX_PARTS) as u32
    }

    /// `steps` further steps like the last one, in which nothing changed: only energy goes on.
    pub fn rest(&mut self, steps: u64) {
        let steps = i64::try_from(steps).unwrap_or(i64::MAX);
        self.energy = self.energy.plus(self.step_energy, steps);
    }

    /// Lets the rotor slip by so many electrical periods, as if it had been pushed.
    pub fn slip(&mut self, electrical_periods: f64) {
        let angle = self.angle.electrical_rad() + electrical_periods * core::f64::consts::TAU;
        self.place(self.angle.advanced_to(angle));
    }

    fn place(&mut self, angle: RotorAngle) {
        self.angle = angle;
        self.direction = Direction::of(angle.electrical_rad());
    }

    /// What stands across the coils; `None` across a coil that carries nothing and is not driven.
    fn voltages(&self, terminals: [Terminal; 2]) -> [Option<f64>; 2] {
        let [a, b] = self.currents_a;
        let [at_a, at_b] = terminals;
        [across(at_a, a), across(at_b, b)]
    }

    /// Torque between rotor and stator, as things stand.
    fn torque(&self) -> f64 {
        let detent_torque_nm = self.parameters.detent_torque_nm;
        equations::torque_nm(self.motor_constant, detent_torque_nm, self.currents_a, self.direction)
    }

    /// Takes over what the integrator found, but for what friction, hard stops and diodes do not allow. Returns where the
    /// energy went.
    fn settle(&mut self, reached: Reached, terminals: [Terminal; 2], voltages: [Option<f64>; 2]) -> Energy {
        let Reached { state: [a, b, velocity, turned_rad], work } = reached;
        let angle = self.angle.advanced_to(self.angle.electrical_rad() + turned_rad);
        let (allowed_angle, allowed_velocity) = self.within_travel(angle, velocity);
        let swallowed_j = self.mechanics.kinetic_j(velocity) - self.mechanics.kinetic_j(allowed_velocity);
        let angle_moved = libm::fabs(turned_rad) > ANGLE_RESOLUTION_RAD;
        if angle_moved || allowed_angle != angle {
            self.place(allowed_angle);
        }
        if libm::fabs(allowed_velocity - self.velocity_rad_s) > VELOCITY_RESOLUTION_RAD_S {
            self.velocity_rad_s = allowed_velocity;
        } else if !angle_moved {
            self.velocity_rad_s = 0.0;
        }
        let [at_a, at_b] = terminals;
        let [across_a, across_b] = voltages;
        let [before_a, before_b] = self.currents_a;
        self.currents_a =
            [settled_current(at_a, across_a, before_a, a), settled_current(at_b, across_b, before_b, b)];
        self.torque_nm = self.torque();
        work.swallowing(swallowed_j).energy()
    }

    /// Where the rotor is and how fast it moves once the ends of travel have had their say.
    fn within_travel(&self, angle: RotorAngle, velocity_rad_s: f64) -> (RotorAngle, f64) {
        if self.mechanics.hard_stops.is_none() {
            return (angle, velocity_rad_s);
        }
        let pole_pairs = self.parameters.pole_pairs;
        let turns = angle.turns(pole_pairs);
        let (allowed_turns, allowed_velocity) = self.mechanics.within_travel(turns, velocity_rad_s);
        let allowed =
            if allowed_turns == turns { angle } else { RotorAngle::from_turns(allowed_turns, pole_pairs) };
        (allowed, allowed_velocity)
    }
}

/// The voltage across a coil: what drives it, or the bus against what current is left.
fn across(terminal: Terminal, current_a: f64) -> Option<f64> {
    match terminal {
        Terminal::Driven { voltage_v } => Some(voltage_v),
        Terminal::Floating { .. } if current_a == 0.0 => None,
        Terminal::Floating { bus_voltage_v } => Some(-libm::copysign(bus_voltage_v, current_a)),
    }
}

/// The current after a step: diodes let it die, not turn round; and a change too small to matter is none.
fn settled_current(terminal: Terminal, across: Option<f64>, before_a: f64, after_a: f64) -> f64 {
    let died =
        matches!(terminal, Terminal::Floating { .. }) && (across.is_none() || before_a * after_a <= 0.0);
    if died {
        0.0
    } else if libm::fabs(after_a - before_a) > CURRENT_RESOLUTION_A {
        after_a
    } else {
        before_a
    }
}

#[cfg(test)]
mod tests;
