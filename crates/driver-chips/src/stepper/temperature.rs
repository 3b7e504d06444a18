//! The two-level temperature sensor of the bridges.

/// Where the sensor's comparators switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levels {
    /// The pre-warning begins.
    pub(crate) warning_c: f64,
    /// It ends below this.
    pub(crate) warning_end_c: f64,
    /// The bridges are switched off.
    pub(crate) shutdown_c: f64,
    /// They stay off until the chip is colder than this.
    pub(crate) shutdown_end_c: f64,
}

/// The comparators' states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Temperature {
    /// OTPW.
    pub(crate) warning: bool,
    /// OT.
    pub(crate) shutdown: bool,
}

impl Temperature {
    pub(crate) fn update(&mut self, temperature_c: f64, levels: &Levels) {
        self.warning = temperature_c >= if self.warning { levels.warning_end_c } else { levels.warning_c };
        self.shutdown =
            temperature_c >= if self.shutdown { levels.shutdown_end_c } else { levels.shutdown_c };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_levels_have_a_hysteresis() {
        let levels =
            Levels { warning_c: 100.0, warning_end_c: 95.0, shutdown_c: 150.0, shutdown_end_c: 120.0 };
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
            temperature.update(at_c, &levels);
            assert_eq!(temperature, Temperature { warning, shutdown }, "at {at_c} °C");
        }
    }
}
