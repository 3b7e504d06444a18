//! Coordinates: positions that the module keeps (TMCM-1311 §5.7.24, §5.7.25).

use tmcl_link::Link;
use tmcl_tables::Command;

use crate::{Client, ClientError, MOTOR};

/// In place of the motor: between RAM and EEPROM.
const EEPROM: u8 = 255;

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

    /// Copies a coordinate from 1 to 20 into the EEPROM, or all of these with 0 (SCO, motor 255).
    ///
    /// # Errors
    /// As [`Client::request`]; status 4 when there is no such coordinate, 5 when the EEPROM is locked.
    pub fn store_coordinate(&mut self, number: u8) -> Result<(), ClientError> {
        self.execute(Command::SetCoordinate, number, EEPROM, 0).map(drop)
    }

    /// Copies a coordinate from 1 to 20 back from the EEPROM, or all of these with 0 (GCO, motor 255).
    ///
    /// # Errors
    /// As [`Client::request`]; status 4 when there is no such coordinate.
    pub fn restore_coordinate(&mut self, number: u8) -> Result<(), ClientError> {
        self.execute(Command::GetCoordinate, number, EEPROM, 0).map(drop)
    }
}
