//! Lines out of bytes, and hexadecimal digits out of lines.

use super::{BEL, CR};

/// The longest line: `T`, eight digits, the length, sixteen digits, and a time stamp.
const LONGEST: usize = 30;

/// What a stream of bytes falls into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Piece<'a> {
    /// What stands before a CR.
    Line(&'a [u8]),
    /// The beginning of a line longer than any.
    TooLong(&'a [u8]),
    /// A BEL, and whatever stood before it.
    Bell,
}

/// Collects a line.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines {
    bytes: Vec<u8>,
    /// Whether to hand out and forget what was collected before the next byte.
    complete: bool,
}

impl Lines {
    /// The next byte, and the piece it ends. Line feeds are passed over: some write them after CR.
    pub(super) fn push(&mut self, byte: u8) -> Option<Piece<'_>> {
        if std::mem::take(&mut self.complete) {
            self.bytes.clear();
        }
        match byte {
            CR => {
                self.complete = true;
                Some(if self.bytes.len() > LONGEST {
                    Piece::TooLong(&self.bytes)
                } else {
                    Piece::Line(&self.bytes)
                })
            }
            BEL => {
                self.complete = true;
                Some(Piece::Bell)
            }
            b'\n' => None,
            _ => {
                // One byte more than the longest line says that it is too long, and more than that says no more.
                if self.bytes.len() <= LONGEST {
                    self.bytes.push(byte);
                }
                None
            }
        }
    }
}

/// The number that these hexadecimal digits are, of either case; none is 0.
pub(super) fn number(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0_u32, |number, digit| {
        let digit = char::from(*digit).to_digit(16)?;
        (number <= u32::MAX >> 4).then_some(number << 4 | digit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(bytes: &[u8]) -> Vec<String> {
        let mut lines = Lines::default();
        let name = |piece: Piece<'_>| match piece {
            Piece::Line(line) => String::from_utf8_lossy(line).into_owned(),
            Piece::TooLong(_) => "too long".to_owned(),
            Piece::Bell => "Bell".to_owned(),
        };
        bytes.iter().filter_map(|byte| lines.push(*byte).map(name)).collect()
    }

    #[test]
    fn lines_end_with_cr_and_bel_stands_alone() {
        assert_eq!(pieces(b"O\r\r\nt100\x07S8\rC"), ["O", "", "Bell", "S8"]);
    }

    #[test]
    fn a_line_without_end_takes_no_room_and_is_over_at_cr() {
        let mut bytes = vec![b'x'; 100_000];
        bytes.extend(b"\rO\r");
        assert_eq!(pieces(&bytes), ["too long", "O"]);
        assert_eq!(pieces(b"123456789012345678901234567890\r"), ["123456789012345678901234567890"]);
        assert_eq!(pieces(b"1234567890123456789012345678901\r"), ["too long"]);
    }

    #[test]
    fn digits_have_either_case() {
        assert_eq!(number(b"7fF"), Some(0x7FF));
        assert_eq!(number(b"FFFFFFFF"), Some(u32::MAX));
        assert_eq!(number(b"100000000"), None);
        assert_eq!(number(b"+1"), None);
        assert_eq!(number(b""), Some(0));
    }
}
