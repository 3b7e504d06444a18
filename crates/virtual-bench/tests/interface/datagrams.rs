//! What comes in over the wire, good and bad (decisions §1): each well-formed datagram for this module gets exactly one
//! well-formed reply, and nothing else gets any.
//!
//! A million datagrams from a seeded generator, against a model that knows just enough of the module to tell what must
//! come back: who it and its host are, whether it may speak, what a restart would make of that, and how an empty program
//! is doing.

use crate::common::{Module, VARIABLES};
use tmcl_tables::tmcm_1311::SPEC;
use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::serial::{self, DATAGRAM_LENGTH};
use tmcl_wire::{Reply, Request};

type Datagram = [u8; DATAGRAM_LENGTH];

/// The version string's request, which has a reply of its own shape.
const VERSION_STRING: (u8, u8) = (Command::FirmwareVersion.number(), 0);

const RESET_VALUE: i32 = 1234;

/// xorshift64: small, seeded, the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, bound: u64) -> u64 {
        (self.next() >> 16) % bound
    }

    fn byte(&mut self) -> u8 {
        self.next().to_be_bytes()[2]
    }

    fn one_in(&mut self, chance: u64) -> bool {
        self.below(chance) == 0
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len() as u64) as usize]
    }
}

/// The state of a program that is all STOP, since nothing is ever downloaded: mode and program counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Program {
    mode: i32,
    counter: i32,
}

impl Program {
    const STOPPED: Self = Self { mode: 0, counter: 0 };
    const RUNNING: Self = Self { mode: 1, counter: 0 };

    /// What command 135 reports (decisions 1.8).
    fn status(self) -> i32 {
        self.mode << 24 | self.counter
    }

    /// The status that 128 to 131 get, and what they do (decisions 1.6).
    fn command(&mut self, Request { command, kind, value, .. }: Request) -> Status {
        match (command, kind) {
            (128, _) => self.mode = 0,
            (129, 0) => self.mode = 1,
            (129, 1) if (0..2048).contains(&value) => *self = Self { mode: 1, counter: value },
            (129, 1) => return Status::InvalidValue,
            (129, _) => return Status::WrongType,
            // It executes STOP at once.
            (130, _) => self.mode = 0,
            (131, _) => *self = Self { mode: 3, counter: 0 },
            _ => {}
        }
        Status::Ok
    }

    /// A running program executes STOP.
    fn tick(&mut self) {
        if self.mode == 1 {
            self.mode = 0;
        }
    }
}

/// What decides whether and how the module replies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Model {
    address: u8,
    host: u8,
    secondary: u8,
    suppressed: bool,
    locked: bool,
    magic: i32,
    /// Global parameters 77 and 81.
    auto_start: bool,
    protection: i32,
    program: Program,
    /// Requests of 138 whose event is still to come.
    events: u32,
}

impl Model {
    /// As delivered (decisions 2a.20).
    const FACTORY: Self = Self {
        address: 1,
        host: 2,
        secondary: 0,
        suppressed: false,
        locked: false,
        magic: 228,
        auto_start: false,
        protection: 0,
        program: Program::STOPPED,
        events: 0,
    };

    /// Switched off and on: all but the suppression is stored, unless the magic says to forget it (decisions 2a.13).
    fn restart(&mut self) {
        let program = if self.auto_start { Program::RUNNING } else { Program::STOPPED };
        *self = if self.magic == 228 {
            Self { suppressed: false, events: 0, program, ..*self }
        } else {
            Self::FACTORY
        };
    }

    /// A global parameter of bank 0 was written.
    fn written(&mut self, number: u8, value: i32) {
        match GlobalParameter::from_address(0, number) {
            Some(GlobalParameter::SerialAddress) => self.address = value as u8,
            Some(GlobalParameter::HostAddress) => self.host = value as u8,
            Some(GlobalParameter::SerialSecondaryAddress) => self.secondary = value as u8,
            Some(GlobalParameter::SuppressReply) => self.suppressed = value == 1,
            Some(GlobalParameter::EepromLock) => self.locked = value == 1234,
            Some(GlobalParameter::EepromMagic) => self.magic = value,
            Some(GlobalParameter::AutoStart) => self.auto_start = value == 1,
            Some(GlobalParameter::CodeProtection) => {
                if self.protection & !value & 1 != 0 {
                    self.program.mode = 0; // erased
                }
                self.protection = value;
            }
            _ => {}
        }
    }
}

