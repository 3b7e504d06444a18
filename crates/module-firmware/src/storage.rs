//! What the firmware asks of a non-volatile memory: small records, each written whole or not at all, and a program.

use crate::program_memory::Instruction;

/// Names a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RecordKey {
    /// A stored axis parameter.
    Axis(u8),
    /// A stored global parameter: bank and number.
    Global(u8, u8),
    /// A stored coordinate.
    Coordinate(u8),
}

impl RecordKey {
    /// The key as a number, for media that want one.
    #[must_use]
    pub const fn to_u16(self) -> u16 {
        let (kind, number) = match self {
            Self::Axis(number) => (1, number),
            Self::Coordinate(number) => (2, number),
            Self::Global(bank, number) => (0x10 | (bank & 0x0F), number),
        };
        u16::from_be_bytes([kind, number])
    }
}

/// Why a record could not be read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StorageError {
    /// The medium is full.
    #[error("no room for another record")]
    Full,
    /// The medium failed, or what it holds is damaged.
    #[error("the storage medium failed")]
    Medium,
}

/// A non-volatile memory of records.
///
/// A write is atomic under power loss: afterwards the record holds its old or its new value, whole.
pub trait Storage {
    /// Copies a record to `out` and returns its length; 0 when there is none of that key.
    ///
    /// # Errors
    /// [`StorageError::Medium`] when the record cannot be read.
    fn read(&mut self, key: RecordKey, out: &mut [u8]) -> Result<usize, StorageError>;
    /// Writes a record.
    ///
    /// # Errors
    /// [`StorageError`] when it cannot be written; then the old one stands.
    fn write(&mut self, key: RecordKey, value: &[u8]) -> Result<(), StorageError>;
    /// Removes every record; the program stays.
    ///
    /// # Errors
    /// [`StorageError::Medium`] when the medium fails.
    fn erase(&mut self) -> Result<(), StorageError>;
    /// Copies the program memory to `out`, which holds erased instructions where the medium has none.
    ///
    /// # Errors
    /// [`StorageError::Medium`] when it cannot be read.
    fn read_program(&mut self, out: &mut [Instruction]) -> Result<(), StorageError>;
    /// Writes an instruction to the program memory.
    ///
    /// # Errors
    /// [`StorageError`] when it cannot be written; then the old one stands.
    fn write_instruction(&mut self, address: u16, instruction: Instruction) -> Result<(), StorageError>;
    /// Makes the program memory read as erased.
    ///
    /// # Errors
    /// [`StorageError::Medium`] when the medium fails.
    fn erase_program(&mut self) -> Result<(), StorageError>;
}

/// A record that holds a 32-bit value, or `None` where there is no such record or it cannot be read.
pub(crate) fn read_value(storage: &mut impl Storage, key: RecordKey) -> Option<i32> {
    let mut bytes = [0; 4];
    match storage.read(key, &mut bytes) {
        Ok(4) => Some(i32::from_le_bytes(bytes)),
        Ok(_) | Err(_) => None,
    }
}

/// Writes a record that holds a 32-bit value.
pub(crate) fn write_value(
    storage: &mut impl Storage,
    key: RecordKey,
    value: i32,
) -> Result<(), StorageError> {
    storage.write(key, &value.to_le_bytes())
}
