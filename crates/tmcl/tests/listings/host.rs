//! A host, and a virtual module with a program on it.

use std::collections::VecDeque;
use std::time::Duration;

use tmcl_client::{Client, ProgramMode};
use tmcl_lang::Assembly;
use tmcl_link::{Link, LinkError};
use tmcl_tables::tmcm_1311::AxisParameter as Ap;
use virtual_bench::config::{SettingValue, parse_setting};
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId, TICK_NS};

use super::text::instructions;

const MODULE: ModuleId = ModuleId(0);
const MS: u64 = 1_000_000;

/// µsteps in a turn: 200 full steps of 256.
pub(crate) const TURN: f64 = 51_200.0;

/// Encoder counts in a turn of the default bench.
const COUNTS: f64 = 40_000.0;

/// How far a rotor without load may be from its field, in turns: a full step. Steps get lost four at a time (decisions 5.8).
const SLACK: f64 = 1.0 / 200.0;

/// The first port of a bench; waiting for an answer lets virtual time pass.
pub(crate) struct BenchLink {
    bench: Bench,
    arrived: VecDeque<u8>,
}

impl Link for BenchLink {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.arrived.extend(self.bench.exchange(MODULE, PortId::ALL[0], bytes));
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        if self.arrived.is_empty() {
            self.bench.advance_by(timeout.as_nanos() as u64);
            self.write(&[])?;
        }
        let length = buffer.len().min(self.arrived.len());
        for (slot, byte) in buffer.iter_mut().zip(self.arrived.drain(..length)) {
            *slot = byte;
        }
        Ok(length)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.arrived.clear();
        Ok(())
    }
}

/// A TMCM-1311 on the default bench, seen by its host and by somebody who stands beside it.
pub(crate) struct Host {
    client: Client<BenchLink>,
}

impl Host {
    /// A module with `program` in its memory, which is reset but does not run.
    #[track_caller]
    pub(crate) fn with_program(program: &Assembly) -> Self {
        let bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
        let mut client = Client::new(BenchLink { bench, arrived: VecDeque::new() });
        let program = instructions(program);
        client.download(&program, &mut |_| {}).expect("it is stored");
        client.verify(&program, &mut |_| {}).expect("it is what was sent");
        client.reset_program().expect("the module does it");
        Self { client }
    }

    /// A module that has just been told to run `program`.
    #[track_caller]
    pub(crate) fn running(program: &Assembly) -> Self {
        let mut host = Self::with_program(program);
        host.client.run(None).expect("it starts");
        host
    }

    /// Command 129 with an address.
    #[track_caller]
    pub(crate) fn call(&mut self, address: u32) {
        self.client.run(Some(address)).expect("it starts");
    }

    /// Whether the program runs, by command 135.
    #[track_caller]
    pub(crate) fn runs(&mut self) -> bool {
        self.client.program_status().expect("it answers").mode == ProgramMode::Running
    }

    /// GAP.
    #[track_caller]
    pub(crate) fn gap(&mut self, parameter: Ap) -> i32 {
        self.client.get_axis_parameter(parameter.number()).expect("it answers")
    }

    /// SAP.
    #[track_caller]
    pub(crate) fn sap(&mut self, parameter: Ap, value: i32) {
        self.client.set_axis_parameter(parameter.number(), value).expect("it is taken");
    }

    /// GGP of a user variable.
    #[track_caller]
    pub(crate) fn variable(&mut self, number: u8) -> i32 {
        self.client.get_global_parameter(2, number).expect("it answers")
    }

    /// GIO.
    #[track_caller]
    pub(crate) fn gio(&mut self, bank: u8, port: u8) -> i32 {
        self.client.get_input(bank, port).expect("it answers")
    }

    /// Changes something about the surroundings, by the name that a bench file's events call it.
    #[track_caller]
    pub(crate) fn set(&mut self, name: &str, value: u16) {
        let config = BenchConfig::default_for(ModuleKind::Tmcm1311);
        let settings = parse_setting(&config, name, SettingValue::Number(f64::from(value)));
        for (module, setting) in settings.expect("a setting of this bench") {
            self.bench_mut().apply(ModuleId(module), setting);
        }
    }

    /// What a trace's column of this name would say.
    #[track_caller]
    pub(crate) fn read(&mut self, name: &str) -> f64 {
        let bench = self.bench_mut();
        bench.read(bench.probe(name).expect("a quantity of this bench"))
    }

    /// Virtual time since power-on.
    pub(crate) fn now_ms(&mut self) -> f64 {
        self.bench_mut().time_ns() as f64 / MS as f64
    }

    /// Lets virtual time pass until so long after power-on.
    #[track_caller]
    pub(crate) fn run_to_ms(&mut self, time_ms: u64) {
        assert!(self.now_ms() <= time_ms as f64, "it is {} ms already", self.now_ms());
        self.bench_mut().advance_to(time_ms * MS);
    }

