//! An RS485 bus: bytes that reach everybody, in no time or in the time that ten bits take.

use std::collections::VecDeque;

use super::heard::Heard;
use super::wire::{SPOILED, Wire};

/// Modules by their places, each with its port on the bus.
pub(crate) trait SerialStations {
    /// How many there are.
    fn count(&self) -> usize;
    /// Bits a second of a module's interface.
    fn baud(&self, place: usize) -> u32;
    /// Whether a module has a byte to send.
    fn speaks(&self, place: usize) -> bool;
    /// The next byte that a module has to send.
    fn take(&mut self, place: usize) -> Option<u8>;
    /// A byte arrives at a module. What it has no room for is lost, as at any UART.
    fn give(&mut self, place: usize, byte: u8);
}

/// Bytes of the host that may wait for the line; so many fit the buffer of a serial port.
const HOST_BUFFER: usize = 4096;

/// The bus.
#[derive(Clone, Debug)]
pub(crate) struct SerialBus {
    modules_hear_replies: bool,
    /// What is on the line; `None`: nothing ever is, for bytes take no time.
    wire: Option<Wire>,
    /// What the host has yet to send.
    waiting: VecDeque<u8>,
    /// What the host has yet to take.
    heard: Heard<u8>,
}

impl SerialBus {
    pub(crate) fn new(baud: Option<u32>, modules_hear_replies: bool) -> Self {
        Self {
            modules_hear_replies,
            wire: baud.map(|baud| Wire::new(baud, modules_hear_replies)),
            waiting: VecDeque::new(),
            heard: Heard::new(),
        }
    }

    /// Another rate from the next byte on that the host sends after a pause. A bus without a rate gets none.
    pub(crate) fn set_baud(&mut self, baud: u32) {
        if let Some(wire) = &mut self.wire {
            wire.set_baud(baud);
        }
    }

    /// The host sends bytes. Returns how many were taken; the rest may be offered again later.
    pub(crate) fn send(&mut self, bytes: &[u8], now_ns: u64, stations: &mut impl SerialStations) -> usize {
        let Some(wire) = &mut self.wire else {
            for &byte in bytes {
                (0..stations.count()).for_each(|place| stations.give(place, byte));
                self.round(stations);
            }
            return bytes.len();
        };
        let taken = bytes.len().min(HOST_BUFFER.saturating_sub(self.waiting.len()));
        self.waiting.extend(bytes.iter().take(taken));
        wire.begin_host(now_ns, &mut self.waiting);
        taken
    }

    /// Everything up to now. `spoke` is whether a module may have something to say. Returns whether anything happened.
    pub(crate) fn step(&mut self, now_ns: u64, spoke: bool, stations: &mut impl SerialStations) -> bool {
        match &mut self.wire {
            None => spoke && self.round(stations),
            Some(wire) => wire.step(now_ns, spoke, &mut self.waiting, &mut self.heard, stations),
        }
    }

    /// When something happens here by itself.
    pub(crate) fn next_change_ns(&self) -> u64 {
        self.wire.as_ref().map_or(u64::MAX, Wire::next_landing_ns)
    }

    /// Appends what the host heard to `out`.
    pub(crate) fn take(&mut self, out: &mut Vec<u8>) {
        out.extend(self.heard.drain());
    }

    pub(crate) fn has_heard(&self) -> bool {
        !self.heard.is_empty()
    }

    /// The host goes: what it left half-said or unread is forgotten.
    pub(crate) fn hang_up(&mut self) {
        self.waiting.clear();
        self.heard.clear();
        if let Some(wire) = &mut self.wire {
            wire.silence();
        }
    }

    /// Carries what the modules have to say at this instant. Two that speak at once spoil each other. What modules answer to
    /// what they hear waits for the next round, so that two that answer each other do so for ever without stopping time.
    fn round(&mut self, stations: &mut impl SerialStations) -> bool {
        let mut said: Vec<(usize, Vec<u8>)> = Vec::new();
        for place in 0..stations.count() {
            if stations.speaks(place) {
                said.push((place, std::iter::from_fn(|| stations.take(place)).collect()));
            }
        }
        let (talkers, bytes) = match said.as_mut_slice() {
            [] => return false,
            [(place, bytes)] => (vec![*place], std::mem::take(bytes)),
            several => {
                let longest = several.iter().map(|(_, bytes)| bytes.len()).max().unwrap_or(0);
                (several.iter().map(|(place, _)| *place).collect(), vec![SPOILED; longest])
            }
        };
        if self.modules_hear_replies {
            for place in (0..stations.count()).filter(|place| !talkers.contains(place)) {
                bytes.iter().for_each(|byte| stations.give(place, *byte));
            }
        }
        bytes.into_iter().for_each(|byte| self.heard.push(byte));
        true
    }
}
