//! The lines between hosts and the modules of a bench: how they are wired, and what goes along them.

use module_firmware::{Line, PortId};
use tmcl_wire::can::Frame;

use super::{Bench, ModuleId, Slot};
use crate::bus::{Bus, CanStations, SerialStations, Wiring};

impl Bench {
    /// Wires a line, as after power-on: what was on its way is gone. Every line is [`Wiring::Usb`] unless it is wired.
    pub fn wire(&mut self, line: PortId, wiring: Wiring) {
        let (bus, kind) = match wiring {
            Wiring::Usb => (Bus::None, Line::Usb),
            Wiring::Rs485 { .. } => (Bus::new(wiring, self.modules_hear_replies), Line::Rs485),
            Wiring::Can { .. } => (Bus::new(wiring, self.modules_hear_replies), Line::Can),
        };
        if let Some(slot) = self.buses.get_mut(line.index()) {
            *slot = bus;
        }
        for slot in &mut self.slots {
            slot.touch().set_line(line, kind);
        }
    }

    /// The host talks at another rate from now on: bits a second of an RS485 bus that has a rate, or of a CAN bus.
    pub fn set_rate(&mut self, line: PortId, bits_per_s: u32) {
        match self.buses.get_mut(line.index()) {
            Some(Bus::Serial(bus)) => bus.set_baud(bits_per_s),
            Some(Bus::Can(bus)) => bus.set_bit_rate(bits_per_s),
            Some(Bus::None) | None => {}
        }
    }

    /// The host sends bytes along a line. Returns how many were taken; the rest may be offered again later. A CAN bus takes
    /// them all, and they mean nothing there.
    pub fn send(&mut self, line: PortId, bytes: &[u8]) -> usize {
        let Self { buses, slots, time_ns, .. } = self;
        match buses.get_mut(line.index()) {
            Some(Bus::Serial(bus)) => bus.send(bytes, *time_ns, &mut Stations { slots, port: line }),
            Some(Bus::Can(_)) => bytes.len(),
            Some(Bus::None) | None => self.receive(FIRST, line, bytes),
        }
    }

    /// Appends what the host heard on a line by now to `out`.
    pub fn take(&mut self, line: PortId, out: &mut Vec<u8>) {
        match self.buses.get_mut(line.index()) {
            Some(Bus::Serial(bus)) => bus.take(out),
            Some(Bus::Can(_)) => {}
            Some(Bus::None) | None => self.transmit(FIRST, line, out),
        }
    }

    /// The host sends bytes along a line, and what it heard by then is appended to `out`. Returns how many were taken; a bus
    /// with a baud rate may leave some, which may be offered again later.
    pub fn converse(&mut self, line: PortId, bytes: &[u8], out: &mut Vec<u8>) -> usize {
        if matches!(self.buses.get(line.index()), Some(Bus::None) | None) {
            out.extend(self.exchange(FIRST, line, bytes));
            return bytes.len();
        }
        let taken = self.send(line, bytes);
        self.take(line, out);
        taken
    }

    /// The host sends a frame along a CAN bus; on any other line frames mean nothing.
    pub fn send_frame(&mut self, line: PortId, frame: &Frame) {
        let Self { buses, slots, .. } = self;
        if let Some(Bus::Can(bus)) = buses.get_mut(line.index()) {
            bus.send(frame, &mut Stations { slots, port: line });
        }
    }

    /// The next frame that the host heard on a CAN bus by now.
    pub fn take_frame(&mut self, line: PortId) -> Option<Frame> {
        match self.buses.get_mut(line.index()) {
            Some(Bus::Can(bus)) => bus.take(),
            _ => None,
        }
    }

    /// Bits a second of a module on RS485 in effect (GP 65).
    #[must_use]
    pub fn baud_rate(&self, module: ModuleId) -> Option<u32> {
        self.slots.get(module.0).map(|slot| slot.module.get().baud_rate())
    }

    /// Whether there is something for the host to take.
    #[must_use]
    pub fn has_answer(&self, line: PortId) -> bool {
        match self.buses.get(line.index()) {
            Some(Bus::Serial(bus)) => bus.has_heard(),
            Some(Bus::Can(bus)) => bus.has_heard(),
            Some(Bus::None) | None => self.has_output(FIRST, line),
        }
    }

    /// The host at a line goes: what it left half-said or unread is forgotten by all modules.
    pub fn hang_up(&mut self, line: PortId) {
        match self.buses.get_mut(line.index()) {
            Some(Bus::Serial(bus)) => bus.hang_up(),
            Some(Bus::Can(bus)) => bus.hang_up(),
            Some(Bus::None) | None => return self.disconnect(FIRST, line),
        }
        for slot in &mut self.slots {
            slot.touch().disconnect(line);
        }
    }

    /// Everything that happens on the buses up to now. `spoke` is whether a module may have something to say.
    pub(super) fn run_buses(&mut self, spoke: bool) -> bool {
        let Self { buses, slots, time_ns, .. } = self;
        let mut happened = false;
        for (bus, line) in buses.iter_mut().zip(PortId::ALL) {
            happened |= bus.step(*time_ns, spoke, &mut Stations { slots, port: line });
        }
        happened
    }

    /// When something happens on a bus by itself.
    pub(super) fn next_bus_change_ns(&self) -> u64 {
        self.buses.iter().map(Bus::next_change_ns).min().unwrap_or(u64::MAX)
    }
}

/// The module at a line that is no bus.
const FIRST: ModuleId = ModuleId(0);

/// A port of every module.
struct Stations<'s> {
    slots: &'s mut [Slot],
    port: PortId,
}

impl SerialStations for Stations<'_> {
    fn count(&self) -> usize {
        self.slots.len()
    }

    fn baud(&self, place: usize) -> u32 {
        self.slots.get(place).map_or(0, |slot| slot.module.get().baud_rate())
    }

    fn speaks(&self, place: usize) -> bool {
        self.slots.get(place).is_some_and(|slot| slot.module.get().has_output(self.port))
    }

    fn take(&mut self, place: usize) -> Option<u8> {
        self.slots.get_mut(place)?.touch().transmit_byte(self.port)
    }

    fn give(&mut self, place: usize, byte: u8) {
        if let Some(slot) = self.slots.get_mut(place) {
            // What there is no room for is lost, as at any UART.
            let _ = slot.touch().receive(self.port, &[byte]);
        }
    }
}

impl CanStations for Stations<'_> {
    fn count(&self) -> usize {
        self.slots.len()
    }

    fn bit_rate(&self, place: usize) -> u32 {
        self.slots.get(place).map_or(0, |slot| slot.module.get().can_bit_rate())
    }

    fn take_frame(&mut self, place: usize) -> Option<Frame> {
        self.slots.get_mut(place)?.touch().transmit_frame(self.port)
    }

    fn give_frame(&mut self, place: usize, frame: &Frame) {
        if let Some(slot) = self.slots.get_mut(place) {
            slot.touch().receive_frame(self.port, frame);
        }
    }
}
