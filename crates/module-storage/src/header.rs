//! What stands before the program: that the media are formatted, and which erasure is under way.
//!
//! Erasing takes many writes. A note made before and taken away after them tells the next power-on to finish what a power
//! failure interrupted, so that a part reads as it was or as erased, never as half of it.

use embedded_storage::Storage as ByteStorage;
use module_firmware::StorageError;

/// Bytes that the header takes.
pub(crate) const BYTES: u32 = 16;

/// Stands first once the media are formatted; the digit is that of the layout.
const FORMATTED: [u8; 5] = *b"TMCL1";

/// The note of an erasure under way.
const UNDER_WAY: u8 = 0xE5;
const DONE: u8 = 0;

/// What can be erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Every record.
    Records,
    /// The program.
    Program,
}

impl Part {
    const fn offset(self) -> u32 {
        match self {
            Self::Records => 5,
            Self::Program => 6,
        }
    }
}

/// The header as it was read.
pub(crate) struct Header {
    formatted: [u8; 5],
    records: u8,
    program: u8,
}

impl Header {
    pub(crate) fn read(eeprom: &mut impl ByteStorage) -> Result<Self, StorageError> {
        let mut bytes = [0; 7];
        eeprom.read(0, &mut bytes).map_err(|_| StorageError::Medium)?;
        let [a, b, c, d, e, records, program] = bytes;
        Ok(Self { formatted: [a, b, c, d, e], records, program })
    }

    pub(crate) fn is_formatted(&self) -> bool {
        self.formatted == FORMATTED
    }

    pub(crate) fn is_unfinished(&self, part: Part) -> bool {
        UNDER_WAY
            == match part {
                Part::Records => self.records,
                Part::Program => self.program,
            }
    }

    /// Notes that everything is formatted; until then it is not.
    pub(crate) fn format(eeprom: &mut impl ByteStorage) -> Result<(), StorageError> {
        for part in [Part::Records, Part::Program] {
            Self::finish(eeprom, part)?;
        }
        eeprom.write(0, &FORMATTED).map_err(|_| StorageError::Medium)
    }

    pub(crate) fn begin(eeprom: &mut impl ByteStorage, part: Part) -> Result<(), StorageError> {
        eeprom.write(part.offset(), &[UNDER_WAY]).map_err(|_| StorageError::Medium)
    }

    pub(crate) fn finish(eeprom: &mut impl ByteStorage, part: Part) -> Result<(), StorageError> {
        eeprom.write(part.offset(), &[DONE]).map_err(|_| StorageError::Medium)
    }
}
