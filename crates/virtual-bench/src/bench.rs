//! The bench: modules that share a clock, the wires between them, and what happens to them when.

mod lines;

use module_firmware::tmcm_1076::Tmcm1076;
use module_firmware::tmcm_1311::Tmcm1311;
use module_firmware::tmcm_1640::Tmcm1640;
use module_firmware::{PORTS, PortId, Vm};
use tmcl_tables::ModuleSpec;

use crate::TICK_NS;
use crate::bus::Bus;
use crate::config::{BenchConfig, Event, ModuleConfig, Power, Setting, Wire, WireEnd};
use crate::eeprom::Eeprom;
use crate::kind::ModuleKind;
use crate::module::{Module, VirtualModule};
use crate::parts;
use crate::presets::presets;
use crate::probe::{self, Probe, ProbeError, Quantity};
use crate::refusals::RefusedInstruction;
use crate::step_bench::StepBench;
use bench_hardware::BldcBench;
use bench_hardware::Physical;
use bench_hardware::StepperBench;

/// The banks of ports that wires join.
const INPUTS: u8 = 0;
const OUTPUTS: u8 = 2;

/// A module's place on the bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ModuleId(pub usize);

/// The one list of modules by kind.
#[derive(Clone, Debug)]
enum AnyModule {
    Tmcm1311(Box<Module<Tmcm1311, StepperBench>>),
    Tmcm1640(Box<Module<Tmcm1640, BldcBench>>),
    Tmcm1076(Box<Module<Tmcm1076, StepBench>>),
}

impl AnyModule {
    fn get(&self) -> &dyn VirtualModule {
        match self {
            Self::Tmcm1311(module) => module.as_ref(),
            Self::Tmcm1640(module) => module.as_ref(),
            Self::Tmcm1076(module) => module.as_ref(),
        }
    }

    fn get_mut(&mut self) -> &mut dyn VirtualModule {
        match self {
            Self::Tmcm1311(module) => module.as_mut(),
            Self::Tmcm1640(module) => module.as_mut(),
            Self::Tmcm1076(module) => module.as_mut(),
        }
    }
}

/// A module and what it is called.
#[derive(Clone, Debug)]
struct Slot {
    name: String,
    kind: ModuleKind,
    module: AnyModule,
    /// Whether nothing about it but the time changed in its last control period, nor since.
    quiet: bool,
}

impl Slot {
    /// The module, to do something to it: the next control period is no longer like the last one.
    fn touch(&mut self) -> &mut dyn VirtualModule {
        self.quiet = false;
        self.module.get_mut()
    }

    /// One control period, which ends at `until_ns`. One in which nothing can change is gone through at little cost.
    fn tick(&mut self, until_ns: u64) -> Ticked {
        let module = self.module.get_mut();
        if self.quiet && until_ns < module.next_change_ns(until_ns.saturating_sub(TICK_NS)) {
            module.rest(1, until_ns);
            return Ticked::default();
        }
        let changed = module.tick(until_ns);
        self.quiet = !changed;
        Ticked { changed, executed: true }
    }
}

/// What came of a module's control period.
#[derive(Clone, Copy, Debug, Default)]
struct Ticked {
    /// Anything but the time changed.
    changed: bool,
    /// The firmware had its turn, and may have said something.
    executed: bool,
}

/// Modules and their common time.
#[derive(Clone, Debug, Default)]
pub struct Bench {
    time_ns: u64,
    slots: Vec<Slot>,
    wires: Vec<Wire>,
    /// In the order of their times.
    events: Vec<Event>,
    next_event: usize,
    /// What each line is.
    buses: [Bus; PORTS],
    modules_hear_replies: bool,
    /// Whether nothing but the time changed in the last control period.
    was_quiet: bool,
}

impl Bench {
    /// The bench that a file describes, switched on at time 0. The modules come from the factory.
    #[must_use]
    pub fn new(config: &BenchConfig) -> Self {
        Self::with_eeproms(config, |_| None)
    }

