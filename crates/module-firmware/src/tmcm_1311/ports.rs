//! Inputs and outputs (TMCM-1311 §5.7.14, §5.7.15).

use super::{Port, Tmcm1311};

/// Reading from which an analogue input counts as high when it is read as a digital one: 5 V of 10 V. The manual gives no
/// threshold.
const DIGITAL_THRESHOLD: u16 = 2048;

impl Tmcm1311 {
    /// What GIO reads.
    pub(super) fn port_level(&self, port: Port) -> i32 {
        let sensed = &self.sensed;
        let [ain_0, ain_4] = sensed.analog_inputs;
        let [coil_a, coil_b] = sensed.coil_currents_ma;
        let input = |bit: u8| i32::from((sensed.inputs >> bit) & 1);
        let output = |bit: u8| i32::from((self.outputs >> bit) & 1);
        match port {
            Port::In0 => i32::from(ain_0 >= DIGITAL_THRESHOLD),
            Port::In1 => input(1),
            Port::In2 => input(2),
            Port::In3 => input(3),
            Port::In4 => i32::from(ain_4 >= DIGITAL_THRESHOLD),
            Port::In5 => input(5),
            Port::In6 => input(6),
            Port::In7 => input(7),
            Port::Ain0 => i32::from(ain_0),
            Port::Ain4 => i32::from(ain_4),
            Port::SupplyVoltage => i32::from(sensed.supply_voltage_dv),
            Port::ModuleTemperature => i32::from(sensed.temperature_c),
            Port::PhaseACurrent => i32::from(coil_a),
            Port::PhaseBCurrent => i32::from(coil_b),
            Port::DcCurrent => i32::from(sensed.supply_current_ma),
            Port::Out0 => output(0),
            Port::Out1 => output(1),
            Port::Out2 => output(2),
            Port::Out3 => output(3),
            Port::Out4 => output(4),
            Port::Out5 => output(5),
            Port::Out6 => output(6),
            Port::Out7 => output(7),
        }
    }

    /// What SIO switches; inputs stay as they are.
    pub(super) fn set_port(&mut self, port: Port, high: bool) {
        let bit: u8 = match port {
            Port::Out0 => 1 << 0,
            Port::Out1 => 1 << 1,
            Port::Out2 => 1 << 2,
            Port::Out3 => 1 << 3,
            Port::Out4 => 1 << 4,
            Port::Out5 => 1 << 5,
            Port::Out6 => 1 << 6,
            Port::Out7 => 1 << 7,
            Port::In0
            | Port::In1
            | Port::In2
            | Port::In3
            | Port::In4
            | Port::In5
            | Port::In6
            | Port::In7
            | Port::Ain0
            | Port::Ain4
            | Port::SupplyVoltage
            | Port::ModuleTemperature
            | Port::PhaseACurrent
            | Port::PhaseBCurrent
            | Port::DcCurrent => 0,
        };
        self.outputs = if high { self.outputs | bit } else { self.outputs & !bit };
    }
}
