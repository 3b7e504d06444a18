//! The ASCII form: command lines that people type and the replies to them (TMCM-1311 §4.4).
//!
//! | | form | example |
//! |---|---|---|
//! | line | letter of the module, blanks, command as in program text, CR | `AMVP ABS, 0, 50000` |
//! | reply | letter of the host, letter of the module, status, value, CR | `BA 100 50000` |
//!
//! - [`CommandLine`] collects what is typed, and lets it be erased.
//! - [`CommandLine::input`] is what it says, by the tables of a module.
//! - [`Echo`] is what goes back while it is typed, [`encode_reply`] what goes back afterwards.

mod line;
mod number;
mod parse;

use core::fmt::{self, Write};

pub use line::{CommandLine, LINE_LENGTH, Typed};
pub use parse::Input;

use crate::Reply;

/// The end of a line and of a reply.
pub const END: u8 = b'\r';

/// Bytes of the longest reply: two letters, a status of three digits, a value of eleven characters.
pub const REPLY_LENGTH: usize = 19;

/// What stands in a reply for a host whose address has no letter (decision).
const NO_LETTER: u8 = b'?';

/// The letter of an address: A is 1, Z is 26. Others have none, and cannot be spoken to in ASCII (decision).
#[must_use]
pub const fn letter(address: u8) -> Option<u8> {
    match address {
        1..=26 => Some(b'A' - 1 + address),
        _ => None,
    }
}

/// What goes back of what is typed, besides the reply (TMCM-1311 §4.4.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Echo {
    /// Each character as it comes.
    Characters,
    /// The line after its end.
    Line,
    /// Nothing.
    Off,
}

impl Echo {
    /// What bits 4 and 5 of global parameter 67 ask for. Both is not allowed, and would be nothing.
    #[must_use]
    pub const fn from_setting(ascii_mode: i32) -> Self {
        match (ascii_mode & 0x10 != 0, ascii_mode & 0x20 != 0) {
            (false, false) => Self::Characters,
            (true, false) => Self::Line,
            (_, true) => Self::Off,
        }
    }
}

/// A reply in ASCII.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text {
    bytes: [u8; REPLY_LENGTH],
    length: usize,
}

impl Text {
    /// The characters, with CR at the end.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&self.bytes)
    }

    fn push(&mut self, byte: u8) -> fmt::Result {
        *self.bytes.get_mut(self.length).ok_or(fmt::Error)? = byte;
        self.length += 1;
        Ok(())
    }
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().try_for_each(|byte| self.push(byte))
    }
}

/// A reply from the module at `module` to the host at `host` (TMCM-1311 §4.4.2). The value is the reply's 32 bits with a sign,
/// whatever the command (decision).
#[must_use]
pub fn encode_reply(host: u8, module: u8, reply: Reply) -> Text {
    let mut text = Text { bytes: [0; REPLY_LENGTH], length: 0 };
    let [host, module] = [host, module].map(|address| char::from(letter(address).unwrap_or(NO_LETTER)));
    // It fits: see `REPLY_LENGTH`.
    let _ = write!(text, "{host}{module} {} {}{}", reply.status.number(), reply.value, char::from(END));
    text
}

#[cfg(test)]
mod tests {
    use tmcl_tables::Status;

    use super::*;

    /// TMCM-1311 §4.4.2.
    #[test]
    fn the_reply_that_the_manual_prints() {
        let reply = Reply { status: Status::Ok, command: 6, value: -5000 };
        assert_eq!(encode_reply(2, 1, reply).as_slice(), b"BA 100 -5000\r");
    }

    #[test]
    fn the_longest_reply_fits() {
        let reply = Reply { status: Status::Delayed, command: 138, value: i32::MIN };
        let text = encode_reply(26, 0, reply);
        assert_eq!(text.as_slice(), b"Z? 128 -2147483648\r");
        assert_eq!(text.as_slice().len(), REPLY_LENGTH);
    }

    #[test]
    fn letters_are_addresses_1_to_26() {
        assert_eq!(
            [0, 1, 2, 3, 26, 27, 255].map(letter),
            [None, Some(b'A'), Some(b'B'), Some(b'C'), Some(b'Z'), None, None]
        );
    }

    #[test]
    fn bits_4_and_5_choose_the_echo() {
        assert_eq!([0, 1].map(Echo::from_setting), [Echo::Characters; 2]);
        assert_eq!([0x10, 0x11].map(Echo::from_setting), [Echo::Line; 2]);
        assert_eq!([0x20, 0x21, 0x30].map(Echo::from_setting), [Echo::Off; 3]);
    }
}
