//! A host that talks to a virtual module in process, and takes nothing that the wire format does not allow. What it says of
//! axis parameters is the TMCM-1311's; [`bldc`] has the host of a TMCM-1640, [`step`] that of a
//! TMCM-1076.
#![allow(dead_code, reason = "every test crate uses another part of it")]

pub(crate) mod bldc;
pub(crate) mod bus;
pub(crate) mod closed_loop;
pub(crate) mod motion;
pub(crate) mod program;
pub(crate) mod step;

use std::fmt::Display;

use tmcl_tables::tmcm_1311::AxisParameter;
use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::serial::{self, DATAGRAM_LENGTH};
use tmcl_wire::{Reply, Request};
use virtual_bench::config::{SettingValue, parse_setting};
use virtual_bench::{Bench, BenchConfig, Eeprom, ModuleId, ModuleKind, Physical, PortId, TICK_NS, config};

/// The bank of the user variables (§10.3).
pub(crate) const VARIABLES: u8 = 2;

/// The EEPROM in the motor field of SCO and GCO.
pub(crate) const EEPROM: u8 = 255;

/// Control periods in a millisecond.
pub(crate) const TICKS_PER_MS: u64 = 1_000_000 / TICK_NS;

/// µsteps in a turn at 256 µsteps per full step.
pub(crate) const TURN: i32 = 51_200;

pub(crate) const MODULE: ModuleId = ModuleId(0);

/// A module, and where the host believes it and itself to be.
#[derive(Clone, Debug)]
pub(crate) struct Module {
    pub(crate) bench: Bench,
    config: BenchConfig,
    pub(crate) port: PortId,
    pub(crate) address: u8,
    pub(crate) host: u8,
}

impl Module {
    /// A module as delivered: address 1, host 2 (decisions 2a.20).
    pub(crate) fn new() -> Self {
        Self::with(BenchConfig::default_for(ModuleKind::Tmcm1311))
    }

    /// A module of a kind that has what an image of an EEPROM holds, and otherwise nothing of the module it was in.
    #[track_caller]
    pub(crate) fn with_image(kind: ModuleKind, image: &[u8]) -> Self {
        let config = BenchConfig::default_for(kind);
        let eeprom = Eeprom::from_image(image).expect("an intact image");
        let bench = Bench::with_eeproms(&config, |_| Some(eeprom.clone()));
        Self { bench, config, port: PortId::ALL[0], address: 1, host: 2 }
    }

    /// What is left of it when the process ends.
    pub(crate) fn image(&self) -> Vec<u8> {
        self.bench.eeprom(MODULE).expect("an EEPROM").to_image()
    }

    /// The first module of the bench that a bench file describes.
    #[track_caller]
    pub(crate) fn on(bench_file: &str) -> Self {
        Self::with(config::parse(bench_file).expect("a valid bench file"))
    }

    fn with(config: BenchConfig) -> Self {
        Self { bench: Bench::new(&config), config, port: PortId::ALL[0], address: 1, host: 2 }
    }

    /// Bytes to the module, and what comes back in no virtual time.
    pub(crate) fn exchange(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.bench.exchange(MODULE, self.port, bytes)
    }

    /// Sends a datagram; whatever comes back must be whole, intact and from this module to this host.
    #[track_caller]
    pub(crate) fn replies(&mut self, request: Request) -> Vec<Reply> {
        let bytes = self.exchange(&serial::encode_request(self.address, request));
        self.decode(&bytes)
    }

    /// Sends a datagram and takes exactly one reply, to this very command; an error carries the value 0 (decisions 1.4).
    #[track_caller]
    pub(crate) fn request(&mut self, request: Request) -> Reply {
        let replies = self.replies(request);
        let [reply] = replies[..] else { panic!("one reply wanted to {request:?}, got {replies:?}") };
        assert_eq!(reply.command, request.command, "{request:?}");
        if reply.status != Status::Ok {
            assert_eq!(reply.value, 0, "{request:?} got {reply:?}");
        }
        reply
    }

    /// [`Module::request`], by its fields.
    #[track_caller]
    pub(crate) fn send(&mut self, command: Command, kind: u8, motor: u8, value: i32) -> Reply {
        self.request(Request::new(command, kind, motor, value))
    }

    /// Sends what must succeed, and returns the value of the reply.
    #[track_caller]
    pub(crate) fn ok(&mut self, command: Command, kind: u8, motor: u8, value: i32) -> i32 {
        let reply = self.send(command, kind, motor, value);
        assert_eq!(reply.status, Status::Ok, "{command:?} {kind}, {motor}, {value}");
        reply.value
    }

