//! What the TMCM-1311's firmware is told, and what it commands.

use super::driver::{ChipSettings, DriverStatus};

/// What the module's sensors say, once a control period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sensed {
    /// The raw encoder count, which nothing but the shaft changes.
    pub encoder_counts: i32,
    /// Whether the encoder's index passed since the last control period.
    pub encoder_index: bool,
    /// Whether the contact of the left stop switch is open.
    pub left_switch_open: bool,
    /// Whether the contact of the right stop switch is open.
    pub right_switch_open: bool,
    /// Pulses on STEP since the last control period, signed by DIR: positive is to the right and increases the position.
    pub steps: i32,
    /// Whether the ENABLE input of the step/direction connector is active; it is not while nothing is connected (decision).
    pub enabled: bool,
    /// IN_1 to IN_3 and IN_5 to IN_7 as bits 1 to 3 and 5 to 7; 1 = high.
    pub inputs: u8,
    /// AIN_0 and AIN_4: 0 to 4095 for 0 to 10 V.
    pub analog_inputs: [u16; 2],
    /// Currents in coil A and coil B.
    pub coil_currents_ma: [i16; 2],
    /// Supply voltage in tenths of a volt.
    pub supply_voltage_dv: u16,
    /// Current drawn from the supply.
    pub supply_current_ma: u16,
    /// Temperature of the board.
    pub temperature_c: i16,
    /// What the driver chip reports.
    pub driver: DriverStatus,
}

/// What the power stage and the outputs shall do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drive {
    /// Coil currents A and B, signed, in 1/248 of the current scale.
    pub coils: [i16; 2],
    /// The rest of what the driver chip is told.
    pub chip: ChipSettings,
    /// OUT_0 to OUT_7; 1 = on.
    pub outputs: u8,
}
