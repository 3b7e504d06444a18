//! Axis and global parameters (TMCM-1311 §5.7.5 to §5.7.12).
//!
//! Values are the 32 bits that travel; [`tmcl_tables::ParameterSpec::from_wire`] says what they stand for.

use tmcl_link::Link;
use tmcl_tables::Command;

use crate::{Client, ClientError, MOTOR};

impl<L: Link> Client<L> {
    /// Reads an axis parameter (GAP).
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when there is no such parameter, or it cannot be read.
    pub fn get_axis_parameter(&mut self, number: u8) -> Result<i32, ClientError> {
        self.execute(Command::GetAxisParameter, number, MOTOR, 0)
    }

    /// Writes an axis parameter (SAP). Some start a motion.
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when there is no such parameter, or it cannot be written; 4 when the value is out of
    /// range.
    pub fn set_axis_parameter(&mut self, number: u8, value: i32) -> Result<(), ClientError> {
        self.execute(Command::SetAxisParameter, number, MOTOR, value).map(drop)
    }

    /// Stores an axis parameter in the EEPROM (STAP).
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when it cannot be stored, 5 when the EEPROM is locked.
    pub fn store_axis_parameter(&mut self, number: u8) -> Result<(), ClientError> {
        self.execute(Command::StoreAxisParameter, number, MOTOR, 0).map(drop)
    }

    /// Sets an axis parameter back to what the EEPROM holds (RSAP).
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when it cannot be stored.
    pub fn restore_axis_parameter(&mut self, number: u8) -> Result<(), ClientError> {
        self.execute(Command::RestoreAxisParameter, number, MOTOR, 0).map(drop)
    }

    /// Reads a global parameter (GGP).
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when there is no such bank or parameter.
    pub fn get_global_parameter(&mut self, bank: u8, number: u8) -> Result<i32, ClientError> {
        self.execute(Command::GetGlobalParameter, number, bank, 0)
    }

    /// Writes a global parameter (SGP). A new address or baud rate takes effect after the reply; [`Client::settings_mut`]
    /// follows it.
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when there is no such bank or parameter, 4 when the value is out of range, 5 when
    /// the EEPROM is locked.
    pub fn set_global_parameter(&mut self, bank: u8, number: u8, value: i32) -> Result<(), ClientError> {
        self.execute(Command::SetGlobalParameter, number, bank, value).map(drop)
    }

    /// Stores a user variable in the EEPROM (STGP).
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when it cannot be stored, 5 when the EEPROM is locked.
    pub fn store_global_parameter(&mut self, bank: u8, number: u8) -> Result<(), ClientError> {
        self.execute(Command::StoreGlobalParameter, number, bank, 0).map(drop)
    }

    /// Sets a user variable back to what the EEPROM holds (RSGP).
    ///
    /// # Errors
    /// As [`Client::request`]; status 3 when it cannot be stored.
    pub fn restore_global_parameter(&mut self, bank: u8, number: u8) -> Result<(), ClientError> {
        self.execute(Command::RestoreGlobalParameter, number, bank, 0).map(drop)
    }
}
