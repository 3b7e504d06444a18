//! Bodies that warm up: a winding, a board.
//!
//! First order: the heat put in raises the temperature towards `rise_k_per_w` times the power, with one time constant. The
//! motors' resistance and torque do not drift with it (decision).

use crate::pmsm::PmsmParameters;
use crate::stepper::StepperParameters;

/// How far a winding at rated current in both phases ends up above its surroundings (chosen: class B with margin).
const WINDING_RISE_K: f64 = 80.0;

/// A body's thermal resistance and time constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatParameters {
    /// Final rise above the surroundings for each watt.
    pub rise_k_per_w: f64,
    /// Time to 63 % of the final rise.
    pub time_constant_s: f64,
}

impl HeatParameters {
    /// The winding of a stepper: 80 K at rated current in both phases.
    #[must_use]
    pub fn stepper_winding(motor: &StepperParameters) -> Self {
        Self::winding(motor.rated_current_rms_a, motor.resistance_ohm, motor.winding_time_constant_s)
    }

    /// The winding of a brushless motor: 80 K at rated current.
    #[must_use]
    pub fn pmsm_winding(motor: &PmsmParameters) -> Self {
        Self::winding(motor.rated_current_a, motor.resistance_ohm, motor.winding_time_constant_s)
    }

    /// The board under the power stage: 10 K for each watt that the stage loses, within minutes (chosen).
    #[must_use]
    pub const fn board() -> Self {
        Self { rise_k_per_w: 10.0, time_constant_s: 120.0 }
    }

    /// Two phases carry the rated current, in a stepper as in a block-commutated brushless motor.
    fn winding(rated_current_a: f64, resistance_ohm: f64, time_constant_s: f64) -> Self {
        let rated_loss_w = 2.0 * rated_current_a * rated_current_a * resistance_ohm;
        Self { rise_k_per_w: WINDING_RISE_K / rated_loss_w, time_constant_s }
    }
}

/// A body and how warm it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatedBody {
    /// Thermal resistance and time constant.
    pub parameters: HeatParameters,
    /// Temperature above the surroundings.
    pub rise_k: f64,
}

impl HeatedBody {
    /// A body as warm as its surroundings.
    #[must_use]
    pub fn new(parameters: HeatParameters) -> Self {
        Self { parameters, rise_k: 0.0 }
    }

    /// `power_w` of heat for `dt_s`, however long: the exact solution, so that only how the power changes limits the step.
    pub fn advance(&mut self, power_w: f64, dt_s: f64) {
        let HeatParameters { rise_k_per_w, time_constant_s } = self.parameters;
        let final_k = power_w * rise_k_per_w;
        self.rise_k = final_k + (self.rise_k - final_k) * libm::exp(-dt_s / time_constant_s);
    }

    /// Temperature where the surroundings have `ambient_c`.
    #[must_use]
    pub fn temperature_c(&self, ambient_c: f64) -> f64 {
        ambient_c + self.rise_k
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presets;

    #[test]
    fn a_winding_at_rated_current_ends_80_k_warmer() {
        for (name, motor) in presets::STEPPERS {
            let mut winding = HeatedBody::new(HeatParameters::stepper_winding(motor));
            let loss_w = 2.0 * motor.rated_current_rms_a * motor.rated_current_rms_a * motor.resistance_ohm;
            winding.advance(loss_w, motor.winding_time_constant_s);
            assert!((winding.rise_k - 80.0 * (1.0 - libm::exp(-1.0))).abs() < 1e-9, "{name}");
            winding.advance(loss_w, 30.0 * motor.winding_time_constant_s);
            assert!((winding.temperature_c(25.0) - 105.0).abs() < 1e-9, "{name}");
            winding.advance(0.0, 30.0 * motor.winding_time_constant_s);
            assert!(winding.rise_k.abs() < 1e-9, "{name}");
        }
    }

    #[test]
    fn many_short_windows_are_one_long_one() {
        let mut windows = HeatedBody::new(HeatParameters::board());
        let mut whole = windows;
        for _ in 0..1000 {
            windows.advance(4.0, 0.1);
        }
        whole.advance(4.0, 100.0);
        assert!((windows.rise_k - whole.rise_k).abs() < 1e-9);
        assert!((whole.rise_k - 40.0 * (1.0 - libm::exp(-100.0 / 120.0))).abs() < 1e-9);
    }

    #[test]
    fn a_pmsms_copper_loss_at_rated_current_is_that_of_its_current_vector() {
        for (name, motor) in presets::PMSMS {
            let vector_a = 2.0 / libm::sqrt(3.0) * motor.rated_current_a;
            let loss_w = 1.5 * motor.resistance_ohm * vector_a * vector_a;
            let rise_k = HeatParameters::pmsm_winding(motor).rise_k_per_w * loss_w;
            assert!((rise_k - 80.0).abs() < 1e-9, "{name}");
        }
    }
}
