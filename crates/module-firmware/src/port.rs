//! The module's ports: each keeps what came in until it is served, and what is said until it leaves.

mod typing;

use tmcl_wire::ascii::{self, CommandLine};
use tmcl_wire::{Decoder, Listener, Reply, can, serial};
pub(crate) use typing::Ear;

use crate::envelope::{Envelope, Form};
use crate::line::Line;
use crate::program_memory::Instruction;
use crate::ring::Ring;

/// Ports of a module.
pub const PORTS: usize = 4;

/// Bytes of a frame in an inbox or outbox: identifier, length, and what it carries.
const FRAME_LENGTH: usize = 3 + can::Data::MAX_LENGTH;

/// Bytes that an inbox and an outbox hold.
const INBOX: usize = 64;
const OUTBOX: usize = 128;

const _: () = assert!(2 * FRAME_LENGTH <= OUTBOX);

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

/// One port's state.
#[derive(Clone, Debug)]
pub(crate) struct Port {
    pub(crate) line: Line,
    decoder: Decoder,
    /// The line that is being typed, in ASCII mode.
    typed: Option<CommandLine>,
    /// What waits until a storage job is done or replies have left.
    inbox: Ring<INBOX>,
    outbox: Ring<OUTBOX>,
    /// The tick before which nothing leaves.
    quiet_until: u64,
    /// How long the line may be silent within a datagram, where the surroundings said so.
    pub(crate) silence_ticks: Option<u64>,
    /// Requests of command 138 that wait for the target position.
    pub(crate) awaits_position: u32,
    /// How long the frame of the last of them was.
    pub(crate) event_length: can::Length,
}

impl Port {
    pub(crate) const fn new() -> Self {
        Self {
            line: Line::Usb,
            decoder: Decoder::new(),
            typed: None,
            inbox: Ring::new(),
            outbox: Ring::new(),
            quiet_until: 0,
            silence_ticks: None,
            awaits_position: 0,
            event_length: can::Length::Seven,
        }
    }

    /// Takes a byte from outside; false when there is no room for it now.
    pub(crate) fn push(&mut self, byte: u8) -> bool {
        self.inbox.push(byte)
    }

    /// Takes a frame from outside; false when there is no room for it now.
    pub(crate) fn push_frame(&mut self, frame: &can::Frame) -> bool {
        put_frame(&mut self.inbox, frame.id, &frame.data)
    }

    /// Gives a byte to outside.
    pub(crate) fn pop(&mut self, now: u64) -> Option<u8> {
        if self.has_output(now) { self.outbox.pop() } else { None }
    }

    /// Gives a frame to outside.
    pub(crate) fn pop_frame(&mut self) -> Option<can::Frame> {
        if self.has_frame() { take_frame(&mut self.outbox) } else { None }
    }

    /// Whether bytes may leave.
    pub(crate) fn has_output(&self, now: u64) -> bool {
        self.line != Line::Can && !self.outbox.is_empty() && now >= self.quiet_until
    }

    /// Whether frames may leave.
    pub(crate) fn has_frame(&self) -> bool {
        self.line == Line::Can && !self.outbox.is_empty()
    }

    /// Whether nothing waits to leave, now or later.
    pub(crate) fn is_drained(&self) -> bool {
        self.outbox.is_empty()
    }

    /// The tick, after `now`, at which what waits may leave; None when nothing does, or it may already.
    pub(crate) fn speaks_at(&self, now: u64) -> Option<u64> {
        (!self.outbox.is_empty() && self.quiet_until > now).then_some(self.quiet_until)
    }

    /// The next event in the bytes that wait. None while a reply and an event would not fit the outbox.
    pub(crate) fn next_event(&mut self, now: u64, listener: &Listener) -> Option<tmcl_wire::Event> {
        while self.outbox.room() >= 2 * serial::DATAGRAM_LENGTH {
            let byte = self.inbox.pop()?;
            if let Some(event) = self.decoder.push(byte, now, listener) {
                return Some(event);
            }
        }
        None
    }

    /// The next of the frames that wait. None while a reply and an event would not fit the outbox.
    pub(crate) fn next_frame(&mut self) -> Option<can::Frame> {
        if self.outbox.room() >= 2 * FRAME_LENGTH { take_frame(&mut self.inbox) } else { None }
    }

