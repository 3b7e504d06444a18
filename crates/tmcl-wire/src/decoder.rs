//! Finds requests in a stream of bytes: noise, wrong checksums, partial datagrams and foreign addresses included.
//!
//! A datagram has no start mark; what tells one from the next is counting to nine, and silence (decisions of the
//! project, "Wire"):
//!
//! - **In step.** After silence, and after each datagram, nine bytes are one datagram. Right checksum and our address: a
//!   request. Wrong checksum and our address: the sender made a datagram and the line spoiled it, so it hears
//!   [`Event::WrongChecksum`]. Right checksum, foreign address: somebody else's. Wrong checksum, foreign address: we are
//!   out of step, and hunt.
//! - **Hunting.** Byte by byte, the last nine are looked at, until they are a request for us, or the line falls silent.
//!   Nothing else is answered, because nothing else is likely to have been meant.
//! - **Silence.** When no byte came for longer than the line's [`Listener::silence`], a partial datagram is dropped: one
//!   stray byte cannot put the module out of step for good.

use crate::serial::{DATAGRAM_LENGTH, decode_request};
use crate::{Request, serial};

/// Whom the decoder listens for, and how long a partial datagram lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listener {
    /// The module's address.
    pub address: u8,
    /// A second address that is obeyed but never answered (global parameter 87); 0 switches it off.
    pub secondary_address: u8,
    /// How long the line may be silent within a datagram, in the unit of the decoder's `now`.
    pub silence: u64,
}

impl Listener {
    fn hears(&self, address: u8) -> bool {
        address == self.address || (self.secondary_address != 0 && address == self.secondary_address)
    }
}

/// What a byte completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A request for us, by the address that was called.
    Request {
        /// The address in the datagram: ours or the secondary one.
        address: u8,
        /// The request.
        request: Request,
    },
    /// A datagram for us with a wrong checksum; it deserves [`crate::Reply::WRONG_CHECKSUM`].
    WrongChecksum,
}

/// The stream decoder of one port: at most nine bytes and a time.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    bytes: [u8; DATAGRAM_LENGTH],
    length: usize,
    hunting: bool,
    last_byte_at: u64,
}

