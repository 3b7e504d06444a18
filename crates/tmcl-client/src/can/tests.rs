use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::Request;
use tmcl_wire::can::{Length, decode_request, encode_reply, encode_version_string};
use tmcl_wire::{Reply, serial::encode_request};

use super::*;
use crate::{AnyLink, Client, ClientError, Heard, Parties, Settings};

/// A bus with one module on it, which answers with `first` as its first byte.
struct Bus {
    module_id: u16,
    host_id: u16,
    first: u8,
    memory: [u8; 7],
    accepted: Option<u16>,
    sent: Vec<CanFrame>,
    frames: VecDeque<CanFrame>,
}

impl Bus {
    fn new(module_id: u16, host_id: u16, first: u8) -> Self {
        let memory = [4, 1, 0, 0, 0, 3, 232];
        let (sent, frames) = (Vec::new(), VecDeque::new());
        Self { module_id, host_id, first, memory, accepted: None, sent, frames }
    }

    fn say(&mut self, id: u16, data: &[u8]) {
        self.frames.push_back(CanFrame::new(id, data).expect("it fits"));
    }
}

impl CanLink for Bus {
    fn accept_only(&mut self, id: u16) -> Result<(), LinkError> {
        self.accepted = Some(id);
        Ok(())
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), LinkError> {
        self.sent.push(frame);
        if frame.id() != self.module_id {
            return Ok(());
        }
        let (request, length) = decode_request(frame.data()).expect("a host sends requests");
        assert_eq!(length, Length::Seven);
        // Somebody else's, which the system lets through before there is a filter, and one of no form.
        self.say(0x700, &[9; 7]);
        self.say(self.host_id, &[1, 2, 3]);
        let reply = Reply { status: Status::Ok, command: request.command, value: request.value + 1 };
        let memory = CanFrame::new(self.host_id, &self.memory).expect("it fits");
        let data = match request {
            Request { command: 134, value: 0, .. } => {
                self.frames.push_back(memory);
                return Ok(());
            }
            Request { command: 134, .. } => {
                encode_reply(self.first, Reply { status: Status::InvalidValue, value: 0, ..reply }, length)
            }
            Request { command: 136, kind: 0, .. } => encode_version_string(*b"1311V111"),
            _ => encode_reply(self.first, reply, length),
        };
        self.say(self.host_id, data.as_slice());
        Ok(())
    }

    fn receive(&mut self, _: Duration) -> Result<Option<CanFrame>, LinkError> {
        let wanted = self.accepted.expect("the stream says what it wants");
        while let Some(frame) = self.frames.pop_front() {
            if frame.id() == wanted {
                return Ok(Some(frame));
            }
        }
        Ok(None)
    }

    fn discard(&mut self) -> Result<(), LinkError> {
        self.frames.clear();
        Ok(())
    }
}

fn client(bus: Bus, ids: CanIds, settings: Settings) -> Client<CanStream<Bus>> {
    let stream = CanStream::new(bus, ids, settings.host_address).expect("the bus works");
    Client::with_settings(stream, settings)
}

/// Every form of a reply.
fn exchange_everything(client: &mut Client<impl Link>) {
    let request = Request::new(Command::GetAxisParameter, 1, 0, 41);
    assert_eq!(client.request(request).expect("it answers").value, 42);
    assert_eq!(client.version_string().expect("it answers"), "1311V111");
    assert_eq!(client.read_program_instruction(0).expect("it answers"), [4, 1, 0, 0, 0, 3, 232]);
    match client.read_program_instruction(5000) {
        Err(ClientError::Status { status: Status::InvalidValue, .. }) => {}
        other => panic!("{other:?}"),
    }
}

#[test]
fn with_the_factorys_identifiers_nothing_need_be_said() {
    let mut client = client(Bus::new(1, 2, 1), CanIds::default(), Settings::default());
    exchange_everything(&mut client);
    let frame = CanFrame::new(1, &[6, 1, 0, 0, 0, 0, 41]).expect("it fits");
    assert_eq!(client.link_mut().can.sent[0], frame);
}

