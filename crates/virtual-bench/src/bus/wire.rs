//! Bytes on their way along a pair of wires, each with a start bit, eight data bits and a stop bit.
//!
//! The pair is half duplex. Bytes that overlap in time spoil each other, whoever sends them, and are heard as
//! [`SPOILED`]; a byte that begins while another is being heard is not heard by itself. Who listens at another rate than a
//! byte was sent at hears nothing usable: modules nothing at all, the host [`SPOILED`].

use std::collections::VecDeque;

use super::heard::Heard;
use super::serial::SerialStations;

/// What is heard of bytes that spoil each other (decision): nine of them have a wrong checksum.
pub(super) const SPOILED: u8 = 0xFF;

/// Bits of a byte on the line.
const BITS: u64 = 10;

const SECOND_NS: u64 = 1_000_000_000;

/// Who talks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Talker {
    Host,
    Module(usize),
}

/// A byte on the line.
#[derive(Clone, Debug)]
struct Flight {
    talker: Talker,
    byte: u8,
    spoiled: bool,
    /// Another module's byte was being heard when it began.
    swallowed: bool,
    pace: Pace,
}

/// Bytes that follow each other without a pause, counted, so that no rounding adds up.
#[derive(Clone, Copy, Debug)]
struct Pace {
    baud: u32,
    began_ns: u64,
    /// Bytes since then, the one on the line included.
    bytes: u64,
}

impl Pace {
    /// The first byte of a burst.
    fn first(baud: u32, began_ns: u64) -> Self {
        Self { baud: baud.max(1), began_ns, bytes: 1 }
    }

    /// The byte behind this one.
    fn next(self) -> Self {
        let baud = u64::from(self.baud);
        if self.bytes >= baud {
            // So many bytes take ten seconds to the nanosecond.
            let began_ns = self.began_ns.saturating_add(BITS * SECOND_NS);
            return Self { began_ns, bytes: self.bytes - baud + 1, ..self };
        }
        Self { bytes: self.bytes + 1, ..self }
    }

    /// When the byte has left the line, rounded up to a nanosecond.
    fn end_ns(self) -> u64 {
        let length_ns = (self.bytes * BITS * SECOND_NS).div_ceil(u64::from(self.baud));
        self.began_ns.saturating_add(length_ns)
    }
}

/// The pair of wires.
#[derive(Clone, Debug)]
pub(super) struct Wire {
    /// The host's rate.
    baud: u32,
    modules_hear_replies: bool,
    /// In the order in which they began; one of each talker at most.
    flights: Vec<Flight>,
}

impl Wire {
    pub(super) fn new(baud: u32, modules_hear_replies: bool) -> Self {
        Self { baud, modules_hear_replies, flights: Vec::new() }
    }

    pub(super) fn set_baud(&mut self, baud: u32) {
        self.baud = baud;
    }

    /// Nothing is on the line any more.
    pub(super) fn silence(&mut self) {
        self.flights.clear();
    }

    /// When the next byte has left the line.
    pub(super) fn next_landing_ns(&self) -> u64 {
        self.flights.iter().map(|flight| flight.pace.end_ns()).min().unwrap_or(u64::MAX)
    }

    /// The host begins, unless it is talking.
    pub(super) fn begin_host(&mut self, now_ns: u64, waiting: &mut VecDeque<u8>) {
        if !self.is_talking(Talker::Host)
            && let Some(byte) = waiting.pop_front()
        {
            self.begin(Talker::Host, byte, Pace::first(self.baud, now_ns));
        }
    }

    /// Everything that happens on the line up to now. Modules that have something to say begin now.
    pub(super) fn step(
        &mut self,
        now_ns: u64,
        spoke: bool,
        waiting: &mut VecDeque<u8>,
        heard: &mut Heard<u8>,
        stations: &mut impl SerialStations,
    ) -> bool {
        let mut happened = false;
        loop {
            let end_ns = self.next_landing_ns();
            if end_ns > now_ns {
                break;
            }
            let landed = self.land(end_ns, heard, stations);
            // All of these are off the line before the next bytes are on it.
            for flight in landed {
                self.go_on(&flight, waiting, stations);
            }
            happened = true;
        }
        if spoke || happened {
            for place in 0..stations.count() {
                happened |= self.begin_module(place, now_ns, stations);
            }
        }
        happened
    }

    /// Takes the bytes off the line that end now, and lets everybody hear them.
    fn land(
        &mut self,
        end_ns: u64,
        heard: &mut Heard<u8>,
        stations: &mut impl SerialStations,
    ) -> Vec<Flight> {
        let (landed, flying): (Vec<_>, Vec<_>) =
            self.flights.drain(..).partition(|flight| flight.pace.end_ns() == end_ns);
        self.flights = flying;
        let talks = |place| {
            let of_module = |flight: &Flight| flight.talker == Talker::Module(place);
            landed.iter().chain(&self.flights).any(of_module)
        };
        for flight in landed.iter().filter(|flight| !flight.swallowed) {
            let byte = if flight.spoiled { SPOILED } else { flight.byte };
            let baud = flight.pace.baud;
            let is_reply = flight.talker != Talker::Host;
            if is_reply {
                heard.push(if baud == self.baud { byte } else { SPOILED });
            }
            if is_reply && !self.modules_hear_replies {
                continue;
            }
            // Who drives the line does not listen to it.
            for place in (0..stations.count()).filter(|place| !talks(*place)) {
                if stations.baud(place) == baud {
                    stations.give(place, byte);
                }
            }
        }
        landed
    }

    /// The byte behind one that has left the line, if its talker has more to say.
    fn go_on(&mut self, before: &Flight, waiting: &mut VecDeque<u8>, stations: &mut impl SerialStations) {
        let byte = match before.talker {
            Talker::Host => waiting.pop_front(),
            Talker::Module(place) if stations.speaks(place) => stations.take(place),
            Talker::Module(_) => None,
        };
        if let Some(byte) = byte {
            self.begin(before.talker, byte, before.pace.next());
        }
    }

    fn begin_module(&mut self, place: usize, now_ns: u64, stations: &mut impl SerialStations) -> bool {
        let talker = Talker::Module(place);
        if self.is_talking(talker) || !stations.speaks(place) {
            return false;
        }
        // A new rate takes effect after the reply: it is the one at its beginning that counts.
        let pace = Pace::first(stations.baud(place), now_ns);
        let Some(byte) = stations.take(place) else { return false };
        self.begin(talker, byte, pace);
        true
    }

    fn begin(&mut self, talker: Talker, byte: u8, pace: Pace) {
        let spoiled = !self.flights.is_empty();
        let is_reply = talker != Talker::Host;
        let is_received = |flight: &Flight| flight.talker != Talker::Host && !flight.swallowed;
        let swallowed = is_reply && self.flights.iter().any(is_received);
        for flight in &mut self.flights {
            flight.spoiled = true;
        }
        self.flights.push(Flight { talker, byte, spoiled, swallowed, pace });
    }

    fn is_talking(&self, talker: Talker) -> bool {
        self.flights.iter().any(|flight| flight.talker == talker)
    }
}
