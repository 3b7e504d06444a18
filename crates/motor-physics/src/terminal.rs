//! What a power stage does with the ends of a winding.

/// A winding's connection for the time of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Terminal {
    /// A voltage is held across it.
    Driven {
        /// The voltage, signed.
        voltage_v: f64,
    },
    /// Nothing drives it: its current dies away through the freewheeling diodes against the bus voltage, and stays zero.
    Floating {
        /// The bus voltage that opposes what current is left.
        bus_voltage_v: f64,
    },
}