    /// Lets virtual time pass.
    pub(crate) fn run_ms(&mut self, duration_ms: u64) {
        self.bench_mut().advance_by(duration_ms * MS);
    }

    /// Runs until the module has reached `position`, and returns when that was, in ms.
    #[track_caller]
    pub(crate) fn arrive_at(&mut self, position: i32) -> f64 {
        self.run_until(&[
            ("target_position", position),
            ("actual_position", position),
            ("position_reached", 1),
        ])
    }

    /// Runs until all of these have these values, for a minute at most, and returns when that was, in ms.
    #[track_caller]
    pub(crate) fn run_until(&mut self, wanted: &[(&str, i32)]) -> f64 {
        let bench = self.bench_mut();
        let wanted: Vec<_> = wanted
            .iter()
            .map(|(name, value)| (bench.probe(name).expect("a quantity of this bench"), f64::from(*value)))
            .collect();
        let missing = |bench: &Bench| wanted.iter().any(|(probe, value)| bench.read(*probe) != *value);
        let end_ns = bench.time_ns() + 60_000 * MS;
        bench.advance_observed(end_ns, &mut |bench| missing(bench));
        assert!(!missing(bench), "not within a minute; actual_position is {}", self.gap(Ap::ActualPosition));
        self.now_ms()
    }

    /// Runs for `duration_ms`, and returns when `name` changed, in ms, and to what.
    pub(crate) fn changes(&mut self, name: &str, duration_ms: u64) -> Vec<(f64, f64)> {
        let bench = self.bench_mut();
        let probe = bench.probe(name).expect("a quantity of this bench");
        let mut changes = Vec::new();
        let mut last = bench.read(probe);
        let end_ns = bench.time_ns() + duration_ms * MS;
        bench.advance_observed(end_ns, &mut |bench| {
            let value = bench.read(probe);
            if value != last {
                changes.push((bench.time_ns() as f64 / MS as f64, value));
                last = value;
            }
            true
        });
        changes
    }

    /// How far the rotor really turned.
    pub(crate) fn turns(&mut self) -> f64 {
        self.bench_mut().physical(MODULE).rotor_turns
    }

    /// How fast the rotor really turns, in µsteps per second.
    pub(crate) fn rotor_pps(&mut self) -> f64 {
        self.bench_mut().physical(MODULE).velocity_rpm / 60.0 * TURN
    }

    /// The module reports, the encoder counts and the rotor has `position`, in µsteps.
    #[track_caller]
    pub(crate) fn assert_at(&mut self, position: f64, tolerance: f64) {
        let reported = f64::from(self.gap(Ap::ActualPosition));
        assert!((reported - position).abs() <= tolerance, "AP 1 says {reported}, not {position}");
        let turns = self.turns();
        assert!((turns - reported / TURN).abs() < SLACK, "{turns} turns, but AP 1 says {reported}");
        // Whole counts, of the control period before this one's end.
        let counted = f64::from(self.gap(Ap::EncoderCounter)) / COUNTS;
        let behind = (self.rotor_pps() / TURN * TICK_NS as f64 * 1e-9).abs() + 2.0 / COUNTS;
        assert!((turns - counted).abs() < behind, "{turns} turns, but the encoder says {counted}");
    }

    /// The module was told and reports a velocity in pps, and for `duration_ms` the rotor has it; in between it swings about
    /// its field.
    #[track_caller]
    pub(crate) fn assert_rotates(&mut self, velocity: i32, duration_ms: u64) {
        assert_eq!(self.gap(Ap::TargetVelocity), velocity);
        assert_eq!(self.gap(Ap::ActualVelocity), velocity);
        let begun = self.turns();
        self.run_ms(duration_ms);
        assert_eq!(self.gap(Ap::ActualVelocity), velocity);
        let turned = self.turns() - begun;
        let expected = f64::from(velocity) * duration_ms as f64 / 1000.0 / TURN;
        assert!((turned - expected).abs() < SLACK, "{turned} turns, not {expected}");
    }

    /// Nothing turns.
    #[track_caller]
    pub(crate) fn assert_stands(&mut self) {
        assert_eq!(self.gap(Ap::ActualVelocity), 0);
        let rotor = self.rotor_pps();
        assert!(rotor.abs() < 100.0, "the rotor turns at {rotor} pps");
    }

    /// The module took every instruction of the program.
    #[track_caller]
    pub(crate) fn assert_nothing_refused(&mut self) {
        let refused: Vec<_> = self.bench_mut().refused_instructions(MODULE).collect();
        assert_eq!(refused, []);
    }

    fn bench_mut(&mut self) -> &mut Bench {
        &mut self.client.link_mut().bench
    }
}
