//! A CAN bus behind an adapter on a serial port.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::slcan::{BitRate, CR, Command, Packet, Reply, ReplyDecoder};
use super::{CanFrame, CanLink};
use crate::error::Errors;
use crate::{Link, LinkAddress, LinkError};

/// How long an adapter has to answer while the bus is opened. Some never do, and are taken at their silence. (decision)
const ANSWER_TIMEOUT: Duration = Duration::from_millis(300);

/// Bytes of other things that may come before the answer to a command; a busy bus must not keep us here.
const CHATTER_LIMIT: usize = 4096;

/// Room for a good many lines.
const READ_SIZE: usize = 256;

/// A CAN bus behind an adapter that speaks [`super::slcan`]. The adapter leaves the bus when this is dropped.
#[derive(Debug)]
pub struct SlcanLink<L: Link> {
    port: L,
    decoder: ReplyDecoder,
    frames: VecDeque<CanFrame>,
    wanted: Option<u16>,
    /// Whether the adapter refused to send a frame since the last one was handed over.
    refused: bool,
    errors: Errors,
}

impl<L: Link> SlcanLink<L> {
    /// Joins the bus: closes it, in case somebody left it open, sets its bit rate, and opens it. `name` is what the port is
    /// called in messages.
    ///
    /// An adapter that answers nothing may be one of those that never do.
    ///
    /// # Errors
    /// [`LinkError::Refused`] when the adapter refuses the bit rate or the opening; [`LinkError`] when the port is broken.
    pub fn open(port: L, name: &str, bit_rate: BitRate) -> Result<Self, LinkError> {
        let errors = Errors::of(LinkAddress::Slcan { path: name.to_owned(), bit_rate: Some(bit_rate) });
        let (decoder, frames) = (ReplyDecoder::default(), VecDeque::new());
        let mut link = Self { port, decoder, frames, wanted: None, refused: false, errors };
        // Ends whatever stands in the adapter's buffer, and is refused if that was nothing.
        link.port.write(&[CR, CR])?;
        link.command(Command::Close)?;
        link.port.discard_input()?;
        link.decoder = ReplyDecoder::default();
        if !link.command(Command::BitRate(bit_rate))? {
            return Err(link.errors.refused("set this bit rate"));
        }
        if !link.command(Command::Open)? {
            return Err(link.errors.refused("open the bus"));
        }
        Ok(link)
    }

    /// Says it, and returns whether the adapter did not object.
    fn command(&mut self, command: Command) -> Result<bool, LinkError> {
        self.port.write(&command.encode())?;
        for _ in 0..CHATTER_LIMIT {
            // Byte by byte: what follows the answer may be a frame.
            let mut byte = [0];
            if self.port.read(&mut byte, ANSWER_TIMEOUT)? == 0 {
                return Ok(true);
            }
            match self.decoder.push(byte[0]) {
                Some(Reply::Done) => return Ok(true),
                Some(Reply::Refused) => return Ok(false),
                _ => {}
            }
        }
        Ok(true)
    }

    fn take(&mut self, reply: &Reply) {
        match reply {
            Reply::Heard { packet: Packet::Frame(frame), .. } if self.is_wanted(*frame) => {
                self.frames.push_back(*frame);
            }
            Reply::Refused => self.refused = true,
            // Other frames, answers, and what only this adapter knows.
            _ => {}
        }
    }

    fn is_wanted(&self, frame: CanFrame) -> bool {
        self.wanted.is_none_or(|id| id == frame.id())
    }

    /// Reads what has come, waiting for it; returns whether anything did.
    fn read(&mut self, timeout: Duration) -> Result<bool, LinkError> {
        let mut buffer = [0; READ_SIZE];
        let length = self.port.read(&mut buffer, timeout)?;
        for byte in buffer.iter().take(length) {
            if let Some(reply) = self.decoder.push(*byte) {
                self.take(&reply);
            }
        }
        Ok(length > 0)
    }
}

impl<L: Link> CanLink for SlcanLink<L> {
    fn accept_only(&mut self, id: u16) -> Result<(), LinkError> {
        self.wanted = Some(id);
        self.frames.retain(|frame| frame.id() == id);
        Ok(())
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), LinkError> {
        self.refused = false;
        self.port.write(&Command::Send(Packet::Frame(frame)).encode())
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<CanFrame>, LinkError> {
        let start = Instant::now();
        let mut left = Some(timeout);
        while self.frames.is_empty() {
            if std::mem::take(&mut self.refused) {
                return Err(self
                    .errors
                    .refused("send a frame; is anybody else on the bus, at this bit rate?"));
            }
            match left {
                Some(time) if self.read(time)? => left = timeout.checked_sub(start.elapsed()),
                _ => break,
            }
        }
        Ok(self.frames.pop_front())
    }

    fn discard(&mut self) -> Result<(), LinkError> {
        self.port.discard_input()?;
        self.decoder = ReplyDecoder::default();
        self.frames.clear();
        Ok(())
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        self.port.wait(duration)
    }
}

impl<L: Link> Drop for SlcanLink<L> {
    fn drop(&mut self) {
        // If the port is gone, so is the adapter.
        let _ = self.port.write(&Command::Close.encode());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::super::slcan::{BEL, CommandDecoder};
    use super::*;

    /// What an adapter does with commands.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Manners {
        Polite,
        /// Acknowledges nothing.
        Silent,
        /// Refuses this one.
        Refuses(Command),
    }

