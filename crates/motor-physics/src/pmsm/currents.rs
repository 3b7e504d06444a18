//! How the currents change, in the rotor's frame.

use super::PmsmParameters;
use super::bridge::{Connection, axis};
use super::frame::dot;
use crate::angle::Direction;

/// What the equations of the currents take from the datasheet.
#[derive(Clone, Copy)]
pub(super) struct Windings {
    pub(super) resistance_ohm: f64,
    /// Along the magnets and across them.
    inductances_h: [f64; 2],
    per_inductances: [f64; 2],
    flux_linkage_wb: f64,
    pub(super) pole_pairs: f64,
}

impl Windings {
    pub(super) fn of(motor: &PmsmParameters) -> Self {
        let inductances_h = [motor.d_inductance_h, motor.q_inductance_h];
        Self {
            resistance_ohm: motor.resistance_ohm,
            inductances_h,
            per_inductances: inductances_h.map(|inductance_h| 1.0 / inductance_h),
            flux_linkage_wb: motor.flux_linkage_wb,
            pole_pairs: motor.pole_pairs,
        }
    }
}

/// Everything about the rates of change of (id, iq) but the voltage.
pub(super) struct CurrentSlopes {
    per_inductances: [f64; 2],
    /// What the voltage has to overcome: resistance, coupling of the axes, and the voltage that the magnets induce.
    opposing_v: [f64; 2],
    /// How fast a current vector that stands in the rotor's frame changes in the stator's, seen from the rotor.
    turning_a_per_s: [f64; 2],
}

impl CurrentSlopes {
    #[inline]
    pub(super) fn new(windings: &Windings, [d, q]: [f64; 2], velocity_rad_s: f64) -> Self {
        let &Windings { resistance_ohm, per_inductances, .. } = windings;
        let [d_inductance_h, q_inductance_h] = windings.inductances_h;
        let electrical_rad_s = windings.pole_pairs * velocity_rad_s;
        Self {
            per_inductances,
            opposing_v: [
                resistance_ohm * d - electrical_rad_s * q_inductance_h * q,
                resistance_ohm * q + electrical_rad_s * (d_inductance_h * d + windings.flux_linkage_wb),
            ],
            turning_a_per_s: [-electrical_rad_s * q, electrical_rad_s * d],
        }
    }

    /// (did/dt, diq/dt) under a voltage in the rotor's frame.
    #[inline]
    pub(super) fn under(&self, [voltage_d, voltage_q]: [f64; 2]) -> [f64; 2] {
        let [opposing_d, opposing_q] = self.opposing_v;
        let [per_d, per_q] = self.per_inductances;
        [(voltage_d - opposing_d) * per_d, (voltage_q - opposing_q) * per_q]
    }

    /// The voltage between the terminals and the star point, in the rotor's frame.
    pub(super) fn voltage(&self, connection: Connection, rotor: Direction) -> [f64; 2] {
        match connection {
            Connection::Closed(voltage) => rotor.to_rotor(voltage),
            Connection::OpenPhase(phase, voltage) => {
                let open = self.open_phase_v(phase, voltage, rotor);
                let [along_d, along_q] = rotor.to_rotor(axis(phase));
                let [voltage_d, voltage_q] = rotor.to_rotor(voltage);
                [voltage_d + open * along_d, voltage_q + open * along_q]
            }
            // What the magnets induce: nothing flows, and nothing begins to.
            Connection::Open => self.opposing_v,
        }
    }

    /// The voltage between an open phase's terminal and the star point: that which leaves its current at zero.
    pub(super) fn open_phase_v(&self, phase: usize, voltage: [f64; 2], rotor: Direction) -> f64 {
        let along = rotor.to_rotor(axis(phase));
        let [slope_d, slope_q] = self.under(rotor.to_rotor(voltage));
        let [turning_d, turning_q] = self.turning_a_per_s;
        let [per_d, per_q] = self.per_inductances;
        let [along_d, along_q] = along;
        let slope_per_v = dot(along, [along_d * per_d, along_q * per_q]);
        -dot(along, [slope_d + turning_d, slope_q + turning_q]) / slope_per_v
    }

    /// What the magnets induce in a motor without current, in the rotor's frame.
    pub(super) fn opposing_v(&self) -> [f64; 2] {
        self.opposing_v
    }
}
