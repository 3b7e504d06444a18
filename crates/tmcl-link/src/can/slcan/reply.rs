//! What an adapter says to its host.

use super::line::{Lines, Piece, number};
use super::{BEL, CR, Packet};

/// A line from the adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// CR alone: done.
    Done,
    /// `z` or `Z`: the frame is sent, or waits for its turn.
    Sent {
        /// Whether it had a 29-bit identifier.
        extended: bool,
    },
    /// BEL: not done.
    Refused,
    /// A frame was heard.
    Heard {
        /// The frame.
        packet: Packet,
        /// When: milliseconds from 0 to 59 999, if the host asked for them.
        time: Option<u16>,
    },
    /// `F` and the status flags.
    Status(u8),
    /// `V` and what the adapter calls its version.
    Version(Vec<u8>),
    /// `N` and what the adapter calls its serial number.
    SerialNumber(Vec<u8>),
    /// Something else: noise, or the word of an adapter that has more to say than others. Of a line that is longer than any,
    /// the beginning.
    Unknown(Vec<u8>),
}

impl Reply {
    /// The bytes, with CR, or BEL.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut line = Vec::new();
        match self {
            Self::Done => {}
            Self::Sent { extended } => line.push(if *extended { b'Z' } else { b'z' }),
            Self::Refused => return vec![BEL],
            Self::Heard { packet, time } => {
                line.extend(packet.to_text().into_bytes());
                line.extend(time.map(|time| format!("{time:04X}").into_bytes()).unwrap_or_default());
            }
            Self::Status(flags) => line.extend(format!("F{flags:02X}").into_bytes()),
            Self::Version(text) => {
                line.push(b'V');
                line.extend(text);
            }
            Self::SerialNumber(text) => {
                line.push(b'N');
                line.extend(text);
            }
            Self::Unknown(text) => line.extend(text),
        }
        line.push(CR);
        line
    }

    fn parse(line: &[u8]) -> Self {
        match line {
            [] => Self::Done,
            b"z" => Self::Sent { extended: false },
            b"Z" => Self::Sent { extended: true },
            [b'V', text @ ..] => Self::Version(text.to_vec()),
            [b'N', text @ ..] => Self::SerialNumber(text.to_vec()),
            _ => Self::parse_status(line)
                .or_else(|| Self::parse_heard(line))
                .unwrap_or_else(|| Self::Unknown(line.to_vec())),
        }
    }

    fn parse_status(line: &[u8]) -> Option<Self> {
        let digits = line.strip_prefix(b"F").filter(|digits| digits.len() == 2)?;
        Some(Self::Status(u8::try_from(number(digits)?).ok()?))
    }

    fn parse_heard(line: &[u8]) -> Option<Self> {
        let (packet, time) = Packet::parse(line)?;
        let time = match time.len() {
            0 => None,
            4 => Some(u16::try_from(number(time)?).ok()?),
            _ => return None,
        };
        Some(Self::Heard { packet, time })
    }
}

/// Replies out of bytes: the host's ear.
#[derive(Clone, Debug, Default)]
pub struct ReplyDecoder {
    lines: Lines,
}

impl ReplyDecoder {
    /// The next byte, and the reply that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Reply> {
        Some(match self.lines.push(byte)? {
            Piece::Line(line) => Reply::parse(line),
            Piece::TooLong(line) => Reply::Unknown(line.to_vec()),
            Piece::Bell => Reply::Refused,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::packet::tests::any_packet;
    use super::*;
    use crate::can::CanFrame;

    fn any_reply() -> impl Strategy<Value = Reply> {
        let text = || proptest::collection::vec(b'0'..=b'Z', 0..8);
        prop_oneof![
            Just(Reply::Done),
            any::<bool>().prop_map(|extended| Reply::Sent { extended }),
            Just(Reply::Refused),
            (any_packet(), any::<Option<u16>>()).prop_map(|(packet, time)| Reply::Heard { packet, time }),
            any::<u8>().prop_map(Reply::Status),
            text().prop_map(Reply::Version),
            text().prop_map(Reply::SerialNumber),
        ]
    }

    fn decode(bytes: &[u8]) -> Vec<Reply> {
        let mut decoder = ReplyDecoder::default();
        bytes.iter().filter_map(|byte| decoder.push(*byte)).collect()
    }

    #[test]
    fn an_adapter_speaks() {
        let frame = CanFrame::new(2, &[1, 100, 6, 0, 0, 0, 9]).expect("it fits");
        let heard = |time| Reply::Heard { packet: Packet::Frame(frame), time };
        let said =
            decode(b"\r\x07V1013\rNA123\rF08\rz\rt002701640600000009\rt002701640600000009EA5F\rhello\r");
        let expected = [
            Reply::Done,
            Reply::Refused,
            Reply::Version(b"1013".to_vec()),
            Reply::SerialNumber(b"A123".to_vec()),
            Reply::Status(8),
            Reply::Sent { extended: false },
            heard(None),
            heard(Some(59_999)),
            Reply::Unknown(b"hello".to_vec()),
        ];
        assert_eq!(said, expected);
    }

    #[test]
    fn a_frame_that_lost_a_byte_is_no_frame() {
        let whole = b"t002701640600000009";
        for lost in 0..whole.len() {
            let mut bytes = whole.to_vec();
            bytes.remove(lost);
            let unknown = Reply::Unknown(bytes.clone());
            bytes.push(CR);
            assert_eq!(decode(&bytes), [unknown]);
        }
    }

    proptest! {
        #[test]
        fn every_reply_survives_any_noise_before_it(reply in any_reply(), noise: Vec<u8>) {
            let mut decoder = ReplyDecoder::default();
            for byte in noise {
                let _ = decoder.push(byte);
            }
            let _ = decoder.push(CR);
            let line = reply.encode();
            let (end, start) = line.split_last().expect("it has an end");
            for byte in start {
                prop_assert_eq!(decoder.push(*byte), None);
            }
            prop_assert_eq!(decoder.push(*end), Some(reply));
        }
    }
}
