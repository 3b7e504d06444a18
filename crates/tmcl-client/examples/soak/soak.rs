//! The day on the bus.

use std::fmt::Write;
use std::time::Duration;

use tmcl_client::{Presence, ProgramMode};
use tmcl_link::{Direction, Link};
use tmcl_tables::{Command, ModuleSpec};
use tmcl_wire::Request;
use virtual_bench::{ModuleId, ModuleKind};

use crate::bus::SharedBench;
use crate::checksum;
use crate::host::{Host, TIMEOUT};
use crate::model::{Model, PARAMETERS, RESULT, Slot, VARIABLES, number};
use crate::random::Random;

/// Who is on the bus, at the addresses 1, 2 ….
const MODULES: [Member; 2] = [
    Member { kind: ModuleKind::Tmcm1311, values: (20_000, 80_000), turn: 51_200, window: 0 },
    Member { kind: ModuleKind::Tmcm1640, values: (1000, 3000), turn: 24, window: 10 },
];

/// A module on the bus.
#[derive(Clone, Copy)]
struct Member {
    kind: ModuleKind,
    /// What its velocity and its acceleration are set to: the least, and the most.
    values: (i32, i32),
    /// A turn of its shaft in steps of its position.
    turn: i32,
    /// How far off it may stand.
    window: u32,
}

/// The commands in which values of parameters and variables travel.
const AXIS_COMMANDS: [Command; 2] = [Command::SetAxisParameter, Command::GetAxisParameter];
const GLOBAL_COMMANDS: [Command; 2] = [Command::SetGlobalParameter, Command::GetGlobalParameter];

/// Nobody is here.
const EMPTY_ADDRESS: u8 = 77;

/// The bank of user variables.
const BANK: u8 = 2;

/// What the value of a software reset must be.
const RESET_MAGIC: i32 = 1234;

/// A bus, its modules, and what its host believes of them.
pub(crate) struct Soak {
    host: Host,
    random: Random,
    models: Vec<Model>,
    seed: u64,
    digest: u64,
    /// When the line changes next.
    weather_until: Duration,
}

impl Soak {
    /// Everything as delivered. The same seed is the same day.
    pub(crate) fn new(seed: u64) -> Self {
        let host = Host::new(SharedBench::with(&MODULES.map(|member| member.kind)), seed);
        let models = MODULES.iter().map(|member| Model::new(member.kind.spec())).collect();
        let (random, weather_until) = (Random(!seed), Duration::ZERO);
        Self { host, random, models, seed, digest: 0xCBF2_9CE4_8422_2325, weather_until }
    }

    /// Lives until this instant. Panics with what happened when something is wrong.
    pub(crate) fn run_until(&mut self, end: Duration) {
        while self.host.bench.now() < end {
            if let Err(error) = self.step() {
                let (seed, now) = (self.seed, self.host.bench.now());
                panic!("seed {seed}, after {now:?}: {error}");
            }
        }
    }

    /// Figures, for people.
    pub(crate) fn report(&mut self) -> String {
        let hours = self.host.bench.now().as_secs_f64() / 3600.0;
        let mut text =
            format!("{hours:.3} h of virtual time, seed {}, digest {:016x}\n", self.seed, self.digest);
        let _ = writeln!(text, "{}", self.host.counts);
        for (name, direction) in [("to the modules", Direction::Out), ("to the host", Direction::In)] {
            let counts = self.host.client.link_mut().counts(direction);
            let _ = writeln!(
                text,
                "{} bytes {name}: {} lost, {} doubled, {} spoiled, {} late",
                counts.bytes, counts.lost, counts.duplicated, counts.corrupted, counts.delayed
            );
        }
        text.push_str("no state lost, no reply out of step");
        text
    }

    /// One thing a host does, and a pause.
    fn step(&mut self) -> Result<(), String> {
        self.change_weather()?;
        let index = self.random.below(u32::try_from(self.models.len()).expect("a few")) as usize;
        self.host.turn_to(u8::try_from(index + 1).expect("a few"));
        if self.models[index].downloading {
            self.end_download(index)?;
        } else {
            self.act(index)?;
        }
        let pause = self.random.between(5, 100);
        self.wait(Duration::from_millis(u64::from(pause.unsigned_abs())))?;
        self.digest_state(index);
        Ok(())
    }

    fn act(&mut self, index: usize) -> Result<(), String> {
        match self.random.below(1000) {
            0..450 => self.read(index),
            450..700 => self.write(index),
            700..820 => self.store(index),
            820..920 => self.restore(index),
            920..950 => self.look_around(index),
            950..960 => self.download_and_run(index),
            960..963 => self.travel(index),
            963..967 => self.power_cycle(index),
            967..971 => self.reset(index),
            971..995 => self.take_stock(index),
            _ => {
                let pause = Duration::from_secs(u64::from(self.random.below(20)));
                self.wait(pause)
            }
        }
    }

