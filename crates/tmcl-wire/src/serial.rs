//! The nine-byte datagrams of USB, RS232, RS485 and TCP streams (TMCM-1311 §4.1, §4.2).
//!
//! | byte | request | reply |
//! |---|---|---|
//! | 0 | module address | host address |
//! | 1 | command | module address |
//! | 2 | type | status |
//! | 3 | motor or bank | command |
//! | 4…7 | value, most significant byte first | the same |
//! | 8 | checksum: the low 8 bits of the sum of the other eight | the same |

use tmcl_tables::Status;

use crate::{Reply, Request};

/// Bytes of a datagram, either way.
pub const DATAGRAM_LENGTH: usize = 9;

/// Why nine bytes are not what they should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DatagramError {
    /// The last byte is not the sum of the other eight.
    #[error("wrong checksum: the eight bytes before it add up to {expected:#04x}, but it is {found:#04x}")]
    Checksum {
        /// The sum of the first eight bytes.
        expected: u8,
        /// The ninth byte.
        found: u8,
    },
    /// The status byte of a reply is none that a manual knows.
    #[error("unknown status code {0}")]
    Status(u8),
}

/// The low eight bits of the sum (TMCM-1311 §4.1.1).
#[must_use]
pub fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum.wrapping_add(*byte))
}

/// A request as a datagram for the module at `address`.
#[must_use]
pub fn encode_request(address: u8, request: Request) -> [u8; DATAGRAM_LENGTH] {
    let [command, kind, motor, a, b, c, d] = request.to_bytes();
    sealed([address, command, kind, motor, a, b, c, d])
}

/// A reply as a datagram from the module at `module` to the host at `host`.
#[must_use]
pub fn encode_reply(host: u8, module: u8, reply: Reply) -> [u8; DATAGRAM_LENGTH] {
    let [a, b, c, d] = reply.value.to_be_bytes();
    sealed([host, module, reply.status.number(), reply.command, a, b, c, d])
}

/// The reply to command 136, type 0: host address and eight characters, no checksum (TMCM-1311 §5.7.39).
#[must_use]
pub fn encode_version_string(host: u8, version: [u8; 8]) -> [u8; DATAGRAM_LENGTH] {
    let [a, b, c, d, e, f, g, h] = version;
    [host, a, b, c, d, e, f, g, h]
}

/// The reply to command 134: host address, the seven bytes of an instruction, and the sum of these eight. The layout is an
/// inference (decision): no manual prints it.
#[must_use]
pub fn encode_instruction(host: u8, instruction: [u8; 7]) -> [u8; DATAGRAM_LENGTH] {
    let [a, b, c, d, e, f, g] = instruction;
    sealed([host, a, b, c, d, e, f, g])
}

/// The host address and the instruction in the reply to command 134.
///
/// # Errors
/// [`DatagramError::Checksum`] when the last byte is not the sum of the others.
pub fn decode_instruction(datagram: [u8; DATAGRAM_LENGTH]) -> Result<(u8, [u8; 7]), DatagramError> {
    let [host, a, b, c, d, e, f, g, found] = datagram;
    verify(&[host, a, b, c, d, e, f, g], found)?;
    Ok((host, [a, b, c, d, e, f, g]))
}

/// The address and request in nine bytes.
///
/// # Errors
/// [`DatagramError::Checksum`] when the last byte is not the sum of the others.
pub fn decode_request(datagram: [u8; DATAGRAM_LENGTH]) -> Result<(u8, Request), DatagramError> {
    let [address, command, kind, motor, a, b, c, d, found] = datagram;
    verify(&[address, command, kind, motor, a, b, c, d], found)?;
    Ok((address, Request::from_bytes([command, kind, motor, a, b, c, d])))
}

/// The host address, module address and reply in nine bytes.
///
/// # Errors
/// [`DatagramError`] when the checksum is wrong or the status unknown.
pub fn decode_reply(datagram: [u8; DATAGRAM_LENGTH]) -> Result<(u8, u8, Reply), DatagramError> {
    let [host, module, status, command, a, b, c, d, found] = datagram;
    verify(&[host, module, status, command, a, b, c, d], found)?;
    let status = Status::try_from(status).map_err(DatagramError::Status)?;
    Ok((host, module, Reply { status, command, value: i32::from_be_bytes([a, b, c, d]) }))
}

fn verify(bytes: &[u8; 8], found: u8) -> Result<(), DatagramError> {
    let expected = checksum(bytes);
    if expected == found { Ok(()) } else { Err(DatagramError::Checksum { expected, found }) }
}

fn sealed(bytes: [u8; 8]) -> [u8; DATAGRAM_LENGTH] {
    let [a, b, c, d, e, f, g, h] = bytes;
    [a, b, c, d, e, f, g, h, checksum(&bytes)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tmcl_tables::Command;

    use super::*;

    /// TMCM-1076 §3.5.5: GIO 0, 1 and its reply with value 302, checksums printed.
    #[test]
    fn the_printed_datagrams_of_the_manual() {
        let request = Request::new(Command::GetInput, 0, 1, 0);
        assert_eq!(encode_request(1, request), [0x01, 0x0F, 0x00, 0x01, 0, 0, 0, 0, 0x11]);
        let reply = Reply { status: Status::Ok, command: 0x0F, value: 302 };
        assert_eq!(encode_reply(2, 1, reply), [0x02, 0x01, 0x64, 0x0F, 0, 0, 0x01, 0x2E, 0xA5]);
    }

    /// TMCM-1076 §3.5.4 prints checksum 0A for 01 08 06 …; the sum is 0F.
    #[test]
    fn a_wrong_checksum_is_named() {
        let printed = [0x01, 0x08, 0x06, 0x00, 0, 0, 0, 0, 0x0A];
        assert_eq!(decode_request(printed), Err(DatagramError::Checksum { expected: 0x0F, found: 0x0A }));
    }

    #[test]
    fn the_version_string_carries_no_checksum() {
        assert_eq!(&encode_version_string(2, *b"1311V111"), b"\x021311V111");
    }

    proptest! {
        #[test]
        fn requests_survive_the_round_trip(address: u8, bytes: [u8; 7]) {
            let request = Request::from_bytes(bytes);
            prop_assert_eq!(request.to_bytes(), bytes);
            prop_assert_eq!(decode_request(encode_request(address, request)), Ok((address, request)));
        }

        #[test]
        fn replies_survive_the_round_trip(host: u8, module: u8, index in 0..Status::ALL.len(), command: u8, value: i32) {
            let reply = Reply { status: Status::ALL[index], command, value };
            prop_assert_eq!(decode_reply(encode_reply(host, module, reply)), Ok((host, module, reply)));
        }

        #[test]
        fn one_wrong_bit_is_found(address: u8, bytes: [u8; 7], bit in 0..72_usize) {
            let mut datagram = encode_request(address, Request::from_bytes(bytes));
            datagram[bit / 8] ^= 1 << (bit % 8);
            prop_assert!(decode_request(datagram).is_err());
        }
    }
}
