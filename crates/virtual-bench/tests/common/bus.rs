//! A host on a line with several modules.

use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::serial::{self, DATAGRAM_LENGTH};
use tmcl_wire::{Reply, Request};
use virtual_bench::config::Interface;
use virtual_bench::{Bench, ModuleId, PortId, TICK_NS, Wiring, config};

/// A reply as it was heard: host, module, and what it says.
pub(crate) type Heard = (u8, u8, Reply);

/// The host and its line.
#[derive(Clone, Debug)]
pub(crate) struct Bus {
    pub(crate) bench: Bench,
    pub(crate) line: PortId,
}

impl Bus {
    /// The bench that a file describes, on a line like this and made for it.
    #[track_caller]
    pub(crate) fn on(bench_file: &str, wiring: Wiring) -> Self {
        let mut config = config::parse(bench_file).expect("a valid bench file");
        config.bus.interface = match wiring {
            Wiring::Usb => None,
            Wiring::Rs485 { .. } => Some(Interface::Rs485),
            Wiring::Can { .. } => Some(Interface::Can),
        };
        let mut bench = Bench::new(&config);
        let line = PortId::ALL[0];
        bench.wire(line, wiring);
        Self { bench, line }
    }

    /// A TMCM-1311 at address 1 and a TMCM-1640 at address 2.
    pub(crate) fn of_two(wiring: Wiring) -> Self {
        Self::on(TWO, wiring)
    }

    /// Sends bytes, all of which must be taken.
    #[track_caller]
    pub(crate) fn send_bytes(&mut self, bytes: &[u8]) {
        assert_eq!(self.bench.send(self.line, bytes), bytes.len());
    }

    /// Sends a datagram.
    #[track_caller]
    pub(crate) fn send(&mut self, address: u8, request: Request) {
        self.send_bytes(&serial::encode_request(address, request));
    }

    /// What has been heard by now, byte by byte.
    pub(crate) fn bytes(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.bench.take(self.line, &mut bytes);
        bytes
    }

    /// What has been heard by now, which must be intact replies.
    #[track_caller]
    pub(crate) fn heard(&mut self) -> Vec<Heard> {
        let bytes = self.bytes();
        let (datagrams, rest) = bytes.as_chunks::<DATAGRAM_LENGTH>();
        assert_eq!(rest, [], "a reply has nine bytes");
        datagrams.iter().map(|bytes| serial::decode_reply(*bytes).expect("an intact reply")).collect()
    }

    /// Sends a datagram over a line without a rate, and takes exactly one reply from this address.
    #[track_caller]
    pub(crate) fn ok(&mut self, address: u8, request: Request) -> i32 {
        self.send(address, request);
        let heard = self.heard();
        let [(2, module, reply)] = heard[..] else {
            panic!("one reply wanted to {request:?}, got {heard:?}")
        };
        assert_eq!((module, reply.command), (address, request.command));
        assert_eq!(reply.status, Status::Ok, "{request:?}");
        reply.value
    }

    /// Lets virtual time pass.
    pub(crate) fn run_ticks(&mut self, ticks: u64) {
        self.bench.advance_by(ticks * TICK_NS);
    }

    /// Lets virtual time pass.
    pub(crate) fn run_ms(&mut self, ms: u64) {
        self.run_ticks(ms * super::TICKS_PER_MS);
    }

    /// What a trace's column of this name would say.
    #[track_caller]
    pub(crate) fn read(&self, name: &str) -> f64 {
        self.bench.read(self.bench.probe(name).expect("a quantity of this bench"))
    }

    /// How fast a rotor really turns.
    pub(crate) fn rpm(&self, module: usize) -> f64 {
        self.bench.physical(ModuleId(module)).velocity_rpm
    }
}

impl Bus {
    /// How far a rotor really turned.
    pub(crate) fn turns(&self, module: usize) -> f64 {
        self.bench.physical(ModuleId(module)).rotor_turns
    }

    /// A rotor really turns so far in the next second, to a hundredth or a hundredth of a turn.
    #[track_caller]
    pub(crate) fn assert_turns_in_a_second(&mut self, module: usize, wanted: f64) {
        let before = self.turns(module);
        self.run_ms(1000);
        let turned = self.turns(module) - before;
        assert!((turned - wanted).abs() < 0.01 + wanted.abs() / 100.0, "{turned} turns");
    }
}

/// A TMCM-1311 at address 1 and a TMCM-1640 at address 2.
pub(crate) const TWO: &str =
    "[[module]]\nkind = \"tmcm-1311\"\naddress = 1\n[[module]]\nkind = \"tmcm-1640\"\naddress = 2\n";

/// Two TMCM-1311.
pub(crate) fn twins(first: u8, second: u8) -> String {
    [first, second].map(|address| format!("[[module]]\nkind = \"tmcm-1311\"\naddress = {address}\n")).concat()
}

pub(crate) fn sgp(parameter: GlobalParameter, value: i32) -> Request {
    let (bank, number) = parameter.address();
    Request::new(Command::SetGlobalParameter, number, bank, value)
}

pub(crate) fn ggp(parameter: GlobalParameter) -> Request {
    let (bank, number) = parameter.address();
    Request::new(Command::GetGlobalParameter, number, bank, 0)
}

/// Sets a user variable, which is seen from outside as `variable.N`.
pub(crate) fn set_variable(number: u8, value: i32) -> Request {
    Request::new(Command::SetGlobalParameter, number, super::VARIABLES, value)
}

pub(crate) fn get_variable(number: u8) -> Request {
    Request::new(Command::GetGlobalParameter, number, super::VARIABLES, 0)
}

/// A reply that all is well.
pub(crate) fn fine(command: Command, value: i32) -> Reply {
    Reply { status: Status::Ok, command: command.number(), value }
}
