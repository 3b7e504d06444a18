//! Frames as text.

use super::line::number;
use crate::can::{CanFrame, Data, MAX_ID};

/// The greatest identifier of 29 bits.
pub const MAX_EXTENDED_ID: u32 = 0x1FFF_FFFF;

/// Every kind of frame that the text knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packet {
    /// `t`: data with an 11-bit identifier.
    Frame(CanFrame),
    /// `T`: data with a 29-bit identifier.
    Extended {
        /// 0 to [`MAX_EXTENDED_ID`].
        id: u32,
        /// The bytes.
        data: Data,
    },
    /// `r`: a request for a frame with an 11-bit identifier.
    Remote {
        /// 0 to [`MAX_ID`].
        id: u16,
        /// The length that the frame should have, 0 to 8.
        length: u8,
    },
    /// `R`: a request for a frame with a 29-bit identifier.
    ExtendedRemote {
        /// 0 to [`MAX_EXTENDED_ID`].
        id: u32,
        /// The length that the frame should have, 0 to 8.
        length: u8,
    },
}

impl Packet {
    /// Whether the identifier has 29 bits: such frames are answered with `Z`, others with `z`.
    #[must_use]
    pub const fn is_extended(&self) -> bool {
        matches!(self, Self::Extended { .. } | Self::ExtendedRemote { .. })
    }

    /// The line, without CR.
    pub(super) fn to_text(self) -> String {
        match self {
            Self::Frame(frame) => {
                format!("t{:03X}{}{}", frame.id(), frame.data().len(), digits(frame.data()))
            }
            Self::Extended { id, data } => {
                format!("T{id:08X}{}{}", data.as_slice().len(), digits(data.as_slice()))
            }
            Self::Remote { id, length } => format!("r{id:03X}{length}"),
            Self::ExtendedRemote { id, length } => format!("R{id:08X}{length}"),
        }
    }

    /// The frame that a line begins with, and what follows it; `None` when it begins with none.
    pub(super) fn parse(line: &[u8]) -> Option<(Self, &[u8])> {
        let (kind, rest) = line.split_first()?;
        let (id, rest) = match kind {
            b't' | b'r' => rest.split_at_checked(3)?,
            b'T' | b'R' => rest.split_at_checked(8)?,
            _ => return None,
        };
        let (length, rest) = rest.split_first()?;
        let length = char::from(*length).to_digit(10).filter(|length| *length <= 8)?;
        let (id, length) = (number(id)?, u8::try_from(length).ok()?);
        let standard = u16::try_from(id).ok().filter(|id| *id <= MAX_ID);
        let extended = Some(id).filter(|id| *id <= MAX_EXTENDED_ID);
        Some(match kind {
            b't' => {
                let (bytes, rest) = data(rest, length)?;
                (Self::Frame(CanFrame::new(standard?, &bytes).ok()?), rest)
            }
            b'T' => {
                let (bytes, rest) = data(rest, length)?;
                (Self::Extended { id: extended?, data: Data::new(&bytes).ok()? }, rest)
            }
            b'r' => (Self::Remote { id: standard?, length }, rest),
            _ => (Self::ExtendedRemote { id: extended?, length }, rest),
        })
    }
}

/// Two digits for each byte.
fn digits(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

/// As many bytes as `length` says, and what follows them.
fn data(digits: &[u8], length: u8) -> Option<(Vec<u8>, &[u8])> {
    let (digits, rest) = digits.split_at_checked(2 * usize::from(length))?;
    let byte = |pair: &[u8]| u8::try_from(number(pair)?).ok();
    Some((digits.chunks_exact(2).map(byte).collect::<Option<_>>()?, rest))
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Any frame of any kind.
    pub(in crate::can::slcan) fn any_packet() -> impl Strategy<Value = Packet> {
        let standard = 0..=MAX_ID;
        let extended = 0..=MAX_EXTENDED_ID;
        let bytes = || proptest::collection::vec(any::<u8>(), 0..=8);
        prop_oneof![
            (standard.clone(), bytes())
                .prop_map(|(id, data)| Packet::Frame(CanFrame::new(id, &data).expect("it fits"))),
            (extended.clone(), bytes())
                .prop_map(|(id, data)| Packet::Extended { id, data: Data::new(&data).expect("it fits") }),
            (standard, 0..=8_u8).prop_map(|(id, length)| Packet::Remote { id, length }),
            (extended, 0..=8_u8).prop_map(|(id, length)| Packet::ExtendedRemote { id, length }),
        ]
    }

    #[test]
    fn frames_as_adapters_write_them() {
        let frame = Packet::Frame(CanFrame::new(1, &[6, 1, 0, 0, 0, 0, 0xAB]).expect("it fits"));
        assert_eq!(frame.to_text(), "t0017060100000000AB");
        assert_eq!(Packet::parse(b"t0017060100000000ab1234"), Some((frame, &b"1234"[..])));
        let empty = Packet::Extended { id: MAX_EXTENDED_ID, data: Data::default() };
        assert_eq!(Packet::parse(b"T1FFFFFFF0"), Some((empty, &b""[..])));
        assert_eq!(Packet::parse(b"r7FF8"), Some((Packet::Remote { id: MAX_ID, length: 8 }, &b""[..])));
    }

    #[test]
    fn what_is_no_frame_is_none() {
        let all: [&[u8]; 9] =
            [b"", b"t", b"t001", b"t0019", b"t001A", b"t0012AB", b"t8000", b"T200000000", b"t0011G0"];
        for line in all {
            assert_eq!(Packet::parse(line), None, "{}", String::from_utf8_lossy(line));
        }
    }

    proptest! {
        #[test]
        fn every_frame_survives_being_written(packet in any_packet()) {
            let text = packet.to_text();
            prop_assert_eq!(Packet::parse(text.as_bytes()), Some((packet, &b""[..])));
        }
    }
}