    /// The status of the reply.
    #[track_caller]
    pub(crate) fn status(&mut self, command: Command, kind: u8, motor: u8, value: i32) -> Status {
        self.send(command, kind, motor, value).status
    }

    /// Sends what must be executed but not answered.
    #[track_caller]
    pub(crate) fn unanswered(&mut self, command: Command, kind: u8, motor: u8, value: i32) {
        let request = Request::new(command, kind, motor, value);
        assert_eq!(self.replies(request), [], "{request:?}");
    }

    /// SAP, which must succeed.
    #[track_caller]
    pub(crate) fn sap(&mut self, parameter: AxisParameter, value: i32) {
        self.ok(Command::SetAxisParameter, parameter.number(), 0, value);
    }

    /// GAP, which must succeed.
    #[track_caller]
    pub(crate) fn gap(&mut self, parameter: AxisParameter) -> i32 {
        self.ok(Command::GetAxisParameter, parameter.number(), 0, 0)
    }

    /// SGP in bank 0 or 3, which must succeed.
    #[track_caller]
    pub(crate) fn sgp(&mut self, parameter: GlobalParameter, value: i32) {
        let (bank, number) = parameter.address();
        self.ok(Command::SetGlobalParameter, number, bank, value);
    }

    /// GGP in bank 0 or 3, which must succeed.
    #[track_caller]
    pub(crate) fn ggp(&mut self, parameter: GlobalParameter) -> i32 {
        let (bank, number) = parameter.address();
        self.ok(Command::GetGlobalParameter, number, bank, 0)
    }

    /// A user variable.
    #[track_caller]
    pub(crate) fn variable(&mut self, number: u8) -> i32 {
        self.ok(Command::GetGlobalParameter, number, VARIABLES, 0)
    }

    /// A coordinate.
    #[track_caller]
    pub(crate) fn coordinate(&mut self, number: u8) -> i32 {
        self.ok(Command::GetCoordinate, number, 0, 0)
    }

    /// Replies that came of themselves, such as the second one to command 138.
    #[track_caller]
    pub(crate) fn unasked(&mut self) -> Vec<Reply> {
        let mut bytes = Vec::new();
        self.bench.transmit(MODULE, self.port, &mut bytes);
        self.decode(&bytes)
    }

    /// Lets virtual time pass.
    pub(crate) fn run_ticks(&mut self, ticks: u64) {
        self.bench.advance_by(ticks * TICK_NS);
    }

    /// Lets virtual time pass.
    pub(crate) fn run_ms(&mut self, ms: u64) {
        self.run_ticks(ms * TICKS_PER_MS);
    }

    /// Switches off and on.
    pub(crate) fn power_cycle(&mut self) {
        self.bench.power_cycle(MODULE);
    }

    /// How far the rotor really turned.
    pub(crate) fn turns(&self) -> f64 {
        self.physical().rotor_turns
    }

    /// The truth about the shaft.
    pub(crate) fn physical(&self) -> Physical {
        self.bench.physical(MODULE)
    }

    /// Changes something about the surroundings, by the name that a bench file's events call it.
    #[track_caller]
    pub(crate) fn set(&mut self, name: &str, value: impl Display) {
        let value = value.to_string();
        let settings = parse_setting(&self.config, name, SettingValue::from(value.as_str()));
        let settings = settings.expect("a setting of this bench");
        for (module, setting) in settings {
            self.bench.apply(ModuleId(module), setting);
        }
    }

    /// What a trace's column of this name would say.
    #[track_caller]
    pub(crate) fn read(&self, name: &str) -> f64 {
        self.bench.read(self.bench.probe(name).expect("a quantity of this bench"))
    }

    /// Runs until AP 8 is set.
    #[track_caller]
    pub(crate) fn arrive(&mut self) {
        for _ in 0..600_000 {
            if self.read("position_reached") == 1.0 {
                return;
            }
            self.run_ticks(1);
        }
        panic!("the target is never reached; the position is {}", self.gap(AxisParameter::ActualPosition));
    }

    #[track_caller]
    fn decode(&self, bytes: &[u8]) -> Vec<Reply> {
        let (datagrams, rest) = bytes.as_chunks::<DATAGRAM_LENGTH>();
        assert_eq!(rest, [], "a reply has nine bytes");
        let decoded = datagrams.iter().map(|datagram| {
            let (host, module, reply) = serial::decode_reply(*datagram).expect("an intact reply");
            assert_eq!((host, module), (self.host, self.address), "{reply:?}");
            reply
        });
        decoded.collect()
    }
}