    /// Queues a reply; false when it does not fit.
    pub(crate) fn reply(&mut self, envelope: Envelope, reply: Reply) -> bool {
        match envelope.form {
            Form::Datagram { host, module } => {
                self.send(envelope, &serial::encode_reply(host, module, reply))
            }
            Form::Text { host, module } => {
                self.send(envelope, ascii::encode_reply(host, module, reply).as_slice())
            }
            Form::Frame { id, module, length } => {
                self.send_frame(envelope, id, can::encode_reply(module, reply, length))
            }
        }
    }

    /// Queues the special reply of command 136, type 0.
    pub(crate) fn version_string(&mut self, envelope: Envelope, version: &str) -> bool {
        let characters = version.as_bytes().first_chunk().copied().unwrap_or([b' '; 8]);
        match envelope.form {
            Form::Datagram { host, .. } => {
                self.send(envelope, &serial::encode_version_string(host, characters))
            }
            Form::Frame { id, .. } => self.send_frame(envelope, id, can::encode_version_string(characters)),
            // No line asks for it.
            Form::Text { .. } => true,
        }
    }

    /// Queues the special reply of command 134.
    pub(crate) fn instruction(&mut self, envelope: Envelope, instruction: Instruction) -> bool {
        match envelope.form {
            Form::Datagram { host, .. } => {
                self.send(envelope, &serial::encode_instruction(host, instruction))
            }
            Form::Frame { id, length, .. } => {
                self.send_frame(envelope, id, can::encode_instruction(instruction, length))
            }
            // No line asks for it.
            Form::Text { .. } => true,
        }
    }

    /// Forgets everything, as when a client goes and another comes.
    pub(crate) fn clear(&mut self) {
        *self = Self { line: self.line, silence_ticks: self.silence_ticks, ..Self::new() };
    }

    /// Forgets what came in, and keeps what is to go out.
    pub(crate) fn forget_input(&mut self) {
        self.decoder.reset();
        self.forget_line();
        self.inbox.clear();
        self.awaits_position = 0;
    }

    /// Everything but the replies that are still on their way begins anew, and so does the count of ticks.
    pub(crate) fn restart(&mut self, now: u64) {
        self.forget_input();
        self.quiet_until = self.quiet_until.saturating_sub(now);
    }

    /// Queues bytes, whole or not at all; what is not to be answered is as good as queued.
    fn send(&mut self, envelope: Envelope, bytes: &[u8]) -> bool {
        if !envelope.answer {
            return true;
        }
        if self.outbox.room() < bytes.len() {
            return false;
        }
        self.say(envelope.ready_at, bytes)
    }

    fn say(&mut self, ready_at: u64, bytes: &[u8]) -> bool {
        self.begin(ready_at);
        bytes.iter().all(|byte| self.outbox.push(*byte))
    }

    fn send_frame(&mut self, envelope: Envelope, id: u16, data: can::Data) -> bool {
        if !envelope.answer {
            return true;
        }
        self.begin(envelope.ready_at);
        put_frame(&mut self.outbox, id, &data)
    }

    /// What is about to be said waits, unless the port is speaking already.
    fn begin(&mut self, ready_at: u64) {
        if self.outbox.is_empty() {
            self.quiet_until = ready_at;
        }
    }
}

/// Appends a frame to a queue, whole or not at all.
fn put_frame<const N: usize>(queue: &mut Ring<N>, id: u16, data: &can::Data) -> bool {
    let data = data.as_slice();
    let Ok(length) = u8::try_from(data.len()) else { return false };
    let [high, low] = id.to_be_bytes();
    queue.room() >= 3 + data.len() && [high, low, length].iter().chain(data).all(|byte| queue.push(*byte))
}

/// Takes a frame from a queue.
fn take_frame<const N: usize>(queue: &mut Ring<N>) -> Option<can::Frame> {
    let (high, low, length) = (queue.pop()?, queue.pop()?, usize::from(queue.pop()?));
    let mut bytes = [0; can::Data::MAX_LENGTH];
    let carried = bytes.get_mut(..length)?;
    for byte in carried.iter_mut() {
        *byte = queue.pop()?;
    }
    can::Frame::new(u16::from_be_bytes([high, low]), carried)
}