    /// An adapter that answers every frame with one of the next identifier.
    #[derive(Debug)]
    struct Adapter {
        manners: Manners,
        decoder: CommandDecoder,
        heard: Arc<Mutex<Vec<Command>>>,
        says: VecDeque<u8>,
    }

    impl Adapter {
        fn new(manners: Manners) -> (Self, Arc<Mutex<Vec<Command>>>) {
            let heard = Arc::new(Mutex::new(Vec::new()));
            // Half a line from before.
            let says = b"t0028".iter().copied().collect();
            (Self { manners, decoder: CommandDecoder::default(), heard: Arc::clone(&heard), says }, heard)
        }

        fn obey(&mut self, command: Command) {
            self.heard.lock().expect("nobody panicked").push(command);
            match (self.manners, command) {
                (Manners::Silent, _) => {}
                (Manners::Refuses(refused), _) if refused == command => self.says.push_back(BEL),
                (_, Command::Send(_)) => self.says.extend(Reply::Sent { extended: false }.encode()),
                // It was closed, or there was nothing to end.
                (_, Command::Close | Command::Nothing) => self.says.push_back(BEL),
                _ => self.says.push_back(CR),
            }
            if let Command::Send(Packet::Frame(frame)) = command {
                for id in [frame.id() + 7, frame.id() + 1] {
                    let answer = CanFrame::new(id, frame.data()).expect("it fits");
                    let heard = Reply::Heard { packet: Packet::Frame(answer), time: Some(7) };
                    self.says.extend(heard.encode());
                }
            }
        }
    }

    impl Link for Adapter {
        fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
            for byte in bytes {
                if let Some(command) = self.decoder.push(*byte) {
                    self.obey(command.expect("the host knows the language"));
                }
            }
            Ok(())
        }

        fn read(&mut self, buffer: &mut [u8], _: Duration) -> Result<usize, LinkError> {
            let length = buffer.len().min(self.says.len());
            for (slot, byte) in buffer.iter_mut().zip(self.says.drain(..length)) {
                *slot = byte;
            }
            Ok(length)
        }

        fn discard_input(&mut self) -> Result<(), LinkError> {
            self.says.clear();
            Ok(())
        }
    }

    fn frame(id: u16) -> CanFrame {
        CanFrame::new(id, &[136, 1, 0, 0, 0, 0, 0]).expect("it fits")
    }

    #[test]
    fn frames_go_there_and_back_through_adapters_of_all_manners() {
        for manners in [Manners::Polite, Manners::Silent] {
            let (adapter, heard) = Adapter::new(manners);
            let mut link = SlcanLink::open(adapter, "COM5", BitRate::Kbit500).expect("it opens");
            link.accept_only(2).expect("it is ours to choose");
            link.send(frame(1)).expect("the port works");
            assert_eq!(link.receive(Duration::ZERO).expect("the port works"), Some(frame(2)));
            assert_eq!(link.receive(Duration::ZERO).expect("the port works"), None);
            link.send(frame(1)).expect("the port works");
            link.discard().expect("the port works");
            assert_eq!(link.receive(Duration::ZERO).expect("the port works"), None);
            drop(link);
            let said = heard.lock().expect("nobody panicked").clone();
            let expected = [
                Command::Nothing,
                Command::Nothing,
                Command::Close,
                Command::BitRate(BitRate::Kbit500),
                Command::Open,
                Command::Send(Packet::Frame(frame(1))),
                Command::Send(Packet::Frame(frame(1))),
                Command::Close,
            ];
            assert_eq!(said, expected);
        }
    }

    #[test]
    fn an_adapter_that_refuses_is_quoted() {
        let open = |command| {
            let (adapter, _) = Adapter::new(Manners::Refuses(command));
            SlcanLink::open(adapter, "/dev/ttyACM0", BitRate::Kbit10)
        };
        let error = open(Command::BitRate(BitRate::Kbit10)).expect_err("it refuses").to_string();
        assert_eq!(error, "the CAN adapter at slcan:/dev/ttyACM0@10000 refuses to set this bit rate");
        let error = open(Command::Open).expect_err("it refuses").to_string();
        assert_eq!(error, "the CAN adapter at slcan:/dev/ttyACM0@10000 refuses to open the bus");
        let mut link = open(Command::Send(Packet::Frame(frame(1)))).expect("it opens");
        link.accept_only(99).expect("it is ours to choose");
        link.send(frame(1)).expect("the port works");
        let error = link.receive(Duration::ZERO).expect_err("it refused").to_string();
        assert_eq!(
            error,
            "the CAN adapter at slcan:/dev/ttyACM0@10000 refuses to send a frame; is anybody else on the bus, at this bit rate?"
        );
    }
}