    /// Good line, bad line, worse line.
    fn change_weather(&mut self) -> Result<(), String> {
        let now = self.host.bench.now();
        if now < self.weather_until {
            return Ok(());
        }
        self.weather_until = now + Duration::from_secs(u64::from(self.random.below(90)) + 10);
        let probability = [0.0, 0.0, 0.001, 0.01, 0.02][self.random.below(5) as usize];
        self.host.set_line(probability);
        // What is late still comes.
        if probability == 0.0 { self.wait(Duration::from_millis(300)) } else { Ok(()) }
    }

    fn spec(index: usize) -> &'static ModuleSpec {
        MODULES[index].kind.spec()
    }

    fn any_slot(&mut self, index: usize) -> Slot {
        let slots = self.models[index].slots();
        slots[self.random.below(u32::try_from(slots.len()).expect("a few")) as usize]
    }

    /// A value that no doubled byte makes another of which the checksum sees nothing.
    fn any_value(&mut self, index: usize, slot: Slot) -> i32 {
        loop {
            let (least, most) = MODULES[index].values;
            let value = match slot {
                Slot::Variable(_) => self.random.next() as i32,
                Slot::Axis(_) => self.random.between(least, most),
            };
            let address = u8::try_from(index + 1).expect("a few");
            let is_safe = match slot {
                Slot::Axis(number) => checksum::sees(AXIS_COMMANDS, address, number, 0, value),
                Slot::Variable(number) => checksum::sees(GLOBAL_COMMANDS, address, number, BANK, value),
            };
            if is_safe {
                return value;
            }
        }
    }

    fn read(&mut self, index: usize) -> Result<(), String> {
        let slot = self.any_slot(index);
        self.read_slot(index, slot)
    }

    fn read_slot(&mut self, index: usize, slot: Slot) -> Result<(), String> {
        let value = self.host.call(|client| match slot {
            Slot::Axis(number) => client.get_axis_parameter(number),
            Slot::Variable(number) => client.get_global_parameter(BANK, number),
        })?;
        value.map_or(Ok(()), |value| self.models[index].read(slot, value))
    }

    fn write(&mut self, index: usize) -> Result<(), String> {
        let slot = self.any_slot(index);
        let value = self.any_value(index, slot);
        let written = self.host.call(|client| match slot {
            Slot::Axis(number) => client.set_axis_parameter(number, value),
            Slot::Variable(number) => client.set_global_parameter(BANK, number, value),
        })?;
        self.models[index].write(slot, value, written.is_some());
        Ok(())
    }

    fn store(&mut self, index: usize) -> Result<(), String> {
        let slot = self.any_slot(index);
        let stored = self.host.call(|client| match slot {
            Slot::Axis(number) => client.store_axis_parameter(number),
            Slot::Variable(number) => client.store_global_parameter(BANK, number),
        })?;
        self.host.counts.stores += u64::from(stored.is_some());
        self.models[index].store(slot, stored.is_some());
        Ok(())
    }

    fn restore(&mut self, index: usize) -> Result<(), String> {
        let slot = self.any_slot(index);
        let restored = self.host.call(|client| match slot {
            Slot::Axis(number) => client.restore_axis_parameter(number),
            Slot::Variable(number) => client.restore_global_parameter(BANK, number),
        })?;
        self.models[index].restore(slot, restored.is_some());
        Ok(())
    }

    /// Who is on the bus?
    fn look_around(&mut self, index: usize) -> Result<(), String> {
        let nobody = self.host.call(|client| client.probe(EMPTY_ADDRESS, TIMEOUT))?;
        if matches!(nobody, Some(Presence::Module(_) | Presence::Silent(_))) {
            return Err(format!("somebody is at address {EMPTY_ADDRESS}: {nobody:?}"));
        }
        match self.host.call(tmcl_client::Client::firmware_version)? {
            Some(version) if version.module_spec() != Some(Self::spec(index)) => {
                Err(format!("module {index} says that it is {version}"))
            }
            _ => Ok(()),
        }
    }

    /// Everything is what it can be, in the module and, after a restart, out of its EEPROM.
    fn take_stock(&mut self, index: usize) -> Result<(), String> {
        for slot in self.models[index].slots() {
            self.read_slot(index, slot)?;
        }
        Ok(())
    }

    /// A program that puts a number into a variable.
    fn download_and_run(&mut self, index: usize) -> Result<(), String> {
        let result = self.any_value(index, Slot::Variable(RESULT));
        let program = [
            Request::new(Command::SetGlobalParameter, RESULT, BANK, result),
            Request::new(Command::Stop, 0, 0, 0),
        ];
        self.models[index].program = None;
        self.models[index].downloading = true;
        let started =
            self.host.call(|client| client.request(Request::new(Command::DownloadStart, 0, 0, 0)))?;
        for instruction in program.iter().filter(|_| started.is_some()) {
            if self.host.call(|client| client.request(*instruction))?.is_none() {
                return Ok(());
            }
        }
        self.end_download(index)?;
        if started.is_none() || self.models[index].downloading {
            return Ok(());
        }
        self.models[index].program = Some(result);
        self.host.counts.downloads += 1;
        self.run_program(index)
    }

    fn end_download(&mut self, index: usize) -> Result<(), String> {
        let end = Request::new(Command::DownloadEnd, 0, 0, 0);
        self.models[index].downloading = self.host.call(|client| client.request(end))?.is_none();
        Ok(())
    }

    fn run_program(&mut self, index: usize) -> Result<(), String> {
        let Some(result) = self.models[index].program else { return Ok(()) };
        if self.host.call(|client| client.run(Some(0)))?.is_none() {
            return Ok(());
        }
        self.wait(Duration::from_millis(20))?;
        let mode = self.host.call(tmcl_client::Client::program_status)?.map(|status| status.mode);
        let read = self.host.call(|client| client.get_global_parameter(BANK, RESULT))?;
        match (mode, read) {
            (Some(mode), _) if mode != ProgramMode::Stopped => Err(format!("the program is {mode}")),
            (_, Some(read)) if read != result => Err(format!("the program put {read} for {result}")),
            _ => Ok(()),
        }
    }

    /// To a place within a turn, and there; then the motor rests.
    fn travel(&mut self, index: usize) -> Result<(), String> {
        let spec = Self::spec(index);
        let turn = MODULES[index].turn;
        let target = loop {
            let target = self.random.between(-turn, turn);
            let address = u8::try_from(index + 1).expect("a few");
            if checksum::sees([Command::MoveToPosition], address, 0, 0, target) {
                break target;
            }
        };
        if self.host.call(|client| client.move_to(target))?.is_none() {
            return Ok(());
        }
        self.host.counts.moves += 1;
        for _ in 0..40 {
            self.wait(Duration::from_millis(250))?;
            let reached = number(spec, "position_reached");
            if self.host.call(|client| client.get_axis_parameter(reached))? == Some(1) {
                return self.arrived(index, target);
            }
        }
        Err(format!("module {index} did not reach {target} in ten seconds"))
    }

    /// Both position and target are what was asked for, and the motor is stopped.
    fn arrived(&mut self, index: usize, target: i32) -> Result<(), String> {
        let spec = Self::spec(index);
        for (id, window) in [("target_position", 0), ("actual_position", MODULES[index].window)] {
            let found = self.host.call(|client| client.get_axis_parameter(number(spec, id)))?;
            if found.is_some_and(|found| found.abs_diff(target) > window) {
                return Err(format!("module {index} was sent to {target}, and its {id} is {found:?}"));
            }
        }
        self.host.call(tmcl_client::Client::stop_motor).map(drop)
    }

    fn power_cycle(&mut self, index: usize) -> Result<(), String> {
        self.host.bench.lock().power_cycle(ModuleId(index));
        self.host.counts.power_cycles += 1;
        self.models[index].restart(true);
        self.after_restart(index)
    }

    fn reset(&mut self, index: usize) -> Result<(), String> {
        let reset = Request::new(Command::SoftwareReset, 0, 0, RESET_MAGIC);
        self.host.call(|client| client.send(reset))?;
        self.host.counts.resets += 1;
        self.models[index].restart(self.host.has_good_line());
        self.after_restart(index)
    }

    /// Time to start; then what was stored is there.
    fn after_restart(&mut self, index: usize) -> Result<(), String> {
        self.wait(Duration::from_millis(500))?;
        self.take_stock(index)?;
        self.run_program(index)
    }

    fn wait(&mut self, time: Duration) -> Result<(), String> {
        self.host.client.link_mut().wait(time).map_err(|error| error.to_string())
    }

    /// The digest follows time and beliefs, so that two runs that differ anywhere differ in it.
    fn digest_state(&mut self, index: usize) {
        let slot = Slot::Variable(self.random.below(u32::from(VARIABLES)) as u8);
        let axis = Slot::Axis(number(Self::spec(index), PARAMETERS[0]));
        let model = &self.models[index];
        let now = self.host.bench.now().as_nanos() as u64;
        let values = [model.values(slot), model.stored_values(slot), model.values(axis)];
        let beliefs = values.into_iter().flatten().map(|value| u64::from(value.cast_unsigned()));
        for word in std::iter::once(now).chain(beliefs) {
            self.digest = (self.digest ^ word).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }
}