impl Decoder {
    /// In step, with nothing heard yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; DATAGRAM_LENGTH], length: 0, hunting: false, last_byte_at: 0 }
    }

    /// Takes the byte that arrived at `now`. Constant work; never panics.
    pub fn push(&mut self, byte: u8, now: u64, listener: &Listener) -> Option<Event> {
        if now.saturating_sub(self.last_byte_at) > listener.silence {
            self.reset();
        }
        self.last_byte_at = now;
        if self.length == DATAGRAM_LENGTH {
            self.bytes.rotate_left(1);
            self.length -= 1;
        }
        if let Some(slot) = self.bytes.get_mut(self.length) {
            *slot = byte;
            self.length += 1;
        }
        if self.length == DATAGRAM_LENGTH { self.look(listener) } else { None }
    }

    /// Forgets a partial datagram, as after a disconnected line.
    pub fn reset(&mut self) {
        self.length = 0;
        self.hunting = false;
    }

    fn look(&mut self, listener: &Listener) -> Option<Event> {
        match decode_request(self.bytes) {
            Ok((address, request)) if listener.hears(address) => {
                self.reset();
                Some(Event::Request { address, request })
            }
            Ok(_) if !self.hunting => {
                self.reset();
                None
            }
            Err(serial::DatagramError::Checksum { .. }) if !self.hunting && self.addressed_to(listener) => {
                self.reset();
                Some(Event::WrongChecksum)
            }
            Ok(_) | Err(_) => {
                self.hunting = true;
                None
            }
        }
    }

    fn addressed_to(&self, listener: &Listener) -> bool {
        self.bytes.first().is_some_and(|&address| address == listener.address)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tmcl_tables::Command;

    use super::*;
    use crate::serial::encode_request;

    const LISTENER: Listener = Listener { address: 1, secondary_address: 0, silence: 100 };

    fn events(decoder: &mut Decoder, bytes: &[u8], now: u64) -> impl Iterator<Item = Event> {
        let found: [Option<Event>; 64] =
            core::array::from_fn(|index| decoder.push(*bytes.get(index)?, now, &LISTENER));
        found.into_iter().flatten()
    }

    fn request() -> Request {
        Request::new(Command::MoveToPosition, 0, 0, 90_000)
    }

    fn expected() -> Option<Event> {
        Some(Event::Request { address: 1, request: request() })
    }

    #[test]
    fn a_spoiled_datagram_is_reported_once_and_the_next_is_understood() {
        let mut decoder = Decoder::default();
        let mut spoiled = encode_request(1, request());
        spoiled[5] ^= 0x10;
        let mut found = events(&mut decoder, &spoiled, 0);
        assert_eq!(found.next(), Some(Event::WrongChecksum));
        assert_eq!(found.next(), None);
        drop(found);
        assert_eq!(events(&mut decoder, &encode_request(1, request()), 0).next(), expected());
    }

    #[test]
    fn foreign_datagrams_are_nobodys_business() {
        let mut decoder = Decoder::default();
        assert_eq!(events(&mut decoder, &encode_request(3, request()), 0).next(), None);
        assert_eq!(events(&mut decoder, &encode_request(1, request()), 0).next(), expected());
    }

    #[test]
    fn a_version_string_of_another_module_on_the_bus_does_not_confuse() {
        let mut decoder = Decoder::default();
        assert_eq!(events(&mut decoder, b"\x021640V200", 0).next(), None);
        assert_eq!(events(&mut decoder, &encode_request(1, request()), 0).next(), expected());
    }

    #[test]
    fn silence_drops_a_partial_datagram() {
        let mut decoder = Decoder::default();
        assert_eq!(events(&mut decoder, &[1, 4, 0], 0).next(), None);
        assert_eq!(events(&mut decoder, &encode_request(1, request()), 101).next(), expected());
    }

    #[test]
    fn the_secondary_address_is_heard_when_it_is_set() {
        let listener = Listener { secondary_address: 9, ..LISTENER };
        let mut decoder = Decoder::default();
        let datagram = encode_request(9, request());
        let found = datagram.map(|byte| decoder.push(byte, 0, &listener));
        assert_eq!(found[8], Some(Event::Request { address: 9, request: request() }));
        assert_eq!(events(&mut decoder, &datagram, 0).next(), None);
    }

    proptest! {
        /// Noise that does not open with our address delays nothing: the next datagram is found without silence. (Noise
        /// that happens to hold nine bytes with a right checksum is no noise, and left out.)
        #[test]
        fn steps_back_in_after_noise(mut stream in proptest::collection::vec(any::<u8>(), 1..40), bytes: [u8; 7]) {
            prop_assume!(stream[0] != LISTENER.address);
            let request = Request::from_bytes(bytes);
            stream.extend(encode_request(1, request));
            let (last, before) = stream.split_last().expect("not empty");
            prop_assume!(before.windows(9).all(|window| decode_request(window.try_into().expect("nine")).is_err()));
            let mut decoder = Decoder::default();
            for &byte in before {
                prop_assert_eq!(decoder.push(byte, 0, &LISTENER), None);
            }
            prop_assert_eq!(decoder.push(*last, 0, &LISTENER), Some(Event::Request { address: 1, request }));
        }

        /// After silence every datagram for us is understood, whatever came before.
        #[test]
        fn silence_always_heals(noise in proptest::collection::vec(any::<u8>(), 0..60), bytes: [u8; 7]) {
            let mut decoder = Decoder::default();
            for &byte in &noise {
                let _ = decoder.push(byte, 0, &LISTENER);
            }
            let datagram = encode_request(1, Request::from_bytes(bytes));
            let found = datagram.map(|byte| decoder.push(byte, 1000, &LISTENER));
            prop_assert_eq!(found[8], Some(Event::Request { address: 1, request: Request::from_bytes(bytes) }));
        }
    }
}
