//! A line as it is typed.

use tmcl_tables::{ModuleSpec, Status};

use super::{Input, letter, parse};

/// The longest line, its end left out; the longest that anybody has to type is a third of it (decision).
pub const LINE_LENGTH: usize = 80;

const BACKSPACE: u8 = 0x08;
const DELETE: u8 = 0x7F;

/// What a character did to a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Typed {
    /// It was appended.
    Kept,
    /// It took the last one away.
    Erased,
    /// It ended the line, which is not empty.
    Ended,
    /// Nothing that shows.
    Nothing,
}

/// The line that is being typed.
///
/// CR ends it, and so does LF, so that after CR LF there is an empty line, which is none (decision). Backspace (08) and
/// delete (7F) erase the last character. What is typed beyond [`LINE_LENGTH`] is counted, so that it can be erased, and makes
/// the line no command.
#[derive(Clone)]
pub struct CommandLine {
    bytes: [u8; LINE_LENGTH],
    length: usize,
    beyond: u32,
}

impl Default for CommandLine {
    fn default() -> Self {
        Self::new()
    }
}

impl core::fmt::Debug for CommandLine {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "CommandLine(\"{}\" and {} more)", self.text().escape_ascii(), self.beyond)
    }
}

impl CommandLine {
    /// Nothing typed yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; LINE_LENGTH], length: 0, beyond: 0 }
    }

    /// Takes a character. Constant work; never panics. After [`Typed::Ended`] the line stands until it is cleared.
    pub fn push(&mut self, byte: u8) -> Typed {
        match byte {
            b'\r' | b'\n' if self.length == 0 => Typed::Nothing,
            b'\r' | b'\n' => Typed::Ended,
            BACKSPACE | DELETE => self.erase(),
            b' ' | b'\t' if self.length == 0 => Typed::Nothing,
            _ => self.append(byte),
        }
    }

    /// Forgets it.
    pub fn clear(&mut self) {
        self.length = 0;
        self.beyond = 0;
    }

    /// What was kept of it.
    #[must_use]
    pub fn text(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&self.bytes)
    }

    /// Whether it begins with the letter of this address, large or small.
    #[must_use]
    pub fn is_for(&self, address: u8) -> bool {
        let first = self.text().first().map(u8::to_ascii_uppercase);
        first.is_some() && first == letter(address)
    }

    /// What the line asks for behind its letter.
    ///
    /// # Errors
    /// The status that it deserves: [`Status::InvalidCommand`] where it is no command of the module or too long,
    /// [`Status::NotAvailable`] for commands that only programs have, [`Status::WrongType`] for a wrong first operand that is a
    /// type, [`Status::InvalidValue`] for any other wrong, missing or surplus operand.
    pub fn input(&self, module: &ModuleSpec) -> Result<Input, Status> {
        match self.text() {
            [_, text @ ..] if self.beyond == 0 => parse::input(text, module),
            _ => Err(Status::InvalidCommand),
        }
    }

    fn append(&mut self, byte: u8) -> Typed {
        match self.bytes.get_mut(self.length) {
            Some(slot) => {
                *slot = byte;
                self.length += 1;
                Typed::Kept
            }
            None => {
                self.beyond = self.beyond.saturating_add(1);
                Typed::Nothing
            }
        }
    }

    fn erase(&mut self) -> Typed {
        if self.beyond > 0 {
            self.beyond -= 1;
            return Typed::Nothing;
        }
        match self.length.checked_sub(1) {
            Some(shorter) => {
                self.length = shorter;
                Typed::Erased
            }
            None => Typed::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use tmcl_tables::tmcm_1311::SPEC;

    use super::*;

    fn typed(text: &[u8]) -> CommandLine {
        let mut line = CommandLine::new();
        for byte in text {
            assert_ne!(line.push(*byte), Typed::Ended);
        }
        line
    }

    #[test]
    fn both_keys_erase_and_nothing_is_erased_of_nothing() {
        assert_eq!(typed(b"\x08AX\x7fMST 1\x080").text(), b"AMST 0");
        assert_eq!(typed(b"A\x08\x08\x7f").text(), b"");
    }

    #[test]
    fn empty_lines_and_blanks_in_front_are_nothing() {
        let mut line = CommandLine::new();
        assert_eq!([b'\r', b'\n', b' ', b'\t', b'\r'].map(|byte| line.push(byte)), [Typed::Nothing; 5]);
        assert_eq!([b'A', b'\n'].map(|byte| line.push(byte)), [Typed::Kept, Typed::Ended]);
    }

    #[test]
    fn what_is_beyond_the_line_spoils_it_until_it_is_erased() {
        let mut line = typed(b"AMST 0");
        for _ in line.text().len()..LINE_LENGTH {
            assert_eq!(line.push(b' '), Typed::Kept);
        }
        let stop = line.input(&SPEC);
        assert!(stop.is_ok());
        assert_eq!([line.push(b'1'), line.push(b'2')], [Typed::Nothing; 2]);
        assert_eq!(line.input(&SPEC), Err(Status::InvalidCommand));
        assert_eq!(
            [line.push(DELETE), line.push(DELETE), line.push(DELETE)],
            [Typed::Nothing, Typed::Nothing, Typed::Erased]
        );
        assert_eq!(line.input(&SPEC), stop);
    }

    #[test]
    fn letters_are_large_or_small() {
        assert!(typed(b"AMST 0").is_for(1) && typed(b"c").is_for(3));
        assert!(!typed(b"").is_for(1) && !typed(b"B").is_for(1) && !typed(b"?").is_for(0));
    }
}
