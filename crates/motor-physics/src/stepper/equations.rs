//! The stepper's differential equations while nothing begins or ends.

use super::Stepper;
use crate::angle::Direction;
use crate::energy::Work;
use crate::mechanics::Friction;
use crate::rk4;

/// Currents A and B, velocity, and the electrical angle from where it was at the beginning of the step.
pub(super) type State = [f64; 4];

/// What the equations know besides the state.
#[derive(Clone, Copy)]
pub(super) struct Equations {
    /// Where the rotor is at the beginning of the step.
    start: Direction,
    coils: [Coil; 2],
    motor_constant: f64,
    detent_torque_nm: f64,
    resistance_ohm: f64,
    per_inertia: f64,
    load_torque_nm: f64,
    friction_nm: f64,
    viscous_nm_s_per_rad: f64,
    pole_pairs: f64,
}

/// What holds a coil's current.
#[derive(Clone, Copy)]
struct Coil {
    voltage_v: f64,
    /// 0 for a coil whose current does not change.
    per_inductance: f64,
}

impl Equations {
    /// The equations of a motor with these voltages across its coils, before friction has been chosen.
    pub(super) fn new(motor: &Stepper, voltages: [Option<f64>; 2], load_torque_nm: f64) -> Self {
        let per_inductance = 1.0 / motor.parameters.inductance_h;
        let coil = |voltage: Option<f64>| match voltage {
            Some(voltage_v) => Coil { voltage_v, per_inductance },
            None => Coil { voltage_v: 0.0, per_inductance: 0.0 },
        };
        Self {
            start: motor.direction,
            coils: voltages.map(coil),
            motor_constant: motor.motor_constant,
            detent_torque_nm: motor.parameters.detent_torque_nm,
            resistance_ohm: motor.parameters.resistance_ohm,
            per_inertia: 1.0 / motor.mechanics.inertia_kgm2,
            load_torque_nm,
            friction_nm: 0.0,
            viscous_nm_s_per_rad: motor.mechanics.viscous_nm_s_per_rad,
            pole_pairs: motor.parameters.pole_pairs,
        }
    }

    /// The same with this friction; a shaft that sticks is one that nothing accelerates.
    pub(super) fn with(self, friction: Friction) -> Self {
        match friction {
            Friction::Acts(friction_nm) => Self { friction_nm, ..self },
            Friction::Sticks => Self { per_inertia: 0.0, ..self },
        }
    }

    /// What drives the shaft against friction in a state.
    pub(super) fn driving_nm(&self, [a, b, _, turned_rad]: State) -> f64 {
        self.driving_towards_nm([a, b], self.start.turned(turned_rad))
    }

    /// The state after `dt_s` and where the energy went until then.
    ///
    /// The energies depend on nothing but the state, so they are integrated with the weights of the Runge-Kutta step from
    /// the states that it went through: the same as taking them along, at a fraction of the cost.
    #[inline(never)] // it is long, and called where a step is cut, too
    pub(super) fn after(&self, first: State, dt_s: f64) -> (State, Work) {
        let k1 = self.slopes(first);
        let second = rk4::moved(first, k1, 0.5 * dt_s);
        let k2 = self.slopes(second);
        let third = rk4::moved(first, k2, 0.5 * dt_s);
        let k3 = self.slopes(third);
        let fourth = rk4::moved(first, k3, dt_s);
        let k4 = self.slopes(fourth);
        let last = rk4::moved(first, rk4::mean([k1, k2, k3, k4]), dt_s);
        let means = rk4::mean([first, second, third, fourth].map(quantities));
        (last, self.work(means, dt_s))
    }

    /// Where the energy went in a step over which [`quantities`] had these means.
    fn work(&self, [a, b, velocity, squared_a2, squared_rad2_per_s2]: [f64; 5], dt_s: f64) -> Work {
        let [Coil { voltage_v: voltage_a, .. }, Coil { voltage_v: voltage_b, .. }] = self.coils;
        let friction_w = self.viscous_nm_s_per_rad * squared_rad2_per_s2 - self.friction_nm * velocity;
        Work {
            electrical_j: (voltage_a * a + voltage_b * b) * dt_s,
            copper_j: self.resistance_ohm * squared_a2 * dt_s,
            friction_j: friction_w * dt_s,
            load_j: -self.load_torque_nm * velocity * dt_s,
        }
    }

    /// Rates of change of the state.
    #[inline(always)] // four calls of which each would cost half as much again
    fn slopes(&self, [a, b, velocity, turned_rad]: State) -> State {
        let direction = self.start.turned(turned_rad);
        let peak_emf_v = self.motor_constant * velocity;
        let slope = |coil: Coil, current_a: f64, emf_v: f64| {
            (coil.voltage_v - self.resistance_ohm * current_a - emf_v) * coil.per_inductance
        };
        let [coil_a, coil_b] = self.coils;
        let held_nm = self.friction_nm - self.viscous_nm_s_per_rad * velocity;
        [
            slope(coil_a, a, -peak_emf_v * direction.sine),
            slope(coil_b, b, peak_emf_v * direction.cosine),
            (self.driving_towards_nm([a, b], direction) + held_nm) * self.per_inertia,
            self.pole_pairs * velocity,
        ]
    }

    #[inline]
    fn driving_towards_nm(&self, currents_a: [f64; 2], direction: Direction) -> f64 {
        torque_nm(self.motor_constant, self.detent_torque_nm, currents_a, direction) + self.load_torque_nm
    }
}

/// What the powers depend on: currents A and B, velocity, the square of the current vector, the square of the velocity.
fn quantities([a, b, velocity, _]: State) -> [f64; 5] {
    [a, b, velocity, a * a + b * b, velocity * velocity]
}

/// Torque between rotor and stator.
#[inline]
pub(super) fn torque_nm(
    motor_constant: f64,
    detent_torque_nm: f64,
    [a, b]: [f64; 2],
    Direction { sine, cosine }: Direction,
) -> f64 {
    // sin 4θ = 4 sin θ cos θ (cos²θ − sin²θ)
    let detent_nm = (4.0 * detent_torque_nm * sine * cosine) * (cosine * cosine - sine * sine);
    motor_constant * (b * cosine - a * sine) - detent_nm
}
