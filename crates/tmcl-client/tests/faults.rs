//! A client and a virtual module with a bad line between them, in virtual time: whatever the line does, every call returns,
//! says the truth about what it knows, and nothing that counts up is done twice; and when the line is good again, both are in
//! step at once.

#[path = "common/bus.rs"]
mod bus;
#[path = "common/random.rs"]
mod random;

use std::time::Duration;

use bus::{BusLink, SharedBench};
use random::Random;
use tmcl_client::{Client, ClientError, Settings};
use tmcl_link::{Direction, Faults, FaultyLink};
use tmcl_tables::tmcm_1311::AxisParameter;
use tmcl_tables::{Command, Status};
use tmcl_wire::Request;
use virtual_bench::{ModuleId, ModuleKind};

const SEEDS: u64 = 100;
const CALLS: usize = 40;

/// Longer than the silence after which a module forgets half a datagram, and shorter than some delays.
const TIMEOUT: Duration = Duration::from_millis(150);
const LONGEST_DELAY: Duration = Duration::from_millis(250);

/// No call may take longer than this: three attempts, and three timeouts to settle before, each with a few delays.
const PATIENCE: Duration = Duration::from_secs(5);

/// A variable that nobody else writes.
const VARIABLE: u8 = 7;

struct Rig {
    client: Client<FaultyLink<BusLink>>,
    bench: SharedBench,
    random: Random,
    /// Whether a download ended without the module confirming its end.
    downloading: bool,
    /// What the program memory holds at its beginning, if that is certain.
    stored: Option<Vec<[u8; 7]>>,
    travelled: i64,
    failures: usize,
}

fn number(parameter: AxisParameter) -> u8 {
    parameter.spec().number
}

impl Rig {
    fn new(seed: u64) -> Self {
        let bench = SharedBench::with(&[ModuleKind::Tmcm1311]);
        let probability = [0.002, 0.01, 0.03][(seed % 3) as usize];
        let line = FaultyLink::new(bench.link(), seed, Faults::NONE);
        let mut client = Client::with_settings(line, Settings { timeout: TIMEOUT, ..Settings::default() });
        // MVP REL shall count from the target, so that what it did can be told at once.
        client
            .set_axis_parameter(number(AxisParameter::RelativePositioningOption), 0)
            .expect("the line is good");
        for direction in [Direction::Out, Direction::In] {
            // The checksum sees every single fault, but not every two of them.
            let faults = Faults { gap: 9, ..Faults::all(probability, LONGEST_DELAY) };
            client.link_mut().set_faults(direction, faults);
        }
        let random = Random(seed);
        Self { client, bench, random, downloading: false, stored: None, travelled: 0, failures: 0 }
    }

    /// What the module really holds.
    fn held(&self, name: &str) -> i64 {
        let bench = self.bench.lock();
        let probe = bench.probe(name).expect("there is such a quantity");
        bench.read(probe) as i64
    }

    /// A call, which returns in time.
    fn call<T>(&mut self, call: impl FnOnce(&mut Client<FaultyLink<BusLink>>) -> T) -> T {
        let start = self.bench.now();
        let result = call(&mut self.client);
        let took = self.bench.now() - start;
        assert!(took <= PATIENCE, "a call took {took:?}");
        result
    }

