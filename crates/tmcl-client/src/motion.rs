//! Motion (TMCM-1311 §5.7.1 to §5.7.4).
//!
//! Velocities and positions have the units of the module's axis parameters 2 and 0.

use tmcl_link::Link;
use tmcl_tables::Command;

use crate::{Client, ClientError, MOTOR};

/// Type of MVP: to a position.
const ABSOLUTE: u8 = 0;

/// Type of MVP: by a distance.
const RELATIVE: u8 = 1;

impl<L: Link> Client<L> {
    /// Turns the motor at `velocity`, the position counting up when it is positive (ROR).
    ///
    /// # Errors
    /// As [`Client::request`]; status 4 when the velocity is out of range.
    pub fn rotate(&mut self, velocity: i32) -> Result<(), ClientError> {
        self.execute(Command::RotateRight, 0, MOTOR, velocity).map(drop)
    }

    /// Slows the motor down to standstill (MST). Does not wait for it.
    ///
    /// # Errors
    /// As [`Client::request`].
    pub fn stop_motor(&mut self) -> Result<(), ClientError> {
        self.execute(Command::MotorStop, 0, MOTOR, 0).map(drop)
    }

    /// Moves to `position` (MVP ABS). Does not wait for it; axis parameter 8 says when the motor is there.
    ///
    /// # Errors
    /// As [`Client::request`]. The tables let no MVP be sent again, so a lost reply is [`ClientError::NoReply`] at once.
    pub fn move_to(&mut self, position: i32) -> Result<(), ClientError> {
        self.execute(Command::MoveToPosition, ABSOLUTE, MOTOR, position).map(drop)
    }

    /// Moves by `distance` (MVP REL). Does not wait for the end of it.
    ///
    /// # Errors
    /// As [`Client::move_to`].
    pub fn move_by(&mut self, distance: i32) -> Result<(), ClientError> {
        self.execute(Command::MoveToPosition, RELATIVE, MOTOR, distance).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_the_tables() {
        let type_of = |id: &str| {
            let types = Command::MoveToPosition.spec().types;
            types.iter().find(|named| named.id == id).map(|named| named.value)
        };
        assert_eq!((type_of("absolute"), type_of("relative")), (Some(ABSOLUTE), Some(RELATIVE)));
    }
}