/// Global parameters of bank 0 that the model follows.
fn is_tracked(number: u8) -> bool {
    matches!(
        GlobalParameter::from_address(0, number),
        Some(
            GlobalParameter::SerialAddress
                | GlobalParameter::HostAddress
                | GlobalParameter::SerialSecondaryAddress
                | GlobalParameter::SuppressReply
                | GlobalParameter::EepromLock
                | GlobalParameter::EepromMagic
                | GlobalParameter::AutoStart
                | GlobalParameter::CodeProtection
        )
    )
}

/// The status of SGP in bank 0, by decisions §2 and 2a.10: type, then lock, then value.
fn status_of_sgp(number: u8, value: i32, locked: bool) -> Status {
    match SPEC.global_parameter(0, number).map(|entry| &entry.parameter) {
        None => Status::WrongType,
        Some(spec) if !spec.access.write => Status::WrongType,
        Some(_) if locked && (64..=127).contains(&number) && number != 73 => Status::EepromLocked,
        Some(spec) if !spec.allows_write(value) => Status::InvalidValue,
        Some(_) => Status::Ok,
    }
}

/// What was fed in, for the message when something is wrong.
#[derive(Default, Debug)]
struct Counts {
    answered: u64,
    wrong_checksum: u64,
    foreign: u64,
    partial: u64,
    secondary: u64,
    suppressed: u64,
    restarts: u64,
    events: u64,
    /// Reports of command 135, by mode.
    modes: [u64; 4],
}

/// A module, the model of it, and what it has said that nobody has looked at yet.
struct Judge {
    module: Module,
    model: Model,
    heard: Vec<u8>,
    counts: Counts,
}

impl Judge {
    fn new() -> Self {
        Self { module: Module::new(), model: Model::FACTORY, heard: Vec::new(), counts: Counts::default() }
    }

    /// Feeds bytes, in one piece or in two with less than the permitted silence between.
    fn feed(&mut self, bytes: &[u8], random: &mut Random) {
        let cut = if random.one_in(50) { random.below(bytes.len() as u64 + 1) as usize } else { bytes.len() };
        let (first, rest) = bytes.split_at(cut);
        self.heard.extend(self.module.exchange(first));
        if !rest.is_empty() {
            self.pass(random.below(40));
            self.heard.extend(self.module.exchange(rest));
        }
    }

    /// Longer than a stream may be silent within a datagram (decisions 1.3).
    fn silence(&mut self) {
        self.run_ticks(101 * crate::common::TICKS_PER_MS);
    }

    fn pass(&mut self, ticks: u64) {
        self.module.run_ticks(ticks);
        if ticks > 0 {
            self.model.program.tick();
        }
    }

    fn run_ticks(&mut self, ticks: u64) {
        self.pass(ticks);
        self.heard.extend(self.module.exchange(&[]));
    }

    /// Takes the next nine bytes heard, setting the events of command 138 aside.
    #[track_caller]
    fn next_heard(&mut self, context: &[u8]) -> Option<Datagram> {
        loop {
            let Some((datagram, rest)) = self.heard.split_first_chunk::<DATAGRAM_LENGTH>() else {
                assert_eq!(self.heard, [], "part of a reply to {context:02x?}, {:?}", self.model);
                return None;
            };
            let datagram = *datagram;
            let is_event = matches!(
                serial::decode_reply(datagram),
                Ok((_, _, Reply { status: Status::Delayed, command: 138, value: 1 }))
            );
            if !is_event {
                self.heard = rest.to_vec();
                return Some(datagram);
            }
            assert!(self.model.events > 0, "an event nobody asked for; {context:02x?}, {:?}", self.model);
            self.heard = rest.to_vec();
            self.model.events -= 1;
            self.counts.events += 1;
        }
    }

    /// The reply to this request; well-formed, or the test fails.
    #[track_caller]
    fn reply(&mut self, request: Request, context: &[u8]) -> Reply {
        let datagram = self.next_heard(context);
        let datagram = datagram.unwrap_or_else(|| panic!("no reply to {context:02x?}, {:?}", self.model));
        let decoded = serial::decode_reply(datagram);
        let Ok((host, module, reply)) = decoded else { panic!("{datagram:02x?} to {context:02x?}") };
        assert_eq!((host, module), (self.model.host, self.model.address), "to {context:02x?}");
        assert_eq!(reply.command, request.command, "to {context:02x?}");
        if reply.status != Status::Ok {
            assert_eq!(reply.value, 0, "{reply:?} to {context:02x?}");
        }
        reply
    }

