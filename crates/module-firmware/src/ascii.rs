//! The ASCII interface at a port (TMCM-1311 §4.4): when a port is in ASCII mode, and what its lines lead to.
//!
//! A module whose address has no letter could not be spoken to any more, so its ports are always binary (decision).

use tmcl_tables::{GlobalParameter, Status};
use tmcl_wire::Reply;
use tmcl_wire::ascii::{Echo, Input, letter};

use crate::axis::Axis;
use crate::envelope::{Envelope, Form, is_suppress_reply};
use crate::firmware::Firmware;
use crate::port::{Ear, PortId};

/// The bit of global parameter 67 that lets ports start in ASCII mode.
const START_IN_ASCII: i32 = 1;

impl<A: Axis> Firmware<A> {
    /// The module was switched on: its ports are in the mode that global parameter 67 says.
    pub(crate) fn start_ports(&mut self) {
        let start = self.globals.setting(GlobalParameter::AsciiMode) & START_IN_ASCII != 0;
        self.starts_in_ascii = start;
        PortId::ALL.into_iter().for_each(|port| self.start_port(port));
    }

    /// A port begins, in the mode in which the module was switched on.
    pub(crate) fn start_port(&mut self, port: PortId) {
        let ascii = self.starts_in_ascii && self.has_letter();
        if let Some(port) = self.port_mut(port) {
            port.set_ascii(ascii);
        }
    }

    /// 139: the reply is still binary. CAN has no ASCII.
    pub(crate) fn enter_ascii(&mut self, port: PortId, envelope: Envelope, reply: Reply) {
        let possible = self.has_letter() && matches!(envelope.form, Form::Datagram { .. });
        if !possible {
            let refusal = Reply { status: Status::NotAvailable, value: 0, ..reply };
            return self.answer(port, envelope, refusal);
        }
        self.answer(port, envelope, reply);
        if let Some(port) = self.port_mut(port) {
            port.set_ascii(true);
        }
    }

    /// A new address may have no letter.
    pub(crate) fn leave_ascii_without_letter(&mut self) {
        if !self.has_letter() {
            self.ports.iter_mut().for_each(|port| port.set_ascii(false));
        }
    }

    /// Executes the next line; false when none is complete.
    pub(crate) fn serve_line(&mut self, port: PortId) -> bool {
        let ear = self.ear(port);
        let Some(address) = self.port_mut(port).and_then(|port| port.next_line(&ear)) else { return false };
        let input = self.port_mut(port).map(|port| port.take_line(A::SPEC));
        self.note_serial_request(port);
        let reply = |status| Reply { status, command: 0, value: 0 };
        match input {
            None => return false,
            Some(Err(status)) => {
                self.answer(port, self.ascii_envelope(port, address, false), reply(status));
            }
            Some(Ok(Input::Binary)) => {
                self.answer(port, self.ascii_envelope(port, address, false), reply(Status::Ok));
                if let Some(port) = self.port_mut(port) {
                    port.set_ascii(false);
                }
            }
            Some(Ok(Input::Request(request))) => {
                let envelope = self.ascii_envelope(port, address, is_suppress_reply(&request));
                self.serve_request(port, envelope, &request);
            }
        }
        true
    }

    /// What a port in ASCII mode listens for, and what it echoes: nothing while replies are suppressed.
    fn ear(&self, port: PortId) -> Ear {
        let silent = self.globals.setting(GlobalParameter::SuppressReply) != 0;
        let echo = Echo::from_setting(self.globals.setting(GlobalParameter::AsciiMode));
        Ear {
            address: self.globals.byte(GlobalParameter::SerialAddress),
            secondary_address: self.globals.byte(GlobalParameter::SerialSecondaryAddress),
            echo: if silent { Echo::Off } else { echo },
            ready_at: self.ready_at(port),
        }
    }

    fn has_letter(&self) -> bool {
        letter(self.globals.byte(GlobalParameter::SerialAddress)).is_some()
    }
}