    /// A failure says something that a line can be the cause of.
    fn note<T>(&mut self, result: Result<T, ClientError>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(
                ClientError::NoReply { .. }
                | ClientError::Status { status: Status::WrongChecksum, .. }
                | ClientError::Download { .. }
                | ClientError::DownloadEnd { .. },
            ) => {
                self.failures += 1;
                None
            }
            Err(error) => panic!("{error}"),
        }
    }

    fn anything(&mut self) {
        if self.downloading {
            return self.end_download();
        }
        match self.random.below(10) {
            0..=2 => self.move_by(),
            3 | 4 => self.write_parameter(),
            5 | 6 => self.read_parameters(),
            7 => self.write_variable(),
            8 => self.version(),
            _ => self.download(),
        }
    }

    fn move_by(&mut self) {
        let distance = self.random.between(300, 900);
        let before = self.held("target_position");
        let result = self.call(|client| client.move_by(distance));
        let moved = self.held("target_position") - before;
        let confirmed = self.note(result).is_some();
        assert!(
            moved == i64::from(distance) || (moved == 0 && !confirmed),
            "{distance}: {moved}, {confirmed}"
        );
        self.travelled += moved;
    }

    fn write_parameter(&mut self) {
        let value = self.random.between(20_000, 60_000);
        let before = self.held("max_velocity");
        let result = self.call(|client| client.set_axis_parameter(number(AxisParameter::MaxVelocity), value));
        let after = self.held("max_velocity");
        let confirmed = self.note(result).is_some();
        assert!(
            after == i64::from(value) || (after == before && !confirmed),
            "{value}: {after}, {confirmed}"
        );
    }

    fn read_parameters(&mut self) {
        for (parameter, name) in [
            (AxisParameter::MaxVelocity, "max_velocity"),
            (AxisParameter::MaxAcceleration, "max_acceleration"),
        ] {
            let result = self.call(|client| client.get_axis_parameter(number(parameter)));
            if let Some(value) = self.note(result) {
                assert_eq!(i64::from(value), self.held(name), "{name}");
            }
        }
    }

    fn write_variable(&mut self) {
        let value = self.random.next() as i32;
        let result = self.call(|client| client.set_global_parameter(2, VARIABLE, value));
        if self.note(result).is_some() {
            assert_eq!(self.held("variable.7"), i64::from(value));
        }
    }

    fn version(&mut self) {
        let result = self.call(Client::firmware_version);
        if let Some(version) = self.note(result) {
            assert_eq!(version.to_string(), "TMCM-1311 V1.11");
        }
        // Its characters have no checksum.
        let result = self.call(Client::version_string);
        if let Some(version) = self.note(result) {
            assert_eq!(version.len(), 8);
        }
    }

    fn download(&mut self) {
        let length = self.random.between(1, 6);
        let program: Vec<[u8; 7]> = (0..length)
            .map(|_| Request::new(Command::Calculate, 9, 0, self.random.between(0, 1000)).to_bytes())
            .collect();
        // A download is as many calls as it has instructions, and two.
        let calls = program.len() + 2;
        let start = self.bench.now();
        let result = self.client.download(&program, &mut |_| {});
        assert!(self.bench.now() - start <= PATIENCE * u32::try_from(calls).expect("a few"));
        self.downloading = match &result {
            Err(ClientError::Download { ended, .. }) => !ended,
            Err(_) => true,
            Ok(()) => false,
        };
        self.stored = self.note(result).map(|()| program);
    }

    fn end_download(&mut self) {
        let result = self.call(|client| client.request(Request::new(Command::DownloadEnd, 0, 0, 0)));
        self.downloading = self.note(result).is_none();
    }

    /// On a good line everything succeeds, the first time but for what the bad one left behind.
    fn recover(&mut self) {
        self.client.link_mut().set_faults(Direction::Out, Faults::NONE);
        self.client.link_mut().set_faults(Direction::In, Faults::NONE);
        if self.downloading {
            let end = Request::new(Command::DownloadEnd, 0, 0, 0);
            let ended = self.call(|client| client.request(end));
            // The module may complain about what came before.
            if !matches!(ended, Err(ClientError::Status { status: Status::WrongChecksum, .. })) {
                ended.expect("the line is good");
            }
        }
        let speed = number(AxisParameter::MaxVelocity);
        let value = self.call(|client| client.get_axis_parameter(speed)).expect("the line is good");
        assert_eq!(i64::from(value), self.held("max_velocity"));
        for value in 0..20 {
            self.call(|client| client.set_global_parameter(2, VARIABLE, value)).expect("the line is good");
            let read =
                self.call(|client| client.get_global_parameter(2, VARIABLE)).expect("the line is good");
            assert_eq!(read, value);
            let exchange = self.client.last_exchange().expect("there was one");
            assert_eq!((exchange.attempts, exchange.received.len()), (1, 9), "{exchange}");
        }
        if let Some(program) = self.stored.take() {
            self.client.verify(&program, &mut |_| {}).expect("it was stored");
        }
    }

    /// What was confirmed or may have been done is where the shaft is, to half a full step: friction holds the shaft back.
    fn arrive(&mut self) {
        let reached = number(AxisParameter::PositionReached);
        let moves =
            i64::from(self.client.get_axis_parameter(number(AxisParameter::TargetPosition)).expect("good"));
        assert_eq!(moves, self.travelled);
        while self.client.get_axis_parameter(reached).expect("the line is good") == 0 {
            self.bench.lock().advance_by(20_000_000);
        }
        self.bench.lock().advance_by(200_000_000);
        let position = self.client.get_axis_parameter(number(AxisParameter::ActualPosition)).expect("good");
        assert_eq!(i64::from(position), self.travelled);
        let turns = self.bench.lock().physical(ModuleId(0)).rotor_turns;
        let off = turns * 51_200.0 - self.travelled as f64;
        assert!(off.abs() < 128.0, "the shaft is {off} µsteps off");
    }
}

#[test]
fn every_call_returns_the_truth_and_no_move_is_made_twice() {
    let mut failures = 0;
    for seed in 0..SEEDS {
        let mut rig = Rig::new(seed);
        for _ in 0..CALLS {
            rig.anything();
        }
        rig.recover();
        rig.arrive();
        failures += rig.failures;
    }
    // A line without faults would show nothing.
    assert!(failures > 300, "{failures}");
}

/// Nothing is lost, and so nothing is reported, where bytes are only late, but not too late: a module on RS485 forgets half a
/// datagram after the time that a whole one takes at its baud rate, 9.4 ms.
#[test]
fn a_slow_line_is_a_good_line() {
    for seed in 0..20 {
        let mut rig = Rig::new(seed);
        let slow = Faults { delay: 0.1, longest_delay: Duration::from_millis(9), ..Faults::NONE };
        rig.client.link_mut().set_faults(Direction::In, slow);
        rig.client.link_mut().set_faults(Direction::Out, slow);
        for _ in 0..CALLS {
            rig.anything();
        }
        assert_eq!(rig.failures, 0);
        rig.recover();
        rig.arrive();
    }
}
