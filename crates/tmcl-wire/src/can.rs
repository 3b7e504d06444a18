//! The CAN form: a request of seven bytes, its address in the CAN identifier (TMCM-1311 §4.1, §4.2).
//!
//! Some hosts send the checksum along as an eighth byte. Such requests are taken too, and the reply has the length of the
//! request (decisions of the project, "Wire"). CAN has a checksum of its own, so the eighth byte is not judged.

use crate::serial::checksum;
use crate::{Reply, Request};

/// The data of a CAN frame: up to eight bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Data {
    bytes: [u8; 8],
    length: usize,
}

impl Data {
    /// The bytes.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&self.bytes)
    }
}

/// How long a frame is, which is how long its reply will be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// Seven bytes: the plain form.
    Seven,
    /// Eight bytes: a checksum rides along.
    Eight,
}

/// Why a frame is no TMCL request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// A TMCL request has seven bytes, or eight with a checksum.
    #[error("a TMCL frame has 7 bytes, or 8 with a checksum, but this one has {0}")]
    Length(usize),
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

/// A reply as a frame's data: module address, status, command, value; the host is the frame's identifier.
#[must_use]
pub fn encode_reply(module: u8, reply: Reply, length: Length) -> Data {
    let [a, b, c, d] = reply.value.to_be_bytes();
    let (status, command) = (reply.status.number(), reply.command);
    let sum = checksum(&[module, status, command, a, b, c, d]);
    let length = match length {
        Length::Seven => 7,
        Length::Eight => 8,
    };
    Data { bytes: [module, status, command, a, b, c, d, sum], length }
}

/// The reply to command 136, type 0: all eight characters (TMCM-1311 §5.7.39).
#[must_use]
pub fn encode_version_string(version: [u8; 8]) -> Data {
    Data { bytes: version, length: 8 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tmcl_tables::Status;

    use super::*;

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

    proptest! {
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
