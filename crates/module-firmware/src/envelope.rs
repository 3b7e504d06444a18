//! Who is spoken to by a reply, and how: as it was when the request came, since a new address takes effect after its reply.

use tmcl_tables::GlobalParameter;
use tmcl_wire::{Request, can};

use crate::axis::Axis;
use crate::firmware::Firmware;
use crate::line::Line;
use crate::port::PortId;

/// What a reply needs besides itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Envelope {
    /// Whether there is a reply at all (global parameters 83, 87 and 255).
    pub(crate) answer: bool,
    /// The tick at which it may leave (global parameter 75).
    pub(crate) ready_at: u64,
    pub(crate) form: Form,
}

/// The form of a reply, and the addresses in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// Nine bytes.
    Datagram { host: u8, module: u8 },
    /// A line of text.
    Text { host: u8, module: u8 },
    /// A frame under this identifier, with the low byte of the module's (decision).
    Frame { id: u16, module: u8, length: can::Length },
}

impl<A: Axis> Firmware<A> {
    /// The envelope for what came to a serial address.
    pub(crate) fn serial_envelope(&self, port: PortId, address: u8, always: bool) -> Envelope {
        let module = self.globals.byte(GlobalParameter::SerialAddress);
        let host = self.globals.byte(GlobalParameter::HostAddress);
        self.envelope(port, address == module, always, Form::Datagram { host, module })
    }

    /// The envelope for a line that came to the letter of a serial address.
    pub(crate) fn ascii_envelope(&self, port: PortId, address: u8, always: bool) -> Envelope {
        let envelope = self.serial_envelope(port, address, always);
        match envelope.form {
            Form::Datagram { host, module } => Envelope { form: Form::Text { host, module }, ..envelope },
            Form::Text { .. } | Form::Frame { .. } => envelope,
        }
    }

    /// The envelope for a frame that came under a CAN identifier.
    pub(crate) fn can_envelope(&self, port: PortId, id: u16, always: bool, length: can::Length) -> Envelope {
        let own = self.can_id(GlobalParameter::CanId);
        let [_, module] = own.to_be_bytes();
        let form = Form::Frame { id: self.can_id(GlobalParameter::CanReplyId), module, length };
        self.envelope(port, id == own, always, form)
    }

    /// The envelope for what is said unasked, under the addresses that count by now.
    pub(crate) fn event_envelope(&self, port: PortId) -> Envelope {
        let address = self.globals.byte(GlobalParameter::SerialAddress);
        match self.ports.get(port.index()) {
            Some(at) if at.line == Line::Can => {
                self.can_envelope(port, self.can_id(GlobalParameter::CanId), false, at.event_length)
            }
            Some(at) if at.is_ascii() => self.ascii_envelope(port, address, false),
            _ => self.serial_envelope(port, address, false),
        }
    }

    /// A CAN identifier; their ranges end at 2047.
    pub(crate) fn can_id(&self, parameter: GlobalParameter) -> u16 {
        u16::try_from(self.globals.setting(parameter)).unwrap_or(0)
    }

    /// Only what comes to the module's own address is answered, unless it is told to be silent.
    fn envelope(&self, port: PortId, own_address: bool, always: bool, form: Form) -> Envelope {
        let suppressed = self.globals.setting(GlobalParameter::SuppressReply) != 0;
        Envelope { answer: own_address && (always || !suppressed), ready_at: self.ready_at(port), form }
    }
}

/// SGP 255, 0 is answered even while it suppresses every other reply, or nobody could see it end.
pub(crate) fn is_suppress_reply(request: &Request) -> bool {
    let (bank, number) = GlobalParameter::SuppressReply.address();
    let sgp = tmcl_tables::Command::SetGlobalParameter.number();
    (request.command, request.kind, request.motor) == (sgp, number, bank)
}
