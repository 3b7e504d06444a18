//! Finds nine bytes that answer a request in a stream that may hold anything.
//!
//! The mirror image of `tmcl_wire::Decoder`, with one difference: a host knows what it is waiting for.
//!
//! - **In step.** Nine bytes are one reply. Ours: found. A whole one that is somebody else's: dropped whole.
//! - **Hunting.** Once nine bytes were no reply at all, the last nine are looked at byte by byte.

use tmcl_wire::serial::DATAGRAM_LENGTH;

use crate::Heard;

/// What nine bytes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict<T> {
    /// The answer.
    Ours(T),
    /// Whole, but no answer to this request.
    Foreign(Heard),
    /// Nothing.
    Noise,
}

/// The last few bytes of a stream.
#[derive(Clone, Debug, Default)]
pub(crate) struct Finder {
    bytes: [u8; DATAGRAM_LENGTH],
    length: usize,
    hunting: bool,
    count: usize,
    foreign: Option<Heard>,
}

impl Finder {
    /// How many bytes are missing until there is something to look at. Reading more would take what follows the reply.
    pub(crate) fn missing(&self) -> usize {
        DATAGRAM_LENGTH - self.length
    }

    /// How many bytes came.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// What came that was no answer.
    pub(crate) fn heard(&self) -> Heard {
        match self.foreign {
            Some(foreign) => foreign,
            None if self.count == 0 => Heard::Nothing,
            None => Heard::Noise(self.count),
        }
    }

    /// Takes a byte; the answer, when it completes one by `judge`.
    pub(crate) fn push<T>(
        &mut self,
        byte: u8,
        judge: impl FnOnce([u8; DATAGRAM_LENGTH]) -> Verdict<T>,
    ) -> Option<T> {
        self.count = self.count.saturating_add(1);
        // `length` is below nine between two calls.
        if let Some(slot) = self.bytes.get_mut(self.length) {
            *slot = byte;
            self.length += 1;
        }
        if self.length < DATAGRAM_LENGTH {
            return None;
        }
        match judge(self.bytes) {
            Verdict::Ours(answer) => {
                *self = Self::default();
                return Some(answer);
            }
            Verdict::Foreign(heard) if !self.hunting => {
                self.foreign = Some(heard);
                self.length = 0;
            }
            Verdict::Foreign(_) | Verdict::Noise => self.hunt(),
        }
        None
    }

    fn hunt(&mut self) {
        self.hunting = true;
        self.bytes.rotate_left(1);
        self.length -= 1;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const OURS: &[u8; DATAGRAM_LENGTH] = b"123456789";

    /// What begins with an F is somebody else's.
    fn judge(bytes: [u8; DATAGRAM_LENGTH]) -> Verdict<()> {
        match bytes {
            _ if bytes == *OURS => Verdict::Ours(()),
            [b'F', second, ..] => Verdict::Foreign(Heard::OtherCommand(second)),
            _ => Verdict::Noise,
        }
    }

    fn found_at(stream: &[u8]) -> Option<usize> {
        let mut finder = Finder::default();
        stream.iter().position(|&byte| {
            assert!((1..=DATAGRAM_LENGTH).contains(&finder.missing()));
            finder.push(byte, judge).is_some()
        })
    }

    #[test]
    fn whole_replies_of_others_are_passed_over_whole() {
        assert_eq!(found_at(b"123456789F........"), Some(8));
        assert_eq!(found_at(b"F........F........123456789"), Some(26));
        assert_eq!(found_at(b"12345678"), None);
        // What looks like an answer across two of them is none.
        assert_eq!(found_at(b"F.12345678F9......"), None);
        assert_eq!(found_at(b"F123456789........"), None);
    }

    #[test]
    fn out_of_step_nothing_is_certain_to_be_whole() {
        assert_eq!(found_at(b"xF123456789"), Some(10));
    }

    #[test]
    fn what_came_instead_is_remembered() {
        let heard = |stream: &[u8]| {
            let mut finder = Finder::default();
            assert!(stream.iter().all(|&byte| finder.push(byte, judge).is_none()));
            finder.heard()
        };
        assert_eq!(heard(b""), Heard::Nothing);
        assert_eq!(heard(b"12345"), Heard::Noise(5));
        assert_eq!(heard(b"F!.......12345"), Heard::OtherCommand(b'!'));
    }

    proptest! {
        /// Whatever noise comes before, the answer is found with its last byte.
        #[test]
        fn noise_costs_nothing(noise in "[1-9x]{0,60}") {
            let stream = [noise.as_bytes(), OURS].concat();
            let first = stream.windows(DATAGRAM_LENGTH).position(|window| window == OURS).expect("it is there");
            prop_assert_eq!(found_at(&stream), Some(first + DATAGRAM_LENGTH - 1));
        }
    }
}
