//! What a CAN bus carries.

use std::fmt;

/// The greatest identifier of 11 bits.
pub const MAX_ID: u16 = 0x7FF;

/// Why there is no such frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// The identifier needs more than 11 bits.
    #[error("{0:#x} is no CAN identifier: 11 bits go from 0 to 0x7ff")]
    Id(u16),
    /// A frame has no room for so much.
    #[error("{0} bytes do not fit in a CAN frame: it carries 8 at most")]
    Length(usize),
}

/// The data of a frame: no byte to eight.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Data {
    /// Zero behind the end, so that equal data are equal.
    bytes: [u8; 8],
    length: usize,
}

impl Data {
    /// These bytes.
    ///
    /// # Errors
    /// [`FrameError::Length`] when there are more than eight.
    pub fn new(bytes: &[u8]) -> Result<Self, FrameError> {
        let mut data = Self { bytes: [0; 8], length: bytes.len() };
        data.bytes.get_mut(..bytes.len()).ok_or(FrameError::Length(bytes.len()))?.copy_from_slice(bytes);
        Ok(data)
    }

    /// The bytes.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

impl fmt::Debug for Data {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02x?}", self.as_slice())
    }
}

/// A data frame with an 11-bit identifier, the only kind that TMCL uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CanFrame {
    id: u16,
    data: Data,
}

impl CanFrame {
    /// A frame with this identifier, 0 to [`MAX_ID`], and up to eight bytes.
    ///
    /// # Errors
    /// [`FrameError`] when the identifier has more than 11 bits, or there are more than eight bytes.
    pub fn new(id: u16, data: &[u8]) -> Result<Self, FrameError> {
        if id > MAX_ID {
            return Err(FrameError::Id(id));
        }
        Ok(Self { id, data: Data::new(data)? })
    }

    /// The identifier, 0 to [`MAX_ID`].
    #[must_use]
    pub fn id(&self) -> u16 {
        self.id
    }

    /// The bytes, eight at most.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.data.as_slice()
    }
}

/// As candump writes it: `001#06010000000000`.
impl fmt::Display for CanFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:03X}#", self.id)?;
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_holds_what_it_was_given() {
        for length in 0..=8 {
            let bytes = &[1, 2, 3, 4, 5, 6, 7, 8][..length];
            let frame = CanFrame::new(MAX_ID, bytes).expect("it fits");
            assert_eq!((frame.id(), frame.data()), (MAX_ID, bytes));
        }
        let frame = CanFrame::new(1, &[6, 1, 0, 0, 0, 0, 0xAB]).expect("it fits");
        assert_eq!(frame.to_string(), "001#060100000000AB");
    }

    #[test]
    fn what_does_not_fit_is_refused_by_name() {
        assert_eq!(CanFrame::new(0x800, &[]), Err(FrameError::Id(0x800)));
        assert_eq!(CanFrame::new(0, &[0; 9]), Err(FrameError::Length(9)));
        assert_eq!(
            FrameError::Id(0x800).to_string(),
            "0x800 is no CAN identifier: 11 bits go from 0 to 0x7ff"
        );
        assert_eq!(
            FrameError::Length(9).to_string(),
            "9 bytes do not fit in a CAN frame: it carries 8 at most"
        );
    }
}
