//! The CAN form: a request of seven bytes, its address in the CAN identifier (TMCM-1311 §4.1, §4.2).
//!
//! Some hosts send the checksum along as an eighth byte. Such requests are taken too, and the reply has the length of the
//! request (decisions of the project, "Wire"). CAN has a checksum of its own, so the eighth byte is not judged.

use tmcl_tables::Status;

use crate::serial::checksum;
use crate::{Reply, Request};

/// The data of a CAN frame: up to eight bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Data {
    /// Zero behind the end, so that equal data are equal.
    bytes: [u8; 8],
    length: usize,
}

impl Data {
    /// The most a frame carries.
    pub const MAX_LENGTH: usize = 8;

    /// These bytes; None when there are more than eight.
    #[must_use]
    pub fn new(bytes: &[u8]) -> Option<Self> {
        let mut data = Self { bytes: [0; Self::MAX_LENGTH], length: bytes.len() };
        data.bytes.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(data)
    }

    /// The bytes.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&self.bytes)
    }
}

/// A data frame with a standard identifier of 11 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The identifier: 0 to 2047. A module hears its own (global parameters 71 and 83) and answers under another (70).
    pub id: u16,
    /// What it carries.
    pub data: Data,
}

impl Frame {
    /// A frame; None when it would carry more than eight bytes.
    #[must_use]
    pub fn new(id: u16, bytes: &[u8]) -> Option<Self> {
        Some(Self { id, data: Data::new(bytes)? })
    }

    /// A request for the module with this identifier, in the plain form.
    #[must_use]
    pub fn request(id: u16, request: Request) -> Self {
        Self { id, data: encode_request(request) }
    }
}

/// How long a frame is, which is how long its reply will be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Length {
    /// Seven bytes: the plain form.
    #[default]
    Seven,
    /// Eight bytes: a checksum rides along.
    Eight,
}

/// Why a frame is no TMCL request or reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// A TMCL request has seven bytes, or eight with a checksum.
    #[error("a TMCL frame has 7 bytes, or 8 with a checksum, but this one has {0}")]
    Length(usize),
    /// The status byte of a reply is none that a manual knows.
    #[error("unknown status code {0}")]
    Status(u8),
}

/// The request in a frame's data.
///
/// # Errors
/// [`FrameError::Length`] when the data is neither seven nor eight bytes.
pub fn decode_request(data: &[u8]) -> Result<(Request, Length), FrameError> {
    match *data {
        [a, b, c, d, e, f, g] => Ok((Request::from_bytes([a, b, c, d, e, f, g]), Length::Seven)),
        [a, b, c, d, e, f, g, _] => Ok((Request::from_bytes([a, b, c, d, e, f, g]), Length::Eight)),
        _ => Err(FrameError::Length(data.len())),
    }
}

/// A request as a frame's data, in the plain form.
#[must_use]
pub fn encode_request(request: Request) -> Data {
    let [a, b, c, d, e, f, g] = request.to_bytes();
    Data { bytes: [a, b, c, d, e, f, g, 0], length: 7 }
}

/// A reply as a frame's data: the module, status, command, value; the host is the frame's identifier.
///
/// The module is the low byte of its identifier (decision: no manual says what stands there).
#[must_use]
pub fn encode_reply(module: u8, reply: Reply, length: Length) -> Data {
    let [a, b, c, d] = reply.value.to_be_bytes();
    sealed([module, reply.status.number(), reply.command, a, b, c, d], length)
}

/// The module, the low byte of its identifier, and its reply in a frame's data. The eighth byte is not judged.
///
/// # Errors
/// [`FrameError`] when the data is neither seven nor eight bytes, or the status is none that a manual knows.
pub fn decode_reply(data: &[u8]) -> Result<(u8, Reply), FrameError> {
    match *data {
        [module, status, command, a, b, c, d] | [module, status, command, a, b, c, d, _] => {
            let status = Status::try_from(status).map_err(FrameError::Status)?;
            Ok((module, Reply { status, command, value: i32::from_be_bytes([a, b, c, d]) }))
        }
        _ => Err(FrameError::Length(data.len())),
    }
}

/// The reply to command 134: the seven bytes of an instruction, and their sum where the request had one. The layout is an
/// inference (decision): no manual prints it.
#[must_use]
pub fn encode_instruction(instruction: [u8; 7], length: Length) -> Data {
    sealed(instruction, length)
}

fn sealed(bytes: [u8; 7], length: Length) -> Data {
    let [a, b, c, d, e, f, g] = bytes;
    let (sum, length) = match length {
        Length::Seven => (0, 7),
        Length::Eight => (checksum(&bytes), 8),
    };
    Data { bytes: [a, b, c, d, e, f, g, sum], length }
}

/// The reply to command 136, type 0: all eight characters (TMCM-1311 §5.7.39).
#[must_use]
pub fn encode_version_string(version: [u8; 8]) -> Data {
    Data { bytes: version, length: 8 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_reply_has_the_length_of_the_request() {
        let reply = Reply { status: Status::Ok, command: 6, value: 1 };
        assert_eq!(encode_reply(1, reply, Length::Seven).as_slice(), [1, 100, 6, 0, 0, 0, 1]);
        assert_eq!(encode_reply(1, reply, Length::Eight).as_slice(), [1, 100, 6, 0, 0, 0, 1, 108]);
        assert_eq!(encode_version_string(*b"1311V111").as_slice(), b"1311V111");
    }

    #[test]
    fn other_lengths_are_refused_by_name() {
        for length in [0, 1, 6] {
            assert_eq!(decode_request(&[0; 8][..length]), Err(FrameError::Length(length)));
        }
    }

    #[test]
    fn a_frame_carries_up_to_eight_bytes() {
        for length in 0..=8 {
            let bytes = &[1, 2, 3, 4, 5, 6, 7, 8][..length];
            assert_eq!(Data::new(bytes).expect("fits").as_slice(), bytes);
        }
        assert_eq!(Data::new(&[0; 9]), None);
        assert_eq!(Frame::new(2047, &[0; 9]), None);
    }

    #[test]
    fn an_instruction_is_summed_where_the_request_was() {
        let stop = [28, 0, 0, 0, 0, 0, 1];
        assert_eq!(encode_instruction(stop, Length::Seven).as_slice(), stop);
        assert_eq!(encode_instruction(stop, Length::Eight).as_slice(), [28, 0, 0, 0, 0, 0, 1, 29]);
    }

    proptest! {
        #[test]
        fn replies_survive_the_round_trip(module: u8, index in 0..Status::ALL.len(), command: u8, value: i32) {
            let reply = Reply { status: Status::ALL[index], command, value };
            for length in [Length::Seven, Length::Eight] {
                let data = encode_reply(module, reply, length);
                prop_assert_eq!(decode_reply(data.as_slice()), Ok((module, reply)));
                prop_assert_eq!(Data::new(data.as_slice()), Some(data));
            }
        }

        #[test]
        fn requests_survive_the_round_trip(bytes: [u8; 7], sum: u8) {
            let request = Request::from_bytes(bytes);
            prop_assert_eq!(decode_request(encode_request(request).as_slice()), Ok((request, Length::Seven)));
            let mut with_sum = [0; 8];
            with_sum[..7].copy_from_slice(&bytes);
            with_sum[7] = sum;
            prop_assert_eq!(decode_request(&with_sum), Ok((request, Length::Eight)));
        }
    }
}