    /// The same, with modules whose EEPROM holds something; `None`, and one of another kind of module, stands for a new one.
    #[must_use]
    pub fn with_eeproms(
        config: &BenchConfig,
        mut eeprom: impl FnMut(&ModuleConfig) -> Option<Eeprom>,
    ) -> Self {
        Self {
            time_ns: 0,
            slots: config.modules.iter().map(|module| slot(module, config, eeprom(module))).collect(),
            wires: config.wires.clone(),
            events: config.events.clone(),
            next_event: 0,
            buses: Default::default(),
            modules_hear_replies: config.bus.modules_hear_replies,
            was_quiet: false,
        }
    }

    /// Virtual time since power-on.
    #[must_use]
    pub fn time_ns(&self) -> u64 {
        self.time_ns
    }

    /// Every module's place.
    pub fn modules(&self) -> impl Iterator<Item = ModuleId> + use<> {
        (0..self.slots.len()).map(ModuleId)
    }

    /// What a module is called.
    #[must_use]
    pub fn name(&self, module: ModuleId) -> Option<&str> {
        self.slots.get(module.0).map(|slot| slot.name.as_str())
    }

    /// The tables of a module.
    #[must_use]
    pub fn spec(&self, module: ModuleId) -> Option<&'static ModuleSpec> {
        self.slots.get(module.0).map(|slot| slot.kind.spec())
    }

    /// Runs the control periods that end at or before `time_ns`.
    ///
    /// A control period in which nothing changes is the same as the next one; so many of them as nothing can change in are
    /// gone through at once, with the same result bit for bit.
    pub fn advance_to(&mut self, time_ns: u64) {
        self.advance_observed(time_ns, &mut |_| true);
    }

    /// [`Bench::advance_to`] for those who look on: `observe` is called after every control period in which something may
    /// have changed, and after every rest, in which nothing did but the time. It returns whether to go on; where it does
    /// not, the bench stays at that instant.
    ///
    /// What shall be seen at an exact time needs a call up to that time, for a rest may lead across it.
    pub fn advance_observed(&mut self, time_ns: u64, observe: &mut dyn FnMut(&Self) -> bool) {
        while time_ns.saturating_sub(self.time_ns) >= TICK_NS {
            self.apply_due_events();
            let changed = self.tick();
            // A quiet period may still show what was set from outside just before it.
            if !observe(self) {
                return;
            }
            if !changed && self.rest_until(time_ns) && !observe(self) {
                return;
            }
        }
    }

    /// Runs on for `duration_ns`.
    pub fn advance_by(&mut self, duration_ns: u64) {
        self.advance_to(self.time_ns.saturating_add(duration_ns));
    }

    /// One control period of every module. Returns whether anything changed but the time.
    fn tick(&mut self) -> bool {
        self.time_ns += TICK_NS;
        let (mut changed, mut executed) = (false, false);
        for slot in &mut self.slots {
            let ticked = slot.tick(self.time_ns);
            changed |= ticked.changed;
            executed |= ticked.executed;
        }
        changed |= self.carry_signals();
        changed |= self.run_buses(executed);
        self.was_quiet = !changed;
        changed
    }

    /// Whether everything stands still: nothing but the time changed in the last control period, nothing is on its way along
    /// a bus, and no event of the bench file is still to come. Programs may be waiting.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.was_quiet && self.next_event >= self.events.len() && self.next_bus_change_ns() == u64::MAX
    }

    /// Goes through the control periods before `time_ns` in which nothing can change. Returns whether there were any.
    fn rest_until(&mut self, time_ns: u64) -> bool {
        let change_ns = self.slots.iter().map(|slot| slot.module.get().next_change_ns(self.time_ns)).min();
        let change_ns = change_ns.map(|change_ns| change_ns.min(self.next_bus_change_ns()));
        // The period in which something may change, and the one before which an event falls due, are not for resting.
        let before_change_ns = change_ns.map_or(u64::MAX, |change_ns| change_ns.saturating_sub(1));
        let event_ns = self.events.get(self.next_event).map_or(u64::MAX, |event| event.at_ns);
        let event_ns = event_ns.checked_next_multiple_of(TICK_NS).unwrap_or(u64::MAX);
        let until_ns = time_ns.min(before_change_ns).min(event_ns);
        let periods = until_ns.saturating_sub(self.time_ns) / TICK_NS;
        if periods > 0 {
            self.time_ns += periods * TICK_NS;
            for slot in &mut self.slots {
                slot.module.get_mut().rest(periods, self.time_ns);
            }
        }
        periods > 0
    }

    fn apply_due_events(&mut self) {
        while let Some(event) = self.events.get(self.next_event).filter(|event| event.at_ns <= self.time_ns) {
            let settings = event.settings.clone();
            self.next_event += 1;
            for (module, setting) in settings {
                self.apply(ModuleId(module), setting);
            }
        }
    }

    /// Carries outputs along the wires to inputs. Returns whether a level changed.
    fn carry_signals(&mut self) -> bool {
        let mut changed = false;
        for index in 0..self.wires.len() {
            let Some(&Wire { from_module, output, to_module, to }) = self.wires.get(index) else { break };
            let from = self.module(ModuleId(from_module));
            let high = from.is_some_and(|module| module.port(OUTPUTS, output) != 0);
            let Some(driven) = self.module(ModuleId(to_module)) else { continue };
            let (level, setting) = match to {
                WireEnd::Input(number) => (driven.port(INPUTS, number) != 0, Setting::Input { number, high }),
                WireEnd::Step => (driven.pulse_levels().step, Setting::StepLevel(high)),
                WireEnd::Dir => (driven.pulse_levels().dir, Setting::DirLevel(high)),
            };
            if high != level {
                self.apply(ModuleId(to_module), setting);
                changed = true;
            }
        }
        changed
    }

    /// Changes something about a module's surroundings, now.
    pub fn apply(&mut self, module: ModuleId, setting: Setting) {
        let Some(module) = self.module_mut(module) else { return };
        match setting {
            Setting::Power(Power::Off) => module.set_power(false),
            Setting::Power(Power::On) => module.set_power(true),
            Setting::Power(Power::Cycle) => {
                module.set_power(false);
                module.set_power(true);
            }
            other => module.apply(other),
        }
    }

    /// Bytes arrive at a module's port. Returns how many were taken; the rest may be offered again after
    /// [`Bench::transmit`].
    pub fn receive(&mut self, module: ModuleId, port: PortId, bytes: &[u8]) -> usize {
        self.module_mut(module).map_or(bytes.len(), |module| module.receive(port, bytes))
    }

    /// Appends what leaves a module's port to `out`.
    pub fn transmit(&mut self, module: ModuleId, port: PortId, out: &mut Vec<u8>) {
        if let Some(module) = self.module_mut(module) {
            module.transmit(port, out);
        }
    }

    /// Bytes arrive, and what leaves thereupon is the answer: a whole exchange in no virtual time.
    pub fn exchange(&mut self, module: ModuleId, port: PortId, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        let mut rest = bytes;
        loop {
            let taken = self.receive(module, port, rest);
            let before = out.len();
            self.transmit(module, port, &mut out);
            rest = rest.get(taken..).unwrap_or_default();
            if rest.is_empty() || (taken == 0 && out.len() == before) {
                return out;
            }
        }
    }

    /// Whether bytes wait to leave a module's port.
    #[must_use]
    pub fn has_output(&self, module: ModuleId, port: PortId) -> bool {
        self.module(module).is_some_and(|module| module.has_output(port))
    }

    /// The client at a port went away: what it left half-said or unread is forgotten.
    pub fn disconnect(&mut self, module: ModuleId, port: PortId) {
        if let Some(module) = self.module_mut(module) {
            module.disconnect(port);
        }
    }

    /// How long the lines of all modules may be silent within a datagram before what came of it is dropped: 100 ms of the
    /// clients' time, which is virtual time unless said otherwise.
    pub fn set_silence_ns(&mut self, silence_ns: u64) {
        for slot in &mut self.slots {
            slot.touch().set_silence(silence_ns / TICK_NS);
        }
    }

    /// Switches a module off and on again: the EEPROM keeps its records, the rotor its place.
    pub fn power_cycle(&mut self, module: ModuleId) {
        self.apply(module, Setting::Power(Power::Cycle));
    }

    /// What `name` means on this bench: a column of a trace, an expectation, something to watch.
    ///
    /// # Errors
    /// [`ProbeError`] when it means nothing.
    pub fn probe(&self, name: &str) -> Result<Probe, ProbeError> {
        let modules: Vec<_> = self.slots.iter().map(|slot| (slot.name.as_str(), slot.kind.spec())).collect();
        probe::parse(name, &modules)
    }

    /// The value of a quantity now.
    #[must_use]
    pub fn read(&self, probe: Probe) -> f64 {
        let Some(slot) = self.slots.get(probe.module.0) else { return 0.0 };
        let module = slot.module.get();
        match probe.quantity {
            Quantity::Parameter(number) => {
                let bits = module.parameter(number);
                let value = slot.kind.spec().axis_parameter(number).map_or(0, |spec| spec.from_wire(bits));
                value as f64
            }
            Quantity::Global(bank, number) => {
                let bits = module.global(bank, number);
                let spec = slot.kind.spec().global_parameter(bank, number);
                spec.map_or(0, |spec| spec.parameter.from_wire(bits)) as f64
            }
            Quantity::Coordinate(number) => f64::from(module.coordinate(number)),
            Quantity::Port(bank, number) => f64::from(module.port(bank, number)),
            Quantity::EncoderCounts => f64::from(module.encoder_counts()),
            Quantity::StepPulses => module.step_pulses() as f64,
            Quantity::EepromWrites => module.eeprom().writes() as f64,
            Quantity::Physical(index) => module.physical().values().get(index).copied().unwrap_or(0.0),
        }
    }

    /// The truth about a module's shaft.
    #[must_use]
    pub fn physical(&self, module: ModuleId) -> Physical {
        self.module(module).map_or_else(Physical::default, VirtualModule::physical)
    }

    /// A module's EEPROM.
    #[must_use]
    pub fn eeprom(&self, module: ModuleId) -> Option<&Eeprom> {
        self.module(module).map(VirtualModule::eeprom)
    }

    /// A module's EEPROM, to cut its power or to take its patches. A power cut takes effect at the module with its next byte
    /// write: it is off then, and says nothing more.
    pub fn eeprom_mut(&mut self, module: ModuleId) -> Option<&mut Eeprom> {
        self.module_mut(module).map(VirtualModule::eeprom_mut)
    }

    /// The instructions of a module's program that it refused since the bench was made, in the order of addresses.
    pub fn refused_instructions(&self, module: ModuleId) -> impl Iterator<Item = RefusedInstruction> + '_ {
        self.module(module).into_iter().flat_map(|module| module.refusals().iter())
    }

    /// The state of a module's program.
    #[must_use]
    pub fn program(&self, module: ModuleId) -> Option<&Vm> {
        self.module(module).map(VirtualModule::program)
    }

    fn module(&self, module: ModuleId) -> Option<&dyn VirtualModule> {
        self.slots.get(module.0).map(|slot| slot.module.get())
    }

    fn module_mut(&mut self, module: ModuleId) -> Option<&mut dyn VirtualModule> {
        self.slots.get_mut(module.0).map(Slot::touch)
    }
}

fn slot(config: &ModuleConfig, bench: &BenchConfig, eeprom: Option<Eeprom>) -> Slot {
    let eeprom = eeprom.filter(|eeprom| eeprom.kind() == config.kind);
    let eeprom = eeprom.unwrap_or_else(|| Eeprom::new(config.kind));
    let presets = presets(config, bench.bus.interface);
    let pace = config.instructions_per_tick;
    let module = match config.kind {
        ModuleKind::Tmcm1311 => AnyModule::Tmcm1311(Box::new(Module::new(
            StepperBench::new(&parts::stepper(config)),
            eeprom,
            &presets,
            pace,
        ))),
        ModuleKind::Tmcm1640 => AnyModule::Tmcm1640(Box::new(Module::new(
            BldcBench::new(&parts::brushless(config)),
            eeprom,
            &presets,
            pace,
        ))),
        ModuleKind::Tmcm1076 => {
            AnyModule::Tmcm1076(Box::new(Module::new(StepBench::new(config), eeprom, &presets, pace)))
        }
    };
    Slot { name: config.name.clone(), kind: config.kind, module, quiet: false }
}
