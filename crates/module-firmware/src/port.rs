//! The module's ports: each finds its own requests and keeps its own replies.

use tmcl_wire::{Decoder, Listener, Reply, serial};

use crate::TICKS_PER_MS;
use crate::program_memory::Instruction;
use crate::ring::Ring;

/// Ports of a module.
pub const PORTS: usize = 4;

/// How long a stream without a baud rate may be silent within a datagram, unless the surroundings know better.
const STREAM_SILENCE_TICKS: u64 = 100 * TICKS_PER_MS;

/// Names a port: 0 to 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PortId(u8);

impl PortId {
    /// Every port.
    pub const ALL: [Self; PORTS] = [Self(0), Self(1), Self(2), Self(3)];

    /// The port's place among them.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// Who is spoken to by a reply, as it was when the request came: a new address takes effect after its reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Envelope {
    pub(crate) host: u8,
    pub(crate) module: u8,
    /// Whether there is a reply at all (global parameters 87 and 255).
    pub(crate) answer: bool,
}

/// One port's state.
#[derive(Clone, Debug)]
pub(crate) struct Port {
    decoder: Decoder,
    /// Bytes that wait until a storage job is done or replies have left.
    inbox: Ring<64>,
    outbox: Ring<64>,
    /// How long the line may be silent within a datagram.
    pub(crate) silence_ticks: u64,
    /// Requests of command 138 that wait for the target position.
    pub(crate) awaits_position: u32,
}

impl Port {
    pub(crate) const fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            inbox: Ring::new(),
            outbox: Ring::new(),
            silence_ticks: STREAM_SILENCE_TICKS,
            awaits_position: 0,
        }
    }

    /// Takes a byte from outside; false when there is no room for it now.
    pub(crate) fn push(&mut self, byte: u8) -> bool {
        self.inbox.push(byte)
    }

    /// Gives a byte to outside.
    pub(crate) fn pop(&mut self) -> Option<u8> {
        self.outbox.pop()
    }

    /// Whether bytes wait for outside.
    pub(crate) fn has_output(&self) -> bool {
        !self.outbox.is_empty()
    }

    /// The next event in the bytes that wait. None while a reply and an event would not fit the outbox.
    pub(crate) fn next_event(
        &mut self,
        now: u64,
        address: u8,
        secondary_address: u8,
    ) -> Option<tmcl_wire::Event> {
        let listener = Listener { address, secondary_address, silence: self.silence_ticks };
        while self.outbox.room() >= 2 * serial::DATAGRAM_LENGTH {
            let byte = self.inbox.pop()?;
            if let Some(event) = self.decoder.push(byte, now, &listener) {
                return Some(event);
            }
        }
        None
    }

    /// Queues a reply.
    pub(crate) fn reply(&mut self, envelope: Envelope, reply: Reply) {
        self.send(envelope, serial::encode_reply(envelope.host, envelope.module, reply));
    }

    /// Queues the special reply of command 136, type 0.
    pub(crate) fn version_string(&mut self, envelope: Envelope, version: &str) {
        let characters = version.as_bytes().first_chunk().copied().unwrap_or([b' '; 8]);
        self.send(envelope, serial::encode_version_string(envelope.host, characters));
    }

    /// Queues the special reply of command 134.
    pub(crate) fn instruction(&mut self, envelope: Envelope, instruction: Instruction) {
        self.send(envelope, serial::encode_instruction(envelope.host, instruction));
    }

    /// Whether a datagram fits the outbox.
    pub(crate) fn has_room(&self) -> bool {
        self.outbox.room() >= serial::DATAGRAM_LENGTH
    }

    /// Forgets everything, as when a client goes and another comes.
    pub(crate) fn clear(&mut self) {
        *self = Self { silence_ticks: self.silence_ticks, ..Self::new() };
    }

    /// Forgets what came in, and keeps what is to go out.
    pub(crate) fn restart(&mut self) {
        self.decoder.reset();
        self.inbox.clear();
        self.awaits_position = 0;
    }

    fn send(&mut self, envelope: Envelope, datagram: [u8; serial::DATAGRAM_LENGTH]) {
        if envelope.answer && self.has_room() {
            for byte in datagram {
                self.outbox.push(byte);
            }
        }
    }
}