    #[track_caller]
    fn nothing_more(&mut self, context: &[u8]) {
        let surplus = self.next_heard(context);
        assert_eq!(surplus, None, "surplus after {context:02x?}, {:?}", self.model);
    }

    /// Judges what was heard after one whole datagram.
    #[track_caller]
    fn judge(&mut self, datagram: Datagram) {
        let for_us = datagram[0] == self.model.address;
        let for_group = !for_us && self.model.secondary != 0 && datagram[0] == self.model.secondary;
        match serial::decode_request(datagram) {
            Ok((_, request)) if for_us => self.judge_request(request, true, &datagram),
            Ok((_, request)) if for_group => {
                self.counts.secondary += 1;
                self.judge_request(request, false, &datagram);
            }
            Ok(_) => {
                self.counts.foreign += 1;
                self.nothing_more(&datagram);
            }
            Err(_) if for_us && !self.model.suppressed => {
                self.counts.wrong_checksum += 1;
                let expected =
                    serial::encode_reply(self.model.host, self.model.address, Reply::WRONG_CHECKSUM);
                assert_eq!(self.next_heard(&datagram), Some(expected), "to {datagram:02x?}");
                self.nothing_more(&datagram);
            }
            Err(_) => {
                self.nothing_more(&datagram);
                // Whatever that was, silence puts the two of us in step again.
                self.silence();
                self.nothing_more(&datagram);
            }
        }
    }

    /// A request for us; `aloud` unless it came by the secondary address, which never answers.
    #[track_caller]
    fn judge_request(&mut self, request: Request, aloud: bool, context: &[u8]) {
        let bank_0 = request.motor == 0;
        let sets_suppression =
            (request.command, request.kind) == (Command::SetGlobalParameter.number(), 255) && bank_0;
        let answered = aloud && (!self.model.suppressed || sets_suppression);
        match Command::ALL.iter().find(|command| command.number() == request.command) {
            Some(Command::FactoryReset) if request.value == RESET_VALUE => {
                // No reply (§5.7.39); ignored while locked (decisions 2a.10). When it takes effect the manual does not
                // say, so it is followed by a restart.
                self.nothing_more(context);
                self.module.power_cycle();
                self.counts.restarts += 1;
                if !self.model.locked {
                    self.model = Model::FACTORY;
                }
                self.model.restart();
                return;
            }
            Some(Command::SoftwareReset) if request.value == RESET_VALUE => {
                // "The reply may be lost" (decisions 1.6).
                if answered && !self.heard.is_empty() {
                    assert_eq!(self.reply(request, context).status, Status::Ok);
                }
                self.nothing_more(context);
                self.model.restart();
                self.run_ticks(20);
                self.counts.restarts += 1;
                self.nothing_more(context);
                return;
            }
            _ => {}
        }
        if !answered {
            self.counts.suppressed += u64::from(aloud);
        } else if (request.command, request.kind) == VERSION_STRING {
            let expected = serial::encode_version_string(self.model.host, *b"1311V111");
            assert_eq!(self.next_heard(context), Some(expected), "to {context:02x?}");
            self.counts.answered += 1;
        } else if self.reads_program(request) {
            // Erased memory reads as STOP (decisions 3.1).
            let expected = serial::encode_instruction(self.model.host, [28, 0, 0, 0, 0, 0, 0]);
            assert_eq!(self.next_heard(context), Some(expected), "to {context:02x?}");
            self.counts.answered += 1;
        } else {
            let reply = self.reply(request, context);
            self.counts.answered += 1;
            self.follow(request, reply);
            self.nothing_more(context);
            return;
        }
        self.nothing_more(context);
        self.model.program.command(request);
        if request.command == Command::SetGlobalParameter.number() && bank_0 {
            let status = status_of_sgp(request.kind, request.value, self.model.locked);
            if status == Status::Ok {
                self.model.written(request.kind, request.value);
            }
        }
    }

    /// Whether 134 has something to show (decisions 1.7).
    fn reads_program(&self, request: Request) -> bool {
        request.command == Command::ReadProgramMemory.number()
            && self.model.protection & 1 == 0
            && (0..2048).contains(&request.value)
    }