/// The low byte of 0x304 is the number of MVP, which is in the module's memory and stays there.
#[test]
fn identifiers_of_eleven_bits_and_either_first_byte() {
    let ids = CanIds { module: Some(0x304), host: Some(0x7FF) };
    for first in [4, 1] {
        exchange_everything(&mut client(Bus::new(0x304, 0x7FF, first), ids, Settings::default()));
    }
}

#[test]
fn who_answers_instead_is_reported() {
    let settings = Settings { module_address: 5, ..Settings::default() };
    let mut client = client(Bus::new(5, 2, 1), CanIds::default(), settings);
    match client.get_axis_parameter(1) {
        Err(ClientError::NoReply { heard: Heard::Other { host: 2, module: 1 }, .. }) => {}
        other => panic!("{other:?}"),
    }
}

#[test]
fn addresses_are_identifiers_until_one_is_given() {
    let mut client = client(Bus::new(200, 2, 200), CanIds::default(), Settings::default());
    assert!(matches!(client.get_axis_parameter(1), Err(ClientError::NoReply { heard: Heard::Nothing, .. })));
    client.settings_mut().module_address = 200;
    exchange_everything(&mut client);
}

/// On a bus the identifiers count and on a line the addresses; what is neither changes nothing.
#[test]
fn a_change_of_identifiers_is_followed() {
    let bus: Box<dyn CanLink> = Box::new(Bus::new(0x304, 0x7FF, 4));
    let stream = CanStream::new(bus, CanIds::default(), 2).expect("the bus works");
    let mut client = Client::new(AnyLink::Can(stream));
    assert_eq!(client.parties(), Parties { module: 1, host: 2 });
    for (parameter, value) in [
        (GlobalParameter::CanId, 0x304),
        (GlobalParameter::SerialAddress, 9),
        (GlobalParameter::CanReplyId, 0x7FF),
        (GlobalParameter::HostAddress, 9),
        (GlobalParameter::AutoStart, 1),
    ] {
        client.follow(parameter, value).expect("the bus works");
    }
    assert_eq!(client.parties(), Parties { module: 0x304, host: 0x7FF });
    exchange_everything(&mut client);
}

#[test]
fn a_change_of_addresses_is_followed() {
    let module = crate::fake::FakeModule { address: 7, ..crate::fake::FakeModule::default() };
    let mut client = Client::new(AnyLink::Bytes(Box::new(module)));
    for (parameter, value) in [
        (GlobalParameter::CanId, 0x304),
        (GlobalParameter::CanReplyId, 3),
        (GlobalParameter::SerialAddress, 256),
        (GlobalParameter::SerialAddress, -1),
        (GlobalParameter::SerialAddress, 7),
    ] {
        client.follow(parameter, value).expect("the line works");
    }
    assert_eq!(client.parties(), Parties { module: 7, host: 2 });
    client.firmware_version().expect("it answers");
}

#[test]
fn a_datagram_may_come_in_pieces() {
    let mut stream = CanStream::new(Bus::new(1, 2, 1), CanIds::default(), 2).expect("the bus works");
    let requests: Vec<u8> = (0..3)
        .flat_map(|kind| encode_request(1, Request::new(Command::GetAxisParameter, kind, 0, 0)))
        .collect();
    for piece in requests.chunks(5) {
        stream.write(piece).expect("the bus works");
    }
    let sent: Vec<_> = stream.can.sent.iter().map(|frame| frame.data()[1]).collect();
    assert_eq!(sent, [0, 1, 2]);
    // Replies come in pieces of any size, too.
    let mut reply: Vec<u8> = Vec::new();
    let mut buffer = [0; 4];
    loop {
        match stream.read(&mut buffer, Duration::ZERO).expect("the bus works") {
            0 => break,
            length => reply.extend(&buffer[..length]),
        }
    }
    assert_eq!(reply.len(), 27);
    assert_eq!(reply[..9], [2, 1, 100, 6, 0, 0, 0, 1, 110]);
}
