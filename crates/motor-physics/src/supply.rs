//! The supply: a source behind a resistance and a diode, and the capacitor of the bus.
//!
//! Braking feeds energy back; the diode keeps it from the source, so it raises the bus voltage (decision: power stage).

/// The source and the bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupplyParameters {
    /// Voltage of the source.
    pub voltage_v: f64,
    /// Resistance of source and leads.
    pub source_resistance_ohm: f64,
    /// Capacitance of the bus.
    pub capacitance_f: f64,
}

impl SupplyParameters {
    /// The default of the benches behind a source of `voltage_v`: 0.1 Ω, 2200 µF (decision).
    #[must_use]
    pub const fn standard(voltage_v: f64) -> Self {
        Self { voltage_v, source_resistance_ohm: 0.1, capacitance_f: 2200e-6 }
    }
}

/// A supply in operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supply {
    /// The source and the bus; may be changed in operation.
    pub parameters: SupplyParameters,
    bus_voltage_v: f64,
    source_current_a: f64,
    decay: Decay,
}

/// How much of a deviation is left after a step, kept for the next one: an exponential is dear.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Decay {
    time_constant_s: f64,
    dt_s: f64,
    left: f64,
}

impl Decay {
    const NONE: Self = Self { time_constant_s: 0.0, dt_s: 0.0, left: 0.0 };

    /// exp(−dt/τ).
    fn over(&mut self, dt_s: f64, time_constant_s: f64) -> f64 {
        if self.dt_s != dt_s || self.time_constant_s != time_constant_s {
            *self = Self { time_constant_s, dt_s, left: libm::exp(-dt_s / time_constant_s) };
        }
        self.left
    }
}

/// Bus voltages closer together than this are the same, so that a bus at rest comes to rest.
const RESOLUTION_V: f64 = 1e-9;

impl Supply {
    /// A supply that has been on for a while.
    #[must_use]
    pub fn new(parameters: SupplyParameters) -> Self {
        Self { parameters, bus_voltage_v: parameters.voltage_v, source_current_a: 0.0, decay: Decay::NONE }
    }

    /// The bus voltage.
    #[must_use]
    pub fn bus_voltage_v(&self) -> f64 {
        self.bus_voltage_v
    }

    /// The current out of the source, never negative.
    #[must_use]
    pub fn source_current_a(&self) -> f64 {
        self.source_current_a
    }

    /// A step in which the consumers take `power_w` on average; negative when they feed back.
    ///
    /// The capacitor charges towards the voltage at which the source just feeds the consumers, with the time constant of
    /// source and capacitor; the exact solution for a current held over the step.
    pub fn advance(&mut self, power_w: f64, dt_s: f64) {
        let SupplyParameters { voltage_v, source_resistance_ohm, capacitance_f } = self.parameters;
        let drawn_a = power_w / self.bus_voltage_v.max(1.0);
        let fed_v = voltage_v - drawn_a * source_resistance_ohm;
        let conducts = self.bus_voltage_v < voltage_v || (self.bus_voltage_v == voltage_v && drawn_a > 0.0);
        let next = if conducts {
            let decay = self.decay.over(dt_s, source_resistance_ohm * capacitance_f);
            fed_v + (self.bus_voltage_v - fed_v) * decay
        } else {
            self.bus_voltage_v - drawn_a * dt_s / capacitance_f // the diode blocks
        };
        let next = next.max(0.0);
        if libm::fabs(next - self.bus_voltage_v) > RESOLUTION_V {
            self.bus_voltage_v = next;
        }
        self.source_current_a = ((voltage_v - self.bus_voltage_v) / source_resistance_ohm).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 50e-6;

    fn settled(power_w: f64) -> Supply {
        let mut supply = Supply::new(SupplyParameters::standard(48.0));
        for _ in 0..1000 {
            supply.advance(power_w, DT_S);
        }
        supply
    }

    #[test]
    fn a_load_pulls_the_bus_down_by_current_times_resistance() {
        let supply = settled(96.0);
        let current_a = supply.source_current_a();
        assert!((supply.bus_voltage_v() - (48.0 - 0.1 * current_a)).abs() < 1e-6);
        assert!((current_a * supply.bus_voltage_v() - 96.0).abs() < 0.01, "{current_a}");
    }

    #[test]
    fn braking_raises_the_bus_by_the_energy_fed_back() {
        let mut supply = settled(0.0);
        for _ in 0..2000 {
            supply.advance(-10.0, DT_S); // 1 J in all
        }
        let raised = 0.5 * 2200e-6 * (supply.bus_voltage_v().powi(2) - 48.0_f64.powi(2));
        assert!((raised - 1.0).abs() < 0.01, "{raised} J");
        assert_eq!(supply.source_current_a(), 0.0);
    }

    #[test]
    fn it_comes_to_rest() {
        let mut supply = settled(20.0);
        let before = supply;
        supply.advance(20.0, DT_S);
        assert_eq!(supply, before);
    }
}