    /// What an answered request changes for those to come.
    #[track_caller]
    fn follow(&mut self, request: Request, reply: Reply) {
        let done = reply.status == Status::Ok;
        match Command::ALL.iter().find(|command| command.number() == request.command) {
            Some(Command::RequestPositionReachedEvent) if done => self.model.events += 1,
            Some(Command::SetGlobalParameter) if request.motor == 0 => {
                let expected = status_of_sgp(request.kind, request.value, self.model.locked);
                assert_eq!(reply.status, expected, "{request:?}, {:?}", self.model);
                if done {
                    self.model.written(request.kind, request.value);
                }
            }
            // AGP replies with the accumulator, which is what it wrote (decisions 3.9).
            Some(Command::AccumulatorToGlobalParameter) if done && request.motor == 0 => {
                self.model.written(request.kind, reply.value);
            }
            Some(
                Command::ApplicationStop
                | Command::ApplicationRun
                | Command::ApplicationStep
                | Command::ApplicationReset,
            ) => {
                assert_eq!(reply.status, self.model.program.command(request), "{request:?}");
            }
            Some(Command::ApplicationStatus) => {
                assert_eq!(reply.value, self.model.program.status(), "{:?}", self.model);
                self.counts.modes[self.model.program.mode as usize] += 1;
            }
            Some(Command::ReadProgramMemory) => {
                let protected = self.model.protection & 1 != 0;
                let expected = if protected { Status::NotAvailable } else { Status::InvalidValue };
                assert_eq!(reply.status, expected, "{request:?}");
            }
            Some(Command::GetGlobalParameter) if request.motor == 0 => {
                let expected = match request.kind {
                    128 => self.model.program.mode,
                    129 => 0,
                    130 => self.model.program.counter,
                    _ => reply.value,
                };
                assert_eq!(reply.value, expected, "{request:?}, {:?}", self.model);
            }
            Some(_) => {}
            None => assert_eq!(reply.status, Status::InvalidCommand, "{request:?}"),
        }
    }
}

/// A request worth sending: mostly commands there are, with numbers there are, and values near the edges.
fn plausible(random: &mut Random) -> Request {
    let command = random.pick(SPEC.commands).spec.number;
    let kind = match random.below(6) {
        0 => random.byte(),
        1 => random.below(22) as u8,
        2 => random.pick(&[255, 20, 21]),
        3 => random.pick(&[64, 66, 73, 76, 84, 85, 87, 132, 133, 255]),
        _ => random.pick(SPEC.axis_parameters).number,
    };
    let motor = random.pick(&[0, 0, 0, 0, 0, 0, 1, 2, 2, 3, 255, 7]);
    let value = match random.below(8) {
        0 => random.next() as i32,
        1 => random.pick(&[i32::MIN, i32::MAX, -1, 256, 255]),
        2 => random.pick(&[1234, 4321, 228]),
        3 => random.below(300_000) as i32 - 150_000,
        4 => random.below(256) as i32,
        _ => random.below(3) as i32,
    };
    Request { command, kind, motor, value }
}

/// A request that changes who answers whom, or makes the module speak unasked.
fn unsettling(random: &mut Random) -> Request {
    let byte = i32::from(random.byte());
    let (command, kind, value) = match random.below(14) {
        0 => (Command::SetGlobalParameter, 66, byte),
        1 => (Command::SetGlobalParameter, 76, byte),
        2 => (Command::SetGlobalParameter, 87, byte),
        3 => (Command::SetGlobalParameter, 255, byte & 1),
        4 => (Command::SetGlobalParameter, 73, random.pick(&[1234, 4321, 4321, byte])),
        5 => (Command::SetGlobalParameter, 64, random.pick(&[228, 228, byte])),
        6 => (Command::Calculate, 9, byte),
        7 => (Command::AccumulatorToGlobalParameter, random.pick(&[66, 76, 77, 81, 87, 255]), 0),
        8 => (Command::MoveToPosition, 1, byte - 128),
        9 if random.one_in(5) => (Command::FactoryReset, 0, RESET_VALUE),
        10 if random.one_in(5) => (Command::SoftwareReset, 0, RESET_VALUE),
        11 => (Command::SetGlobalParameter, 77, byte & 1),
        12 => (Command::SetGlobalParameter, 81, byte & 3),
        _ => (Command::RequestPositionReachedEvent, 0, 0),
    };
    Request::new(command, kind, 0, value)
}

