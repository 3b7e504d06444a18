//! The bench: modules that share a clock.

use module_firmware::tmcm_1311::Tmcm1311;
use module_firmware::{PortId, RecordKey, Storage};
use tmcl_tables::{GlobalParameter, ModuleSpec};

use crate::TICK_NS;
use crate::eeprom::Eeprom;
use crate::field_follower::FieldFollower;
use crate::hardware::Physical;
use crate::module::{Module, VirtualModule};

/// A kind of module that the bench can build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModuleKind {
    /// The TMCM-1311, in open loop.
    Tmcm1311,
}

/// The tables know this module, but there is no virtual one yet; the kinds there are stand in [`ModuleKind::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no virtual {0} yet")]
pub struct UnknownModuleKind(pub &'static str);

impl ModuleKind {
    /// Every kind.
    pub const ALL: [Self; 1] = [Self::Tmcm1311];

    /// The module's tables.
    #[must_use]
    pub fn spec(self) -> &'static ModuleSpec {
        match self {
            Self::Tmcm1311 => &tmcl_tables::tmcm_1311::SPEC,
        }
    }
}

impl TryFrom<&'static ModuleSpec> for ModuleKind {
    type Error = UnknownModuleKind;

    fn try_from(spec: &'static ModuleSpec) -> Result<Self, UnknownModuleKind> {
        let kind = Self::ALL.into_iter().find(|kind| kind.spec().number == spec.number);
        kind.ok_or(UnknownModuleKind(spec.id))
    }
}

/// A module to be put on the bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModuleSetup {
    /// What it is.
    pub kind: ModuleKind,
    /// Its serial address; beats what the EEPROM says. `None` leaves the factory's 1.
    pub address: Option<u8>,
}

/// A module's place on the bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ModuleId(pub usize);

/// The one list of modules by kind.
#[derive(Clone, Debug)]
enum AnyModule {
    Tmcm1311(Box<Module<Tmcm1311, FieldFollower>>),
}

impl AnyModule {
    fn get(&self) -> &dyn VirtualModule {
        match self {
            Self::Tmcm1311(module) => module.as_ref(),
        }
    }

    fn get_mut(&mut self) -> &mut dyn VirtualModule {
        match self {
            Self::Tmcm1311(module) => module.as_mut(),
        }
    }
}

/// Modules and their common time.
#[derive(Clone, Debug, Default)]
pub struct Bench {
    time_ns: u64,
    modules: Vec<AnyModule>,
}

impl Bench {
    /// A bench with these modules, switched on at time 0.
    #[must_use]
    pub fn new(setups: &[ModuleSetup]) -> Self {
        Self { time_ns: 0, modules: setups.iter().map(build).collect() }
    }

    /// Virtual time since power-on.
    #[must_use]
    pub fn time_ns(&self) -> u64 {
        self.time_ns
    }

    /// Every module's place.
    pub fn modules(&self) -> impl Iterator<Item = ModuleId> {
        (0..self.modules.len()).map(ModuleId)
    }

    /// Runs the control periods that end at or before `time_ns`.
    pub fn advance_to(&mut self, time_ns: u64) {
        while time_ns.saturating_sub(self.time_ns) >= TICK_NS {
            self.time_ns += TICK_NS;
            for module in &mut self.modules {
                module.get_mut().tick(self.time_ns);
            }
        }
    }

    /// Runs on for `duration_ns`.
    pub fn advance_by(&mut self, duration_ns: u64) {
        self.advance_to(self.time_ns.saturating_add(duration_ns));
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
        for module in &mut self.modules {
            module.get_mut().set_silence(silence_ns / TICK_NS);
        }
    }

    /// Switches a module off and on again.
    pub fn power_cycle(&mut self, module: ModuleId) {
        if let Some(module) = self.module_mut(module) {
            module.power_cycle();
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

    fn module(&self, module: ModuleId) -> Option<&dyn VirtualModule> {
        self.modules.get(module.0).map(AnyModule::get)
    }

    fn module_mut(&mut self, module: ModuleId) -> Option<&mut dyn VirtualModule> {
        self.modules.get_mut(module.0).map(AnyModule::get_mut)
    }
}

fn build(setup: &ModuleSetup) -> AnyModule {
    let mut eeprom = Eeprom::default();
    if let Some(address) = setup.address {
        let (bank, number) = GlobalParameter::SerialAddress.address();
        // An EEPROM in memory takes every record.
        let _ = eeprom.write(RecordKey::Global(bank, number), &i32::from(address).to_le_bytes());
    }
    match setup.kind {
        ModuleKind::Tmcm1311 => AnyModule::Tmcm1311(Box::new(Module::new(FieldFollower::default(), eeprom))),
    }
}
