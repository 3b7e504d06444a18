//! How the currents change, in the rotor's frame.

use super::PmsmParameters;
use super::bridge::{Connection, axis};
use super::frame::dot;
use crate::angle::Direction;

/// Everything about the rates of change of (id, iq) but the voltage.
pub(super) struct CurrentSlopes {
    inductances_h: [f64; 2],
    /// What the voltage has to overcome: resistance, coupling of the axes, and the voltage that the magnets induce.
    opposing_v: [f64; 2],
    /// How fast a current vector that stands in the rotor's frame changes in the stator's, seen from the rotor.
    turning_a_per_s: [f64; 2],
}

impl CurrentSlopes {
    pub(super) fn new(motor: &PmsmParameters, [d, q]: [f64; 2], velocity_rad_s: f64) -> Self {
        let &PmsmParameters { resistance_ohm, d_inductance_h, q_inductance_h, .. } = motor;
        let electrical_rad_s = motor.pole_pairs * velocity_rad_s;
        Self {
            inductances_h: [d_inductance_h, q_inductance_h],
            opposing_v: [
                resistance_ohm * d - electrical_rad_s * q_inductance_h * q,
                resistance_ohm * q + electrical_rad_s * (d_inductance_h * d + motor.flux_linkage_wb),
            ],
            turning_a_per_s: [-electrical_rad_s * q, electrical_rad_s * d],
        }
    }

    /// (did/dt, diq/dt) under a voltage in the rotor's frame.
    pub(super) fn under(&self, [voltage_d, voltage_q]: [f64; 2]) -> [f64; 2] {
        let [opposing_d, opposing_q] = self.opposing_v;
        let [inductance_d, inductance_q] = self.inductances_h;
        [(voltage_d - opposing_d) / inductance_d, (voltage_q - opposing_q) / inductance_q]
    }

    /// The voltage that a connection puts on the motor, in the rotor's frame; `None` if it carries nothing.
    pub(super) fn voltage(&self, connection: Connection, rotor: Direction) -> Option<[f64; 2]> {
        match connection {
            Connection::Closed(voltage) => Some(rotor.to_rotor(voltage)),
            Connection::OpenPhase(phase, voltage) => {
                let open = self.open_phase_v(phase, voltage, rotor);
                let [along_d, along_q] = rotor.to_rotor(axis(phase));
                let [voltage_d, voltage_q] = rotor.to_rotor(voltage);
                Some([voltage_d + open * along_d, voltage_q + open * along_q])
            }
            Connection::Open => None,
        }
    }

    /// The voltage between an open phase's terminal and the star point: that which leaves its current at zero.
    pub(super) fn open_phase_v(&self, phase: usize, voltage: [f64; 2], rotor: Direction) -> f64 {
        let along = rotor.to_rotor(axis(phase));
        let [slope_d, slope_q] = self.under(rotor.to_rotor(voltage));
        let [turning_d, turning_q] = self.turning_a_per_s;
        let [inductance_d, inductance_q] = self.inductances_h;
        let [along_d, along_q] = along;
        let slope_per_v = dot(along, [along_d / inductance_d, along_q / inductance_q]);
        -dot(along, [slope_d + turning_d, slope_q + turning_q]) / slope_per_v
    }

    /// What the magnets induce in a motor without current, in the rotor's frame.
    pub(super) fn opposing_v(&self) -> [f64; 2] {
        self.opposing_v
    }
}
