//! What the chip sees in a control period.

/// The chip's surroundings, constant over a control period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pins {
    /// Coil currents A and B at the start of the period.
    pub currents_a: [f64; 2],
    /// Back-EMF of the coils: (−sin θ, cos θ) times a positive constant times the rotor's velocity, for a rotor that stands
    /// where a current vector of (cos θ, sin θ) holds it (decisions §8.1).
    pub back_emf_v: [f64; 2],
    /// The rotor's velocity in revolutions per second; positive where its electrical angle θ grows.
    pub rotor_velocity_rps: f64,
    /// The supply of the bridges.
    pub bus_voltage_v: f64,
    /// Resistance of a winding.
    pub resistance_ohm: f64,
    /// Inductance of a winding.
    pub inductance_h: f64,
    /// Temperature of the board, which the chip shares.
    pub temperature_c: f64,
    /// What is broken between the bridges and the coils.
    pub coil_faults: [CoilFault; 2],
}

/// What can be wrong with a coil's wires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CoilFault {
    /// Nothing.
    #[default]
    None,
    /// A wire is off.
    Open,
    /// The second output touches ground.
    ShortToGround,
}

/// One coil of the [`Pins`].
#[derive(Clone, Copy)]
pub(crate) struct CoilPins {
    pub(crate) current_a: f64,
    pub(crate) back_emf_v: f64,
    pub(crate) fault: CoilFault,
}

impl Pins {
    pub(crate) fn coils(&self) -> [CoilPins; 2] {
        let Self { currents_a: [i_a, i_b], back_emf_v: [e_a, e_b], coil_faults: [fault_a, fault_b], .. } =
            *self;
        [
            CoilPins { current_a: i_a, back_emf_v: e_a, fault: fault_a },
            CoilPins { current_a: i_b, back_emf_v: e_b, fault: fault_b },
        ]
    }
}
