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

#[cfg(test)]
mod tests {
    use virtual_bench::BenchConfig;
    use virtual_bench::ModuleKind::Tmcm1311;

    use super::*;

    /// GGP 66 of the module with identifier 1, and its reply.
    const ASK: &str = "t00170A420000000000\r";
    const REPLY: &str = "t00270164 0A00000001\r";

    /// An adapter between its client and a module.
    struct Client {
        adapter: Adapter,
        bench: Bench,
        line: PortId,
    }

    impl Client {
        fn new() -> Self {
            let adapter = Adapter::new();
            let mut bench = Bench::new(&BenchConfig::default_for(Tmcm1311));
            let [line, ..] = PortId::ALL;
            bench.wire(line, adapter.wiring());
            Self { adapter, bench, line }
        }

        fn say(&mut self, text: &str) -> String {
            let mut out = Vec::new();
            let taken = self.adapter.hear(text.as_bytes(), &mut self.bench, self.line, &mut out);
            assert_eq!(taken, text.len());
            String::from_utf8(out).expect("slcan is text")
        }
    }

    fn answered() -> String {
        format!("z\r{}", REPLY.replace(' ', ""))
    }

    #[test]
    fn a_closed_channel_passes_nothing() {
        let mut client = Client::new();
        assert_eq!(client.say(ASK), "\x07");
        assert_eq!(client.say("O\r"), "\r");
        assert_eq!(client.say(ASK), answered());
        assert_eq!(client.say("C\rC\r"), "\r\r");
        assert_eq!(client.say(ASK), "\x07");
        assert_eq!(client.say("L\r"), "\r");
        assert_eq!(client.say(ASK), "\x07");
    }

    #[test]
    fn settings_are_made_while_it_is_closed() {
        let mut client = Client::new();
        assert_eq!(client.say("S6\rO\r"), "\r\r");
        for setting in ["S8", "s0014", "Z1", "M00000000", "mFFFFFFFF", "O", "L"] {
            assert_eq!(client.say(&format!("{setting}\r")), "\x07", "{setting}");
        }
        assert_eq!(client.say(ASK), "z\r", "the module is at 1 Mbit/s");
        // The two ways to say 1 Mbit/s.
        for rate in ["S8", "s0014"] {
            assert_eq!(client.say(&format!("C\r{rate}\rO\r")), "\r\r\r");
            assert_eq!(client.say(ASK), answered());
        }
        assert_eq!(client.say("C\rM12345678\rmFFFFFFFF\rm00000000\r"), "\r\r\r\x07", "it filters nothing");
    }

    #[test]
    fn what_passed_while_it_was_closed_was_not_heard() {
        let mut client = Client::new();
        assert_eq!(client.say("O\r"), "\r");
        // 138, with the target already reached: two replies.
        let event = "t0017 8A000000000000\r".replace(' ', "");
        assert_eq!(client.say(&event).matches('t').count(), 2);
        client.bench.send_frame(client.line, &Frame::new(1, &[10, 66, 0, 0, 0, 0, 0]).expect("seven bytes"));
        assert_eq!(client.say("C\rO\r"), format!("\r{}\r", ""));
    }

    #[test]
    fn a_time_stamp_counts_to_a_minute() {
        let mut client = Client::new();
        assert_eq!(client.say("Z1\rO\r"), "\r\r");
        client.bench.advance_to(59_999_000_000);
        let stamped = |time: &str| answered().replace("01\r", &format!("01{time}\r"));
        assert_eq!(client.say(ASK), stamped("EA5F"));
        client.bench.advance_to(60_002_000_000);
        assert_eq!(client.say(ASK), stamped("0002"));
    }

    #[test]
    fn registers_mean_bit_rates() {
        let known =
            [(0x00, 0x14, 1_000_000), (0x00, 0x1C, 500_000), (0x01, 0x1C, 250_000), (0x03, 0x1C, 125_000)];
        for (btr0, btr1, rate) in known {
            assert_eq!(bits_per_second(btr0, btr1), rate);
        }
    }
}
