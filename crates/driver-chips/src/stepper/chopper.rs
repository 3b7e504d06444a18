//! Current regulation, averaged over the period: what voltage brings a coil's current to its target by the end of it.

use motor_physics::Terminal;

use super::Pins;
use super::pins::{CoilFault, CoilPins};

/// The voltage that brings a coil's current to its target, as far as the supply goes.
pub(crate) fn terminal(
    target_a: f64,
    coil: CoilPins,
    pins: &Pins,
    short_protection: bool,
    period_s: f64,
) -> Terminal {
    bridge(wanted_v(target_a, coil, pins, period_s), coil, pins, short_protection)
}

/// What a bridge can do of a voltage: no more than the bus, and not against a fault.
pub(crate) fn bridge(wanted_v: f64, coil: CoilPins, pins: &Pins, short_protection: bool) -> Terminal {
    let bus_voltage_v = pins.bus_voltage_v.max(0.0);
    let lowest_v = match coil.fault {
        CoilFault::None => -bus_voltage_v,
        // One end lies on ground: the bridge can still push from the other end, but not pull.
        CoilFault::ShortToGround if !short_protection => 0.0,
        // A protected bridge gives up each chopper cycle as soon as it meets the short.
        CoilFault::ShortToGround | CoilFault::Open => return Terminal::Floating { bus_voltage_v },
    };
    Terminal::Driven { voltage_v: wanted_v.max(lowest_v).min(bus_voltage_v) }
}

/// R·ī + e + L·Δi/T with the mean ī of the current on its way: right to the second order of T·R/L.
fn wanted_v(target_a: f64, coil: CoilPins, pins: &Pins, period_s: f64) -> f64 {
    let change_a = target_a - coil.current_a;
    let mean_a = (target_a + coil.current_a) / 2.0;
    pins.resistance_ohm * mean_a + coil.back_emf_v + pins.inductance_h / period_s * change_a
}