/// A request about the program.
fn about_program(random: &mut Random) -> Request {
    let address = random.pick(&[0, 1, 2047, 2048, -1, 65_536]);
    let read = |number| Request::new(Command::GetGlobalParameter, number, 0, 0);
    match random.below(12) {
        0 => Request::new(Command::ApplicationStop, random.byte(), random.byte(), address),
        1..=3 => Request::new(Command::ApplicationRun, random.below(3) as u8, random.byte(), address),
        4 => Request::new(Command::ApplicationStep, random.byte(), random.byte(), address),
        5 => Request::new(Command::ApplicationReset, random.byte(), random.byte(), address),
        6 => Request::new(Command::DownloadEnd, random.byte(), random.byte(), address),
        7 => Request::new(Command::ReadProgramMemory, random.byte(), random.byte(), address),
        8 => read(128 + random.below(3) as u8),
        _ => Request::new(Command::ApplicationStatus, random.byte(), random.byte(), address),
    }
}

/// What the generator leaves out, because the model could not tell what follows.
fn is_out_of_scope(request: Request, aloud: bool) -> bool {
    // ASCII mode (139) ends the binary conversation (decisions 1.10, 2a.16); likewise bit 0 of global parameter 67 at the
    // next restart.
    if request.command == Command::EnterAsciiMode.number() {
        return true;
    }
    // A download keeps everything that follows from being executed.
    if request.command == Command::DownloadStart.number() {
        return true;
    }
    let writes_setting = request.motor == 0;
    let sgp = request.command == Command::SetGlobalParameter.number() && writes_setting;
    let agp = request.command == Command::AccumulatorToGlobalParameter.number() && writes_setting;
    let ascii = request.kind == 67;
    // The accumulator is only known from replies.
    (sgp && ascii) || (agp && (ascii || (is_tracked(request.kind) && !aloud)))
}

#[test]
fn a_million_datagrams_get_the_replies_they_deserve_and_no_others() {
    let rounds = if cfg!(debug_assertions) { 20_000 } else { 1_000_000 };
    let mut random = Random(0x1311_0111_2014_0317);
    let mut judge = Judge::new();
    let mut sent = 0;
    while sent < rounds {
        sent += 1;
        if random.one_in(20) {
            judge.run_ticks(random.below(30));
            judge.nothing_more(b"time passing");
        }
        // Back where anybody can reach it, now and then: silent modules and foreign addresses teach little.
        if random.one_in(100) && judge.model.suppressed {
            let request = Request::new(Command::SetGlobalParameter, 255, 0, 0);
            let datagram = serial::encode_request(judge.model.address, request);
            judge.feed(&datagram, &mut random);
            judge.judge(datagram);
        }
        let secondary = judge.model.secondary != 0 && random.one_in(30);
        let address = if secondary { judge.model.secondary } else { judge.model.address };
        let aloud = !judge.model.suppressed && address == judge.model.address;
        let request = match random.below(60) {
            0..=19 => Request::from_bytes(core::array::from_fn(|_| random.byte())),
            20..=21 => unsettling(&mut random),
            22..=25 => about_program(&mut random),
            _ => plausible(&mut random),
        };
        let mut datagram = serial::encode_request(address, request);
        match random.below(40) {
            0..=1 => datagram = serial::encode_request(random.byte(), request),
            2..=5 => datagram[8] = random.byte(),
            6..=11 => {
                // Seldom in the address: what nobody is addressed by wants silence after it, and that takes long.
                let bit = if random.one_in(20) { random.below(72) } else { 8 + random.below(64) };
                datagram[(bit / 8) as usize] ^= 1 << (bit % 8);
            }
            12 if random.one_in(20) => datagram = core::array::from_fn(|_| random.byte()),
            13 if random.one_in(20) => {
                // Part of a datagram, then silence: as if it had never been.
                let length = 1 + random.below(8) as usize;
                judge.feed(&datagram[..length], &mut random);
                judge.silence();
                judge.nothing_more(&datagram[..length]);
                judge.counts.partial += 1;
                continue;
            }
            _ => {}
        }
        if let Ok((address, request)) = serial::decode_request(datagram) {
            let aloud = aloud && address == judge.model.address;
            if is_out_of_scope(request, aloud) {
                continue;
            }
        }
        judge.feed(&datagram, &mut random);
        judge.judge(datagram);
    }
    let counts = &judge.counts;
    println!("{counts:?}");
    let Counts { answered, wrong_checksum, foreign, partial, secondary, suppressed, restarts, events, modes } =
        *counts;
    let rarest =
        [wrong_checksum, foreign, partial, secondary, suppressed, restarts, events].into_iter().min();
    assert!(answered > rounds / 2 && rarest > Some(rounds / 2000), "the generator misses a kind: {counts:?}");
    let [stopped, running, stepping, reset] = modes;
    assert!(stopped.min(running).min(reset) > rounds / 2000 && stepping == 0, "{counts:?}");
}

