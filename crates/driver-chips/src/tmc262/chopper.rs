//! Current regulation, averaged over the period: what voltage brings a coil's current to its target by the end of it.

use motor_physics::Terminal;

use super::pins::{CoilFault, CoilPins};
use super::{Pins, Registers};

/// The voltage of a coil for the next period.
pub(super) fn terminal(
    target_a: f64,
    coil: CoilPins,
    pins: &Pins,
    registers: &Registers,
    period_s: f64,
) -> Terminal {
    let bus_voltage_v = pins.bus_voltage_v.max(0.0);
    let lowest_v = match coil.fault {
        CoilFault::None => -bus_voltage_v,
        // One end lies on ground: the bridge can still push from the other end, but not pull.
        CoilFault::ShortToGround if registers.short_protection_disabled => 0.0,
        // A protected bridge gives up each chopper cycle as soon as it meets the short.
        CoilFault::ShortToGround | CoilFault::Open => return Terminal::Floating { bus_voltage_v },
    };
    let voltage_v = wanted_v(target_a, coil, pins, period_s).max(lowest_v).min(bus_voltage_v);
    Terminal::Driven { voltage_v }
}

/// R·ī + e + L·Δi/T with the mean ī of the current on its way: right to the second order of T·R/L.
fn wanted_v(target_a: f64, coil: CoilPins, pins: &Pins, period_s: f64) -> f64 {
    let change_a = target_a - coil.current_a;
    let mean_a = (target_a + coil.current_a) / 2.0;
    pins.resistance_ohm * mean_a + coil.back_emf_v + pins.inductance_h / period_s * change_a
}
