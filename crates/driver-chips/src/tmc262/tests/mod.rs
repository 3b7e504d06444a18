//! The whole chip, on coils with their closed-form solution and on a rotor that follows at a given load angle.

use core::f64::consts::{PI, SQRT_2, TAU};

use super::*;
use motor_physics::Terminal;

mod faults;
mod load;
mod properties;
mod regulation;

const PERIOD_S: f64 = 50e-6;
const POLE_PAIRS: f64 = 50.0;
const PEAK_A: f64 = 3.0 * SQRT_2;

/// Back-EMF per velocity of a QSH5718-51-28-101 (decisions §8.1 and §8.3).
const KM: f64 = 1.01 / (SQRT_2 * 2.8);

fn chip() -> Tmc262 {
    Tmc262::new(Board { full_scale_rms_a: 3.0 })
}

fn registers(coils: [i16; 2]) -> Registers {
    Registers { coils: Coils::Direct(coils), current_scale: 31, off_time: 5, ..Registers::default() }
}

/// A QSH5718-51-28-101 at rest and at room temperature.
fn pins() -> Pins {
    Pins {
        currents_a: [0.0; 2],
        back_emf_v: [0.0; 2],
        rotor_velocity_rps: 0.0,
        bus_voltage_v: 48.0,
        resistance_ohm: 0.83,
        inductance_h: 2.2e-3,
        temperature_c: 25.0,
        coil_faults: [CoilFault::None; 2],
    }
}

/// The current after a period with the voltage held: the exact solution of L di/dt = v − R i − e.
fn current_after(current_a: f64, terminal: Terminal, back_emf_v: f64, pins: &Pins) -> f64 {
    let Terminal::Driven { voltage_v } = terminal else { return 0.0 };
    let settled_a = (voltage_v - back_emf_v) / pins.resistance_ohm;
    settled_a + (current_a - settled_a) * libm::exp(-PERIOD_S * pins.resistance_ohm / pins.inductance_h)
}

/// Lets the coils' currents answer to a period.
fn turn_on(chip: &mut Tmc262, registers: &Registers, pins: &mut Pins) -> [Terminal; 2] {
    let terminals = chip.advance(registers, pins, PERIOD_S);
    let [a, b] = terminals;
    pins.currents_a = [
        current_after(pins.currents_a[0], a, pins.back_emf_v[0], pins),
        current_after(pins.currents_a[1], b, pins.back_emf_v[1], pins),
    ];
    terminals
}

/// A motor whose rotor follows at a constant velocity and load angle, and whose currents follow ideally.
struct Turning {
    chip: Tmc262,
    registers: Registers,
    pins: Pins,
    phase: f64,
}

impl Turning {
    fn new(velocity_rps: f64) -> Self {
        let pins = Pins { rotor_velocity_rps: velocity_rps, ..pins() };
        Self { chip: chip(), registers: registers([0, 0]), pins, phase: 0.3 }
    }

    fn vector(angle: f64) -> [i16; 2] {
        [libm::round(248.0 * libm::cos(angle)) as i16, libm::round(248.0 * libm::sin(angle)) as i16]
    }

    /// One control period at a load angle: as it begins, the rotor is that far behind the vector of the one before.
    fn period(&mut self, load_rad: f64) -> [Terminal; 2] {
        let emf_v = KM * self.pins.rotor_velocity_rps * TAU;
        let rotor = self.phase - load_rad;
        self.phase += self.pins.rotor_velocity_rps * POLE_PAIRS * TAU * PERIOD_S;
        self.pins.back_emf_v = [-emf_v * libm::sin(rotor), emf_v * libm::cos(rotor)];
        self.registers.coils = Coils::Direct(Self::vector(self.phase));
        self.chip.advance(&self.registers, &self.pins, PERIOD_S)
    }

    /// The reading after so many full steps at a load angle.
    fn reading(&mut self, load_rad: f64, full_steps: f64) -> u16 {
        let periods = full_steps / (self.pins.rotor_velocity_rps.abs() * POLE_PAIRS * 4.0 * PERIOD_S);
        for _ in 0..libm::ceil(periods) as u32 {
            self.period(load_rad);
        }
        self.chip.status().stallguard_value
    }
}