#[test]
fn datagrams_without_a_pause_are_answered_in_order() {
    let mut module = Module::new();
    let requests = (0..200_u8).map(|number| Request::new(Command::SetGlobalParameter, number, VARIABLES, 7));
    let bytes: Vec<u8> = requests.flat_map(|request| serial::encode_request(1, request)).collect();
    let answers = module.exchange(&bytes);
    let reply = Reply { status: Status::Ok, command: 9, value: 7 };
    assert_eq!(answers, serial::encode_reply(2, 1, reply).repeat(200));
    assert_eq!(module.variable(199), 7);
}

const QUESTION: Request = Request::new(Command::GetGlobalParameter, 66, 0, 0);

/// Decisions 1.3.
#[test]
fn a_wrong_checksum_is_status_1_command_0_value_0_and_executes_nothing() {
    let mut module = Module::new();
    let good = serial::encode_request(1, Request::new(Command::SetGlobalParameter, 3, VARIABLES, 77));
    for difference in 1..=255 {
        let mut spoiled = good;
        spoiled[8] ^= difference;
        assert_eq!(module.exchange(&spoiled), [2, 1, 1, 0, 0, 0, 0, 0, 4]);
    }
    assert_eq!(module.variable(3), 0);
}

#[test]
fn other_addresses_are_not_answered() {
    let mut module = Module::new();
    for address in (0..=255).filter(|address| *address != 1) {
        assert_eq!(module.exchange(&serial::encode_request(address, QUESTION)), []);
    }
    assert_eq!(module.ggp(GlobalParameter::SerialAddress), 1, "still in step");
}

/// 100 ms on a stream without a baud rate (decisions 1.3).
#[test]
fn a_partial_datagram_is_dropped_after_100_ms_of_silence_and_not_before() {
    for length in 1..DATAGRAM_LENGTH {
        let mut module = Module::new();
        let datagram = serial::encode_request(1, QUESTION);
        module.exchange(&datagram[..length]);
        module.run_ms(99);
        assert_eq!(module.exchange(&datagram[length..]).len(), DATAGRAM_LENGTH, "{length}: a slow sender");

        module.exchange(&datagram[..length]);
        module.run_ms(101);
        assert_eq!(module.unasked(), []);
        assert_eq!(module.ggp(GlobalParameter::SerialAddress), 1, "{length}: dropped");
    }
}

/// Byte by byte it takes 800 ms, but the line is never silent for long.
#[test]
fn only_silence_between_two_bytes_counts() {
    let mut module = Module::new();
    let (last, before) =
        serial::encode_request(1, QUESTION).split_last().map(|(l, b)| (*l, b.to_vec())).unwrap();
    for byte in before {
        assert_eq!(module.exchange(&[byte]), []);
        module.run_ms(99);
    }
    assert_eq!(module.exchange(&[last]).len(), DATAGRAM_LENGTH);
}

/// Each port finds its own requests, and answers where it was asked.
#[test]
fn ports_do_not_mix() {
    let mut module = Module::new();
    let datagram = serial::encode_request(1, QUESTION);
    for (index, port) in virtual_bench::PortId::ALL.into_iter().enumerate() {
        module.port = port;
        assert_eq!(module.exchange(&datagram[..=index]), []);
    }
    for (index, port) in virtual_bench::PortId::ALL.into_iter().enumerate() {
        module.port = port;
        assert_eq!(module.exchange(&datagram[index + 1..]).len(), DATAGRAM_LENGTH, "{port:?}");
    }
}

/// What a client left half-said is not held against the next one.
#[test]
fn a_client_that_goes_away_takes_its_half_datagram_along() {
    let mut module = Module::new();
    module.exchange(&[1, 6, 1]);
    module.bench.disconnect(virtual_bench::ModuleId(0), module.port);
    assert_eq!(module.ggp(GlobalParameter::SerialAddress), 1);
}
