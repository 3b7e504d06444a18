//! What the TMCM-1640's firmware is told, and what it commands.

/// What the module's sensors say, once a control period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sensed {
    /// Currents into phases U, V and W.
    pub phase_currents_ma: [i16; 3],
    /// The hall sensors' lines, H1 in bit 0.
    pub halls: u8,
    /// The raw encoder count, which nothing but the shaft changes; rises to the right as the default motor is wired.
    pub encoder_counts: i32,
    /// Whether the encoder's N channel passed since the last control period.
    pub encoder_index: bool,
    /// Supply voltage in tenths of a volt.
    pub supply_voltage_dv: u16,
    /// What the converter reads at the driver's NTC: 0 to 4095 (TMCM-1640 §8).
    pub driver_temperature_adc: u16,
    /// Whether the TMC603 reports an error: a short, an overcurrent, or too little voltage for its gates.
    pub driver_error: bool,
    /// IN_0 and IN_1 as bits 0 and 1; 1 = high.
    pub inputs: u8,
    /// AIN: 0 to 4095 for 0 to 10 V.
    pub analog_input: u16,
}

/// A whole PWM period, in the unit of [`Drive::duties`].
pub const PWM_PERIOD: u16 = 32_768;

/// What the power stage and the output shall do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drive {
    /// For how much of the PWM period the upper transistor of phases U, V and W is on: 0 to [`PWM_PERIOD`].
    pub duties: [u16; 3],
    /// Whether the power stage is on at all; off, no transistor is.
    pub enabled: bool,
    /// OUT_0; true = on.
    pub output: bool,
}
