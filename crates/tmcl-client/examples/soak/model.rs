//! What a host may believe of a module: the values that each thing can have, by what was confirmed and what was not.

use std::collections::{BTreeMap, BTreeSet};

use tmcl_tables::ModuleSpec;

/// A thing that is written, read and stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Slot {
    /// An axis parameter.
    Axis(u8),
    /// A user variable.
    Variable(u8),
}

/// What a value can be.
pub(crate) type Values = BTreeSet<i32>;

/// One module, as its host knows it.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    ram: BTreeMap<Slot, Values>,
    stored: BTreeMap<Slot, Values>,
    /// The program at the beginning of the memory: which number it puts into the variable, if that is certain.
    pub(crate) program: Option<i32>,
    /// Whether the module may be in download mode.
    pub(crate) downloading: bool,
}

/// Variables that are written and stored; the one behind them is the program's.
pub(crate) const VARIABLES: u8 = 6;

/// The variable that the program writes.
pub(crate) const RESULT: u8 = 6;

/// The axis parameters in play.
pub(crate) const PARAMETERS: [&str; 2] = ["max_velocity", "max_acceleration"];

/// The number of an axis parameter of this name.
pub(crate) fn number(spec: &ModuleSpec, id: &str) -> u8 {
    let found = spec.axis_parameters.iter().find(|parameter| parameter.id == id);
    found.expect("every stand-alone module has it").number
}

impl Model {
    /// A module as delivered.
    pub(crate) fn new(spec: &ModuleSpec) -> Self {
        let default = |slot| match slot {
            Slot::Axis(number) => spec.axis_parameter(number).map_or(0, |parameter| parameter.default as i32),
            Slot::Variable(_) => 0,
        };
        let axis = PARAMETERS.iter().map(|id| Slot::Axis(number(spec, id)));
        let slots = axis.chain((0..VARIABLES).map(Slot::Variable));
        let ram: BTreeMap<_, _> = slots.map(|slot| (slot, Values::from([default(slot)]))).collect();
        Self { stored: ram.clone(), ram, program: None, downloading: false }
    }

    /// Everything there is.
    pub(crate) fn slots(&self) -> Vec<Slot> {
        self.ram.keys().copied().collect()
    }

    /// What it can be.
    pub(crate) fn values(&self, slot: Slot) -> &Values {
        &self.ram[&slot]
    }

    /// What it can be in the EEPROM.
    pub(crate) fn stored_values(&self, slot: Slot) -> &Values {
        &self.stored[&slot]
    }

    /// It was written, or may have been.
    pub(crate) fn write(&mut self, slot: Slot, value: i32, confirmed: bool) {
        let values = self.ram.entry(slot).or_default();
        if confirmed {
            values.clear();
        }
        values.insert(value);
    }

    /// It was read.
    pub(crate) fn read(&mut self, slot: Slot, value: i32) -> Result<(), String> {
        let values = self.ram.entry(slot).or_default();
        if !values.contains(&value) {
            return Err(format!("{slot:?} reads {value}, and can be {values:?}"));
        }
        *values = Values::from([value]);
        Ok(())
    }

    /// It was stored, or may have been.
    pub(crate) fn store(&mut self, slot: Slot, confirmed: bool) {
        let now = self.ram[&slot].clone();
        let stored = self.stored.entry(slot).or_default();
        if confirmed {
            stored.clear();
        }
        stored.extend(now);
    }

    /// It was set back to what is stored, or may have been.
    pub(crate) fn restore(&mut self, slot: Slot, confirmed: bool) {
        let stored = self.stored[&slot].clone();
        let values = self.ram.entry(slot).or_default();
        if confirmed {
            values.clear();
        }
        values.extend(stored);
    }

    /// The module started afresh, or may have.
    pub(crate) fn restart(&mut self, certain: bool) {
        for slot in self.slots() {
            self.restore(slot, certain);
        }
        self.downloading &= !certain;
    }
}
