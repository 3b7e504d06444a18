//! The two-level temperature sensor (datasheet, "Temperature Sensors").

/// Pre-warning.
const WARNING_C: f64 = 100.0;

/// The pre-warning ends 5 K lower (decision: the datasheet gives no hysteresis for it).
const WARNING_END_C: f64 = 95.0;

/// Shutdown.
const SHUTDOWN_C: f64 = 150.0;

/// The bridges stay off until the chip is colder than this (the TMC262C's release level).
const SHUTDOWN_END_C: f64 = 120.0;

/// The comparators' states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Temperature {
    /// OTPW.
    pub(super) warning: bool,
    /// OT.
    pub(super) shutdown: bool,
}

impl Temperature {
    pub(super) fn update(&mut self, temperature_c: f64) {
        self.warning = temperature_c >= if self.warning { WARNING_END_C } else { WARNING_C };
        self.shutdown = temperature_c >= if self.shutdown { SHUTDOWN_END_C } else { SHUTDOWN_C };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_levels_have_a_hysteresis() {
        let mut temperature = Temperature::default();
        for (at_c, warning, shutdown) in [
            (99.9, false, false),
            (100.0, true, false),
            (149.9, true, false),
            (150.0, true, true),
            (120.0, true, true),
            (119.9, true, false),
            (95.0, true, false),
            (94.9, false, false),
            (99.9, false, false),
        ] {
            temperature.update(at_c);
            assert_eq!(temperature, Temperature { warning, shutdown }, "at {at_c} °C");
        }
    }
}
