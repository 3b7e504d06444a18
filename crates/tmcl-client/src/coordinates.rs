//! Coordinates: positions that the module keeps (TMCM-1311 §5.7.24, §5.7.25).

use tmcl_link::Link;
use tmcl_tables::Command;

use crate::{Client, ClientError, MOTOR};

impl<L: Link> Client<L> {
    /// Reads a coordinate (GCO).
    ///
    /// # Errors
    /// As [`Client::request`]; status 4 when there is no such coordinate.
    pub fn get_coordinate(&mut self, number: u8) -> Result<i32, ClientError> {
        self.execute(Command::GetCoordinate, number, MOTOR, 0)
    }

    /// Sets a coordinate to a position (SCO). Where global parameter 84 says so, it is stored too.
    ///
    /// # Errors
    /// As [`Client::request`]; status 4 when there is no such coordinate, 5 when it is to be stored and the EEPROM is locked.
    pub fn set_coordinate(&mut self, number: u8, position: i32) -> Result<(), ClientError> {
        self.execute(Command::SetCoordinate, number, MOTOR, position).map(drop)
    }
}
