//! The two-phase hybrid stepper (decision: physics).
//!
//! With the electrical angle θ = Nr times the shaft's, the coils see back EMFs −Km·ω·sin θ and Km·ω·cos θ, and the torque is
//! −Km·iA·sin θ + Km·iB·cos θ − Td·sin 4θ. At rest with a current vector at angle φ the rotor stands where θ = φ; it resists
//! being pushed away until θ is 90° off.

use crate::Terminal;
use crate::angle::{Direction, RotorAngle};
use crate::energy::Energy;
use crate::mechanics::{Friction, Mechanics};
use crate::rk4;

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

/// Currents A and B, velocity, electrical angle, and the energies: electrical, copper, friction, load.
type State = [f64; 8];

/// How often friction may stop the shaft within a step; one that is stopped so often stands.
const MAX_STOPS: usize = 4;

/// Halvings of a step to find the instant of a stop: to 50 ns in 50 µs.
const BISECTIONS: usize = 10;

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
    /// The datasheet.
    pub parameters: StepperParameters,
    /// What turns, the rotor included.
    pub mechanics: Mechanics,
    /// Where the rotor is.
    pub angle: RotorAngle,
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
            parameters,
            mechanics,
            angle: RotorAngle::default(),
            velocity_rad_s: 0.0,
            currents_a: [0.0; 2],
            torque_nm: 0.0,
            energy: Energy::default(),
            step_energy: Energy::default(),
        }
    }

    /// Where the shaft is, in turns since 0.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.angle.turns(self.parameters.pole_pairs)
    }

    /// The voltages that the turning rotor induces in the coils.
    #[must_use]
    pub fn back_emf_v(&self) -> [f64; 2] {
        let Direction { sine, cosine } = Direction::of(self.angle.electrical_rad());
        let peak_v = self.parameters.motor_constant() * self.velocity_rad_s;
        [-peak_v * sine, peak_v * cosine]
    }

    /// Average power taken from the power stage in the last step.
    #[must_use]
    pub fn electrical_power_w(&self, dt_s: f64) -> f64 {
        crate::energy::joules(self.step_energy.electrical_pj) / dt_s
    }

    /// Average heat in the windings in the last step.
    #[must_use]
    pub fn copper_power_w(&self, dt_s: f64) -> f64 {
        crate::energy::joules(self.step_energy.copper_pj) / dt_s
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
        let mut energy = Energy::default();
        for _ in 0..parts {
            let voltages = self.voltages(terminals);
            let next = self.stepped(voltages, load_torque_nm, dt_s / f64::from(parts));
            self.settle(next, terminals, voltages);
            energy = energy.plus(self.step_energy, 1);
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

    /// The state after a step, which is cut where friction stops the shaft: put off to the end of the step, a change of its
    /// direction would cost milliamperes.
    fn stepped(&self, voltages: [Option<f64>; 2], load_torque_nm: f64, dt_s: f64) -> State {
        let coefficients = self.coefficients(Direction::of(self.angle.electrical_rad()));
        let [a, b] = self.currents_a;
        // The angle is counted from where it is now.
        let (mut state, mut left_s) = ([a, b, self.velocity_rad_s, 0.0, 0.0, 0.0, 0.0, 0.0], dt_s);
        let integrated = |state, dt_s, friction| {
            rk4::step(state, dt_s, |state| coefficients.derivative(state, voltages, load_torque_nm, friction))
        };
        for _ in 0..MAX_STOPS {
            let friction =
                self.mechanics.friction(velocity(state), coefficients.torque_at(state) + load_torque_nm);
            let after = |dt_s| integrated(state, dt_s, friction);
            let stops = |state| friction.would_drive(velocity(state));
            let reached = after(left_s);
            if !stops(reached) && !self.is_beyond_travel(reached) {
                return reached;
            }
            let stop_s = first_time(left_s, |time_s| {
                let state = after(time_s);
                stops(state) || self.is_beyond_travel(state)
            });
            let there = after(stop_s);
            state = if stops(there) { with_velocity(there, 0.0) } else { self.bounced(there) };
            left_s -= stop_s;
        }
        integrated(state, left_s, Friction::Sticks)
    }

    /// Whether a state lies beyond an end of travel and leads further away.
    fn is_beyond_travel(&self, state: State) -> bool {
        let velocity_rad_s = velocity(state);
        self.mechanics.within_travel(self.turns_in(state), velocity_rad_s).1 != velocity_rad_s
    }

    /// A state at an end of travel with the velocity turned round, and the energy that the end swallows counted as friction.
    fn bounced(&self, state: State) -> State {
        let (_, velocity_rad_s) = self.mechanics.within_travel(self.turns_in(state), velocity(state));
        let swallowed_j =
            self.mechanics.kinetic_j(velocity(state)) - self.mechanics.kinetic_j(velocity_rad_s);
        let [a, b, velocity, turned_rad, electrical_j, copper_j, friction_j, load_j] =
            with_velocity(state, velocity_rad_s);
        [a, b, velocity, turned_rad, electrical_j, copper_j, friction_j + swallowed_j, load_j]
    }

    fn turns_in(&self, [_, _, _, turned_rad, ..]: State) -> f64 {
        self.angle.advanced_to(self.angle.electrical_rad() + turned_rad).turns(self.parameters.pole_pairs)
    }

    /// `steps` further steps like the last one, in which nothing changed: only energy goes on.
    pub fn rest(&mut self, steps: u64) {
        let steps = i64::try_from(steps).unwrap_or(i64::MAX);
        self.energy = self.energy.plus(self.step_energy, steps);
    }

    /// Lets the rotor slip by so many electrical periods, as if it had been pushed.
    pub fn slip(&mut self, electrical_periods: f64) {
        let angle = self.angle.electrical_rad() + electrical_periods * core::f64::consts::TAU;
        self.angle = self.angle.advanced_to(angle);
    }

    /// What stands across the coils; `None` across a coil that carries nothing and is not driven.
    fn voltages(&self, terminals: [Terminal; 2]) -> [Option<f64>; 2] {
        let [a, b] = self.currents_a;
        let [at_a, at_b] = terminals;
        [across(at_a, a), across(at_b, b)]
    }

    /// Torque between rotor and stator, as things stand.
    fn torque(&self) -> f64 {
        let direction = Direction::of(self.angle.electrical_rad());
        self.coefficients(direction).torque(self.currents_a, direction)
    }

    fn coefficients(&self, start: Direction) -> Coefficients {
        Coefficients {
            start,
            motor_constant: self.parameters.motor_constant(),
            detent_torque_nm: self.parameters.detent_torque_nm,
            resistance_ohm: self.parameters.resistance_ohm,
            per_inductance: 1.0 / self.parameters.inductance_h,
            per_inertia: 1.0 / self.mechanics.inertia_kgm2,
            viscous_nm_s_per_rad: self.mechanics.viscous_nm_s_per_rad,
            pole_pairs: self.parameters.pole_pairs,
        }
    }

    /// Takes over what the integrator found, but for what friction, hard stops and diodes do not allow.
    fn settle(&mut self, next: State, terminals: [Terminal; 2], voltages: [Option<f64>; 2]) {
        let [a, b, velocity, turned_rad, electrical_j, copper_j, friction_j, load_j] = next;
        let kinetic_before_j = self.mechanics.kinetic_j(velocity);
        let reached = self.angle.advanced_to(self.angle.electrical_rad() + turned_rad);
        let turns = reached.turns(self.parameters.pole_pairs);
        let (allowed_turns, allowed_velocity) = self.mechanics.within_travel(turns, velocity);
        let swallowed_j = kinetic_before_j - self.mechanics.kinetic_j(allowed_velocity);
        let angle_moved = libm::fabs(turned_rad) > ANGLE_RESOLUTION_RAD;
        if allowed_turns != turns {
            self.angle = RotorAngle::from_turns(allowed_turns, self.parameters.pole_pairs);
        } else if angle_moved {
            self.angle = reached;
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
        self.step_energy = Energy::from_joules(electrical_j, copper_j, friction_j + swallowed_j, load_j);
    }
}

/// What stays the same within a step.
struct Coefficients {
    /// Where the rotor is at its beginning.
    start: Direction,
    motor_constant: f64,
    detent_torque_nm: f64,
    resistance_ohm: f64,
    per_inductance: f64,
    per_inertia: f64,
    viscous_nm_s_per_rad: f64,
    pole_pairs: f64,
}

impl Coefficients {
    /// Rates of change of (iA, iB, ω, θ) and of the energies (electrical, copper, friction, load); θ counts from `start`.
    fn derivative(
        &self,
        [a, b, velocity, turned_rad, ..]: State,
        [voltage_a, voltage_b]: [Option<f64>; 2],
        load_torque_nm: f64,
        friction: Friction,
    ) -> State {
        let direction = self.start.turned(turned_rad);
        let peak_emf_v = self.motor_constant * velocity;
        let slope = |voltage_v: Option<f64>, current_a: f64, emf_v: f64| {
            voltage_v.map_or(0.0, |voltage_v| {
                (voltage_v - self.resistance_ohm * current_a - emf_v) * self.per_inductance
            })
        };
        let driving_nm = self.torque([a, b], direction) + load_torque_nm;
        let viscous_nm = self.viscous_nm_s_per_rad * velocity;
        let (acceleration, friction_w) = match friction {
            Friction::Sticks => (0.0, 0.0),
            Friction::Acts(friction_nm) => (
                (driving_nm + friction_nm - viscous_nm) * self.per_inertia,
                velocity * (viscous_nm - friction_nm),
            ),
        };
        [
            slope(voltage_a, a, -peak_emf_v * direction.sine),
            slope(voltage_b, b, peak_emf_v * direction.cosine),
            acceleration,
            self.pole_pairs * velocity,
            voltage_a.unwrap_or(0.0) * a + voltage_b.unwrap_or(0.0) * b,
            self.resistance_ohm * (a * a + b * b),
            friction_w,
            -load_torque_nm * velocity,
        ]
    }

    /// Torque between rotor and stator in a state.
    fn torque_at(&self, [a, b, _, turned_rad, ..]: State) -> f64 {
        self.torque([a, b], self.start.turned(turned_rad))
    }

    /// Torque between rotor and stator.
    fn torque(&self, [a, b]: [f64; 2], Direction { sine, cosine }: Direction) -> f64 {
        // sin 4θ = 4 sin θ cos θ (cos²θ − sin²θ)
        let detent = 4.0 * sine * cosine * (cosine * cosine - sine * sine);
        self.motor_constant * (b * cosine - a * sine) - self.detent_torque_nm * detent
    }
}

/// The state with the shaft at another velocity.
fn with_velocity([a, b, _, turned_rad, electrical, copper, friction, load]: State, velocity: f64) -> State {
    [a, b, velocity, turned_rad, electrical, copper, friction, load]
}

fn velocity([_, _, velocity, ..]: State) -> f64 {
    velocity
}

/// The first time at which `holds`, which holds at `latest_s`.
fn first_time(latest_s: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut before_s, mut after_s) = (0.0, latest_s);
    for _ in 0..BISECTIONS {
        let middle_s = 0.5 * (before_s + after_s);
        if holds(middle_s) {
            after_s = middle_s;
        } else {
            before_s = middle_s;
        }
    }
    after_s
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
