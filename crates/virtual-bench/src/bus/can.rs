//! A CAN bus: frames that reach everybody at once.

use tmcl_wire::can::Frame;

use super::heard::Heard;

/// Modules by their places, each with its port on the bus.
pub(crate) trait CanStations {
    /// How many there are.
    fn count(&self) -> usize;
    /// Bits a second of a module's CAN interface.
    fn bit_rate(&self, place: usize) -> u32;
    /// The next frame that a module has to send.
    fn take_frame(&mut self, place: usize) -> Option<Frame>;
    /// A frame arrives at a module. What it has no room for is lost.
    fn give_frame(&mut self, place: usize, frame: &Frame);
}

/// The bus.
#[derive(Clone, Debug)]
pub(crate) struct CanBus {
    bit_rate: u32,
    modules_hear_replies: bool,
    heard: Heard<Frame>,
}

impl CanBus {
    pub(crate) fn new(bit_rate: u32, modules_hear_replies: bool) -> Self {
        Self { bit_rate, modules_hear_replies, heard: Heard::new() }
    }

    pub(crate) fn set_bit_rate(&mut self, bit_rate: u32) {
        self.bit_rate = bit_rate;
    }

    /// The host sends a frame.
    pub(crate) fn send(&mut self, frame: &Frame, stations: &mut impl CanStations) {
        for place in 0..stations.count() {
            self.give(place, frame, stations);
        }
        self.round(stations);
    }

    /// Carries what the modules have to say by now; frames that come at once, by their identifiers, as the bus arbitrates.
    /// What others answer to it waits for the next round, so that two that answer each other do so for ever without
    /// stopping time. Returns whether there was anything.
    pub(crate) fn round(&mut self, stations: &mut impl CanStations) -> bool {
        let mut frames = Vec::new();
        for place in 0..stations.count() {
            // What a module says at another rate is no frame to the others.
            let understood = stations.bit_rate(place) == self.bit_rate;
            while let Some(frame) = stations.take_frame(place) {
                frames.extend(understood.then_some((place, frame)));
            }
        }
        frames.sort_by_key(|(_, frame)| frame.id);
        for (sender, frame) in &frames {
            self.heard.push(*frame);
            if self.modules_hear_replies {
                let others = (0..stations.count()).filter(|place| place != sender);
                others.for_each(|place| self.give(place, frame, stations));
            }
        }
        !frames.is_empty()
    }

    /// The next frame for the host.
    pub(crate) fn take(&mut self) -> Option<Frame> {
        self.heard.pop()
    }

    pub(crate) fn has_heard(&self) -> bool {
        !self.heard.is_empty()
    }

    /// The host goes: what it left unread is forgotten.
    pub(crate) fn hang_up(&mut self) {
        self.heard.clear();
    }

    fn give(&self, place: usize, frame: &Frame, stations: &mut impl CanStations) {
        if stations.bit_rate(place) == self.bit_rate {
            stations.give_frame(place, frame);
        }
    }
}
