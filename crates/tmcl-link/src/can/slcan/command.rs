//! What a host says to an adapter.

use super::line::{Lines, Piece, number};
use super::{BitRate, CR, Packet};

/// A line from the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// An empty line; hosts send some to end whatever stood in the adapter's buffer.
    Nothing,
    /// `S`: the bit rate.
    BitRate(BitRate),
    /// `s`: the bit rate as the registers BTR0 and BTR1 of the SJA1000.
    Timing {
        /// BTR0.
        btr0: u8,
        /// BTR1.
        btr1: u8,
    },
    /// `O`: take part in the bus.
    Open,
    /// `L`: listen to the bus and send nothing, not even acknowledgements.
    Listen,
    /// `C`: leave the bus.
    Close,
    /// `t`, `T`, `r`, `R`: send a frame.
    Send(Packet),
    /// `F`: which status flags are set?
    Status,
    /// `V`: which version are you?
    Version,
    /// `N`: which serial number do you have?
    SerialNumber,
    /// `Z`: whether frames that are heard shall carry a time stamp.
    TimeStamps(bool),
    /// `M`: the acceptance code register of the SJA1000.
    AcceptanceCode(u32),
    /// `m`: the acceptance mask register of the SJA1000.
    AcceptanceMask(u32),
}

/// Why a line is no command. The answer to all of them is [`super::BEL`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CommandError {
    /// There is no such command, or it has other arguments.
    #[error("\"{}\" is no slcan command", .0.escape_ascii())]
    Unknown(Vec<u8>),
    /// Longer than any command.
    #[error("a line is longer than any slcan command")]
    TooLong,
}

impl Command {
    /// The line, with CR.
    #[must_use]
    pub fn encode(self) -> Vec<u8> {
        let mut line = match self {
            Self::Nothing => String::new(),
            Self::BitRate(rate) => format!("S{}", char::from(rate.digit())),
            Self::Timing { btr0, btr1 } => format!("s{btr0:02X}{btr1:02X}"),
            Self::Open => "O".to_owned(),
            Self::Listen => "L".to_owned(),
            Self::Close => "C".to_owned(),
            Self::Send(packet) => packet.to_text(),
            Self::Status => "F".to_owned(),
            Self::Version => "V".to_owned(),
            Self::SerialNumber => "N".to_owned(),
            Self::TimeStamps(on) => format!("Z{}", u8::from(on)),
            Self::AcceptanceCode(code) => format!("M{code:08X}"),
            Self::AcceptanceMask(mask) => format!("m{mask:08X}"),
        }
        .into_bytes();
        line.push(CR);
        line
    }

    fn parse(line: &[u8]) -> Option<Self> {
        Some(match line {
            [] => Self::Nothing,
            [b'S', digit] => Self::BitRate(BitRate::from_digit(*digit)?),
            [b's', digits @ ..] if digits.len() == 4 => {
                let [_, _, btr0, btr1] = number(digits)?.to_be_bytes();
                Self::Timing { btr0, btr1 }
            }
            b"O" => Self::Open,
            b"L" => Self::Listen,
            b"C" => Self::Close,
            b"F" => Self::Status,
            b"V" => Self::Version,
            b"N" => Self::SerialNumber,
            b"Z0" => Self::TimeStamps(false),
            b"Z1" => Self::TimeStamps(true),
            [b'M', digits @ ..] if digits.len() == 8 => Self::AcceptanceCode(number(digits)?),
            [b'm', digits @ ..] if digits.len() == 8 => Self::AcceptanceMask(number(digits)?),
            _ => match Packet::parse(line)? {
                (packet, []) => Self::Send(packet),
                _ => return None,
            },
        })
    }
}

/// Commands out of bytes: the adapter's ear.
#[derive(Clone, Debug, Default)]
pub struct CommandDecoder {
    lines: Lines,
}

impl CommandDecoder {
    /// The next byte, and the command that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Result<Command, CommandError>> {
        match self.lines.push(byte)? {
            Piece::Line(line) => {
                Some(Command::parse(line).ok_or_else(|| CommandError::Unknown(line.to_vec())))
            }
            Piece::TooLong(_) => Some(Err(CommandError::TooLong)),
            // A host has nothing to say with it.
            Piece::Bell => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::packet::tests::any_packet;
    use super::*;
    use crate::can::CanFrame;

    fn any_command() -> impl Strategy<Value = Command> {
        prop_oneof![
            Just(Command::Nothing),
            (0..9_usize).prop_map(|index| Command::BitRate(BitRate::ALL[index])),
            any::<(u8, u8)>().prop_map(|(btr0, btr1)| Command::Timing { btr0, btr1 }),
            Just(Command::Open),
            Just(Command::Listen),
            Just(Command::Close),
            any_packet().prop_map(Command::Send),
            Just(Command::Status),
            Just(Command::Version),
            Just(Command::SerialNumber),
            any::<bool>().prop_map(Command::TimeStamps),
            any::<u32>().prop_map(Command::AcceptanceCode),
            any::<u32>().prop_map(Command::AcceptanceMask),
        ]
    }

    fn decode(bytes: &[u8]) -> Vec<Result<Command, CommandError>> {
        let mut decoder = CommandDecoder::default();
        bytes.iter().filter_map(|byte| decoder.push(*byte)).collect()
    }

    #[test]
    fn the_opening_of_a_host() {
        let frame = CanFrame::new(1, &[136, 1, 0, 0, 0, 0, 0]).expect("it fits");
        let said = decode(b"\r\rC\rS8\rO\rt0017880100000000 00\rt001788010000000000\rV");
        let expected = [
            Ok(Command::Nothing),
            Ok(Command::Nothing),
            Ok(Command::Close),
            Ok(Command::BitRate(BitRate::Kbit1000)),
            Ok(Command::Open),
            Err(CommandError::Unknown(b"t0017880100000000 00".to_vec())),
            Ok(Command::Send(Packet::Frame(frame))),
        ];
        assert_eq!(said, expected);
        assert_eq!(Command::Send(Packet::Frame(frame)).encode(), b"t001788010000000000\r");
    }

    #[test]
    fn what_is_no_command_is_named() {
        assert_eq!(CommandError::Unknown(b"S9\xff".to_vec()).to_string(), r#""S9\xff" is no slcan command"#);
        for line in [&b"S9\r"[..], b"s12\r", b"OO\r", b"Z2\r", b"M1\r", b"t00101\r", b"x\r"] {
            let unknown = CommandError::Unknown(line[..line.len() - 1].to_vec());
            assert_eq!(decode(line), [Err(unknown)]);
        }
    }

    proptest! {
        #[test]
        fn every_command_survives_any_noise_before_it(command in any_command(), noise: Vec<u8>) {
            let mut decoder = CommandDecoder::default();
            for byte in noise {
                let _ = decoder.push(byte);
            }
            let _ = decoder.push(CR);
            let line = command.encode();
            let (end, start) = line.split_last().expect("it ends with CR");
            for byte in start {
                prop_assert_eq!(decoder.push(*byte), None);
            }
            prop_assert_eq!(decoder.push(*end), Some(Ok(command)));
        }

        /// What is understood is written back as it was, but for the case of its digits.
        #[test]
        fn no_two_lines_mean_the_same(line in "[SsOLCtTrRFVNZMm]?[0-9a-fA-F]{0,26}") {
            if let Some(command) = Command::parse(line.as_bytes()) {
                let written = String::from_utf8(command.encode()).expect("it is text");
                prop_assert!(written.trim_end().eq_ignore_ascii_case(&line), "{written:?}");
            }
        }
    }
}
