//! A serial CAN adapter that exists in software only: it speaks slcan to its client, and frames to the bus.
//!
//! It does as LAWICEL's manual of the CAN232 says. Beyond that, closing a closed channel is no error, and so clients do begin.

use tmcl_link::can::CanFrame;
use tmcl_link::can::slcan::{BitRate, Command, CommandDecoder, Packet, Reply};
use virtual_bench::can::Frame;
use virtual_bench::{Bench, PortId, Wiring};

use crate::protocol::Protocol;

/// Hardware and software version, two digits each.
const VERSION: &[u8] = b"1013";

/// The serial number, four letters or digits.
const SERIAL_NUMBER: &[u8] = b"TMCL";

/// Time stamps count to a minute.
const MINUTE_MS: u64 = 60_000;

/// An acceptance mask that lets every frame through.
const EVERYTHING: u32 = u32::MAX;

/// Whether the adapter takes part in the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    Closed,
    Open,
    /// It hears and says nothing.
    ListenOnly,
}

/// The adapter.
pub(crate) struct Adapter {
    decoder: CommandDecoder,
    channel: Channel,
    /// Bits a second.
    bit_rate: u32,
    time_stamps: bool,
}

impl Adapter {
    pub(crate) fn new() -> Self {
        Self {
            decoder: CommandDecoder::default(),
            channel: Channel::Closed,
            bit_rate: BitRate::Kbit1000.bits_per_second(),
            time_stamps: false,
        }
    }

    /// What becomes of a command. Settings can be changed while the channel is closed.
    fn execute(&mut self, command: Command, bench: &mut Bench, line: PortId) -> Reply {
        let is_closed = self.channel == Channel::Closed;
        let mut set_up = |possible: bool, set: &mut dyn FnMut(&mut Self)| {
            if !is_closed || !possible {
                return Reply::Refused;
            }
            set(self);
            Reply::Done
        };
        match command {
            Command::Nothing => Reply::Done,
            Command::BitRate(rate) => set_up(true, &mut |this| this.bit_rate = rate.bits_per_second()),
            Command::Timing { btr0, btr1 } => {
                set_up(true, &mut |this| this.bit_rate = bits_per_second(btr0, btr1))
            }
            Command::Open => set_up(true, &mut |this| this.open(Channel::Open, bench, line)),
            Command::Listen => set_up(true, &mut |this| this.open(Channel::ListenOnly, bench, line)),
            Command::TimeStamps(on) => set_up(true, &mut |this| this.time_stamps = on),
            Command::AcceptanceCode(_) => set_up(true, &mut |_| ()),
            Command::AcceptanceMask(mask) => set_up(mask == EVERYTHING, &mut |_| ()),
            Command::Close => {
                self.channel = Channel::Closed;
                Reply::Done
            }
            Command::Send(packet) if self.channel == Channel::Open => send(&packet, bench, line),
            Command::Send(_) => Reply::Refused,
            Command::Status if is_closed => Reply::Refused,
            Command::Status => Reply::Status(0),
            Command::Version => Reply::Version(VERSION.to_vec()),
            Command::SerialNumber => Reply::SerialNumber(SERIAL_NUMBER.to_vec()),
        }
    }

    fn open(&mut self, channel: Channel, bench: &mut Bench, line: PortId) {
        // What passed while it was closed was not heard.
        while bench.take_frame(line).is_some() {}
        bench.set_rate(line, self.bit_rate);
        self.channel = channel;
    }
}

impl Protocol for Adapter {
    fn wiring(&self) -> Wiring {
        Wiring::Can { bit_rate: self.bit_rate }
    }

    fn hear(&mut self, bytes: &[u8], bench: &mut Bench, line: PortId, out: &mut Vec<u8>) -> usize {
        for &byte in bytes {
            let reply = match self.decoder.push(byte) {
                None => continue,
                Some(Ok(command)) => self.execute(command, bench, line),
                Some(Err(_)) => Reply::Refused,
            };
            out.extend(reply.encode());
            self.tell(bench, line, out);
        }
        bytes.len()
    }

    fn tell(&mut self, bench: &mut Bench, line: PortId, out: &mut Vec<u8>) {
        let time_ms = bench.time_ns() / 1_000_000 % MINUTE_MS;
        let time = self.time_stamps.then(|| u16::try_from(time_ms).unwrap_or(0));
        while let Some(frame) = bench.take_frame(line) {
            if self.channel != Channel::Closed
                && let Ok(frame) = CanFrame::new(frame.id, frame.data.as_slice())
            {
                out.extend(Reply::Heard { packet: Packet::Frame(frame), time }.encode());
            }
        }
    }
}

/// TMCL uses plain frames only: what else is on the bus no module heeds.
fn send(packet: &Packet, bench: &mut Bench, line: PortId) -> Reply {
    match packet {
        Packet::Frame(frame) => {
            if let Some(frame) = Frame::new(frame.id(), frame.data()) {
                bench.send_frame(line, &frame);
            }
            Reply::Sent { extended: false }
        }
        other => Reply::Sent { extended: other.is_extended() },
    }
}

/// The bit rate that two registers of an SJA1000 mean at 16 MHz.
fn bits_per_second(btr0: u8, btr1: u8) -> u32 {
    let prescaler = u32::from(btr0 & 0x3F) + 1;
    let quanta = 3 + u32::from(btr1 & 0x0F) + u32::from((btr1 >> 4) & 0x07);
    8_000_000 / (prescaler * quanta)
}
