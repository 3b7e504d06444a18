//! Inputs and the output (§4.6.13).

use super::{Port, Tmcm1640};

impl Tmcm1640 {
    /// What GIO reads.
    pub(super) fn port_level(&self, port: Port) -> i32 {
        let input = |bit: u8| i32::from((self.sensed.inputs >> bit) & 1);
        match port {
            Port::In0 => input(0),
            Port::In1 => input(1),
            Port::Ain0 => i32::from(self.sensed.analog_input),
            Port::Out0 => i32::from(self.output),
        }
    }

    /// What SIO switches; inputs stay as they are.
    pub(super) fn set_port(&mut self, port: Port, high: bool) {
        match port {
            Port::Out0 => self.output = high,
            Port::In0 | Port::In1 | Port::Ain0 => {}
        }
    }
}
