//! How requests are served: found at a port, executed, and answered there.

use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::{Event, Listener, Reply, Request, can};

use crate::axis::Axis;
use crate::dispatch::{Outcome, POSITION_REACHED_MASK};
use crate::envelope::{Envelope, Form, is_suppress_reply};
use crate::firmware::Firmware;
use crate::jobs::Pending;
use crate::line::Line;
use crate::port::{Port, PortId};

impl<A: Axis> Firmware<A> {
    /// Executes what waits in a port's inbox, until a request has to wait for the storage.
    pub(crate) fn serve(&mut self, port: PortId) {
        while !self.has_background_work() && self.serve_next(port) {}
        self.settle_rates();
    }

    /// Executes the next request; false when none waits.
    fn serve_next(&mut self, port: PortId) -> bool {
        match self.ports.get(port.index()).map(|port| (port.line, port.is_ascii())) {
            None => false,
            Some((Line::Can, _)) => self.serve_frame(port),
            Some((Line::Usb | Line::Rs485, true)) => self.serve_line(port),
            Some((Line::Usb | Line::Rs485, false)) => self.serve_datagram(port),
        }
    }

    fn serve_datagram(&mut self, port: PortId) -> bool {
        let address = self.globals.byte(GlobalParameter::SerialAddress);
        let secondary_address = self.globals.byte(GlobalParameter::SerialSecondaryAddress);
        let listener = Listener { address, secondary_address, silence: self.silence_ticks(port) };
        let ticks = self.ticks;
        match self.port_mut(port).and_then(|port| port.next_event(ticks, &listener)) {
            None => return false,
            Some(Event::WrongChecksum) => {
                let envelope = self.serial_envelope(port, address, false);
                self.answer(port, envelope, Reply::WRONG_CHECKSUM);
            }
            Some(Event::Request { address, request }) => {
                self.note_serial_request(port);
                let envelope = self.serial_envelope(port, address, is_suppress_reply(&request));
                self.serve_request(port, envelope, &request);
            }
        }
        true
    }

    /// Frames under other identifiers are none of ours, and frames of other lengths are no requests.
    fn serve_frame(&mut self, port: PortId) -> bool {
        let Some(frame) = self.port_mut(port).and_then(Port::next_frame) else { return false };
        let secondary = self.can_id(GlobalParameter::CanSecondaryId);
        let heard =
            frame.id == self.can_id(GlobalParameter::CanId) || (secondary != 0 && frame.id == secondary);
        if let Ok((request, length)) = can::decode_request(frame.data.as_slice())
            && heard
        {
            let envelope = self.can_envelope(port, frame.id, is_suppress_reply(&request), length);
            self.serve_request(port, envelope, &request);
        }
        true
    }

    pub(crate) fn serve_request(&mut self, port: PortId, envelope: Envelope, request: &Request) {
        let reply = |status, value| Reply { status, command: request.command, value };
        let executed = self.execute_request(request, port);
        self.rates.await_port(port);
        match executed {
            Err(status) => self.answer(port, envelope, reply(status, 0)),
            Ok(Outcome::Done(value)) => self.answer(port, envelope, reply(Status::Ok, value)),
            Ok(Outcome::VersionString) => {
                if let Some(port) = self.port_mut(port) {
                    port.version_string(envelope, A::SPEC.version_string);
                }
            }
            Ok(Outcome::AwaitPosition) => {
                self.answer(port, envelope, reply(Status::Ok, POSITION_REACHED_MASK));
                self.await_position(port, envelope);
                self.report_position_reached();
            }
            Ok(Outcome::Instruction(instruction)) => {
                if let Some(port) = self.port_mut(port) {
                    port.instruction(envelope, instruction);
                }
            }
            Ok(Outcome::AsciiMode(value)) => self.enter_ascii(port, envelope, reply(Status::Ok, value)),
            Ok(Outcome::Silence) => {}
            Ok(Outcome::SilentJob(job)) => {
                let envelope = Envelope { answer: false, ..envelope };
                self.pending = Some(Pending { port, envelope, reply: reply(Status::Ok, 0), job });
            }
            Ok(Outcome::Job(job, value)) => {
                self.pending = Some(Pending { port, envelope, reply: reply(Status::Ok, value), job });
            }
            Ok(Outcome::Loaded(job, value)) => {
                self.pending = Some(Pending { port, envelope, reply: reply(Status::Loaded, value), job });
            }
        }
    }

    /// Queues a reply. There is room: nothing is executed without.
    pub(crate) fn answer(&mut self, port: PortId, envelope: Envelope, reply: Reply) {
        if let Some(port) = self.port_mut(port) {
            port.reply(envelope, reply);
        }
    }

    /// Another request of command 138 waits, if it was answered at all.
    fn await_position(&mut self, port: PortId, envelope: Envelope) {
        let Some(port) = self.port_mut(port).filter(|_| envelope.answer) else { return };
        port.awaits_position = port.awaits_position.saturating_add(1);
        if let Form::Frame { length, .. } = envelope.form {
            port.event_length = length;
        }
    }

    /// The second reply of command 138 (TMCM-1311 §5.7.37), one for each request, under the addresses that count by now.
    pub(crate) fn report_position_reached(&mut self) {
        if self.ports.iter().all(|port| port.awaits_position == 0) || !self.axis.is_position_reached() {
            return;
        }
        let reply = Reply {
            status: Status::Delayed,
            command: Command::RequestPositionReachedEvent.number(),
            value: POSITION_REACHED_MASK,
        };
        // A reply that waits for the storage has its room already.
        let reserved = self.pending.as_ref().map(|pending| pending.port);
        for port in PortId::ALL.into_iter().filter(|port| Some(*port) != reserved) {
            let envelope = self.event_envelope(port);
            let Some(port) = self.port_mut(port) else { continue };
            while port.awaits_position > 0 && port.reply(envelope, reply) {
                port.awaits_position -= 1;
            }
        }
    }
}
