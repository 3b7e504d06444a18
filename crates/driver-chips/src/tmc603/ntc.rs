//! The NTC beside the power stage, and the converter that reads it (TMCM-1640 §8).
//!
//! The manual goes from the reading to the temperature: R = 9011.2 kΩ / ADC − 2.2 kΩ, a divider of 2.2 kΩ and a converter of
//! 12 bits; and T = B · T₀ / (B + T₀ · ln(R / 10 kΩ)), with B = 3434 K and T₀ = 298.16 K. Here it is the other way round.

/// Full scale of the converter.
const READING_MAX: f64 = 4095.0;

/// What the divider and the converter make of 1 kΩ.
const READING_KOHM: f64 = 9011.2;
const SERIES_KOHM: f64 = 2.2;

/// The NTC: its resistance at 25 °C, where that is, and how it falls.
const NOMINAL_KOHM: f64 = 10.0;
const NOMINAL_K: f64 = 298.16;
const B_K: f64 = 3434.0;

/// 0 °C, as the manual has it.
const ZERO_C_K: f64 = 273.16;

/// What the converter reads at a temperature: 0 to 4095, more when it is hotter.
#[must_use]
pub fn ntc_reading(temperature_c: f64) -> u16 {
    let temperature_k = (temperature_c + ZERO_C_K).max(1.0);
    let resistance_kohm = NOMINAL_KOHM * libm::exp(B_K / temperature_k - B_K / NOMINAL_K);
    let reading = READING_KOHM / (resistance_kohm + SERIES_KOHM);
    // The cast saturates, and NaN becomes 0.
    libm::round(reading.min(READING_MAX)) as u16
}
