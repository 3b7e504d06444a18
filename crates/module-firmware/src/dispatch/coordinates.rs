//! SCO, GCO, CCO and ACO (TMCM-1311 §5.7.24 to §5.7.27).

use tmcl_tables::{GlobalParameter, Status};
use tmcl_wire::Request;

use super::{COORDINATES_IN_EEPROM, Executed, Outcome};
use crate::axis::Axis;
use crate::coordinates;
use crate::firmware::Firmware;
use crate::jobs::Job;
use crate::storage::RecordKey;

impl<A: Axis> Firmware<A> {
    pub(super) fn set_coordinate(&mut self, request: &Request) -> Executed {
        let &Request { kind, motor, value, .. } = request;
        if motor == COORDINATES_IN_EEPROM {
            let (next, last) = coordinates_to_copy(kind)?;
            self.unlocked()?;
            return Ok(Outcome::Job(Job::StoreCoordinates { next, last }, value));
        }
        self.write_coordinate(kind, value, value)
    }

    pub(super) fn get_coordinate(&self, request: &Request) -> Executed {
        let &Request { kind, motor, value, .. } = request;
        if motor == COORDINATES_IN_EEPROM {
            let (first, last) = coordinates_to_copy(kind)?;
            return Ok(Outcome::Job(Job::RestoreCoordinates { first, last }, value));
        }
        Ok(Outcome::Done(self.coordinates.get(coordinate_number(kind)?)))
    }

    /// Sets a coordinate, and writes it through where global parameter 84 says so; coordinate 0 never is.
    pub(super) fn write_coordinate(&mut self, number: u8, position: i32, answer: i32) -> Executed {
        let number = coordinate_number(number)?;
        let through = number != 0 && self.globals.setting(GlobalParameter::CoordinateStorage) != 0;
        if through {
            self.unlocked()?;
        }
        self.coordinates.set(number, position);
        if through {
            return Ok(Outcome::Job(Job::Write(RecordKey::Coordinate(number), position), answer));
        }
        Ok(Outcome::Done(answer))
    }
}

pub(super) fn coordinate_number(number: u8) -> Result<u8, Status> {
    if number < coordinates::COUNT { Ok(number) } else { Err(Status::InvalidValue) }
}

/// The EEPROM forms of SCO and GCO: 0 stands for all but coordinate 0.
fn coordinates_to_copy(number: u8) -> Result<(u8, u8), Status> {
    match coordinate_number(number)? {
        0 => Ok((1, coordinates::COUNT - 1)),
        number => Ok((number, number)),
    }
}
