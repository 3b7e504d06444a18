//! Inputs and outputs (TMCM-1311 §5.7.14, §5.7.15).

use tmcl_link::Link;
use tmcl_tables::Command;

use crate::{Client, ClientError};

/// The bank of outputs.
const OUTPUTS: u8 = 2;

impl<L: Link> Client<L> {
    /// Switches an output of bank 2 (SIO): 0 off, 1 on. Port 255 sets all of them, a bit of `value` each.
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when there is no such output, 4 when it cannot take this value.
    pub fn set_output(&mut self, port: u8, value: i32) -> Result<(), ClientError> {
        self.execute(Command::SetOutput, port, OUTPUTS, value).map(drop)
    }

    /// Reads a port (GIO): of bank 0 a digital input, of bank 1 an analogue one, of bank 2 the state of an output. Port 255 of
    /// bank 0 reads all digital inputs, a bit each.
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when there is no such port.
    pub fn get_input(&mut self, bank: u8, port: u8) -> Result<i32, ClientError> {
        self.execute(Command::GetInput, port, bank, 0)
    }
}

#[cfg(test)]
mod tests {
    use tmcl_tables::{Direction, MODULES};

    use super::*;

    #[test]
    fn outputs_are_where_the_tables_have_them() {
        for spec in MODULES {
            for port in spec.ports.iter().filter(|port| port.direction == Direction::Output) {
                assert_eq!(port.bank, OUTPUTS, "{}", port.name);
            }
        }
    }
}
