//! What has a value on a module.

use tmcl_tables::{
    Access, BitField, Direction, GlobalSpec, ModuleSpec, NamedValue, ParameterSpec, PortSpec, Role, ValueSet,
};

/// The bank of the user variables (TMCM-1311 §10.3).
const VARIABLES: u8 = 2;

/// What a coordinate may hold (TMCM-1311 §5.7.24).
const POSITIONS: ValueSet = ValueSet { intervals: &[(i32::MIN as i64, i32::MAX as i64)], step: 1 };

/// The names of ports but for their number, and their banks.
const PORTS: [(&str, u8); 3] = [("input", 0), ("ain", 1), ("output", 2)];

/// Something that has a value on a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// An axis parameter.
    Axis(&'static ParameterSpec),
    /// A global parameter, and its number where the table's entry stands for several.
    Global(&'static GlobalSpec, u8),
    /// A coordinate.
    Coordinate(u8),
    /// A port.
    Port(&'static PortSpec),
}

/// All that a module has: axis parameters, global parameters by bank, coordinates, ports.
pub fn items(module: &'static ModuleSpec) -> impl Iterator<Item = Item> {
    let globals = module.global_parameters.iter().flat_map(|entry| {
        (entry.parameter.number..=entry.last).map(move |number| Item::Global(entry, number))
    });
    module
        .axis_parameters
        .iter()
        .map(Item::Axis)
        .chain(globals)
        .chain((0..module.coordinates).map(Item::Coordinate))
        .chain(module.ports.iter().map(Item::Port))
}

impl Item {
    /// The axis parameter with this number.
    #[must_use]
    pub fn axis(module: &ModuleSpec, number: u8) -> Option<Self> {
        module.axis_parameter(number).map(Self::Axis)
    }

    /// The global parameter with this bank and number.
    #[must_use]
    pub fn global(module: &ModuleSpec, bank: u8, number: u8) -> Option<Self> {
        module.global_parameter(bank, number).map(|entry| Self::Global(entry, number))
    }

    /// The user variable with this number.
    #[must_use]
    pub fn variable(module: &ModuleSpec, number: u8) -> Option<Self> {
        Self::global(module, VARIABLES, number)
    }

    /// The coordinate with this number.
    #[must_use]
    pub fn coordinate(module: &ModuleSpec, number: u8) -> Option<Self> {
        (number < module.coordinates).then_some(Self::Coordinate(number))
    }

    /// The port that a prefix and a number name: `input`, `ain`, `output`.
    #[must_use]
    pub fn port(module: &ModuleSpec, prefix: &str, number: u8) -> Option<Self> {
        let (_, bank) = PORTS.into_iter().find(|(name, _)| *name == prefix)?;
        module.port(bank, number).map(Self::Port)
    }

    /// The axis or global parameter with this identifier, other than a user variable.
    #[must_use]
    pub fn by_id(module: &ModuleSpec, id: &str) -> Option<Self> {
        let axis = module.axis_parameters.iter().find(|entry| entry.id == id).map(Self::Axis);
        axis.or_else(|| {
            let mut globals = module.global_parameters.iter().filter(|entry| entry.bank != VARIABLES);
            globals
                .find(|entry| entry.parameter.id == id)
                .map(|entry| Self::Global(entry, entry.parameter.number))
        })
    }

    /// What it is called: `max_velocity`, `variable.3`, `coordinate.2`, `input.0`.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Axis(spec) => spec.id.to_owned(),
            Self::Global(entry, number) if entry.bank == VARIABLES => format!("variable.{number}"),
            Self::Global(entry, _) => entry.parameter.id.to_owned(),
            Self::Coordinate(number) => format!("coordinate.{number}"),
            Self::Port(port) => {
                let prefix =
                    PORTS.iter().find(|(_, bank)| *bank == port.bank).map_or("port", |(name, _)| name);
                format!("{prefix}.{}", port.number)
            }
        }
    }

    /// Its number: `axis.4`, `0/66`; coordinates and ports have it in their name.
    #[must_use]
    pub fn number(self) -> String {
        match self {
            Self::Axis(spec) => format!("axis.{}", spec.number),
            Self::Global(entry, number) => format!("{}/{number}", entry.bank),
            Self::Coordinate(_) | Self::Port(_) => self.name(),
        }
    }

    /// What people call it.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Axis(spec) => spec.name,
            Self::Global(entry, _) => entry.parameter.name,
            Self::Coordinate(_) => "Coordinate",
            Self::Port(port) => port.name,
        }
    }

    /// What the tables say about it, if it is a parameter.
    #[must_use]
    pub fn spec(self) -> Option<&'static ParameterSpec> {
        match self {
            Self::Axis(spec) => Some(spec),
            Self::Global(entry, _) => Some(&entry.parameter),
            Self::Coordinate(_) | Self::Port(_) => None,
        }
    }

    /// Whether it is a user variable.
    #[must_use]
    pub fn is_variable(self) -> bool {
        matches!(self, Self::Global(entry, _) if entry.bank == VARIABLES)
    }

    /// The unit, in closed loop or not; empty for plain numbers.
    #[must_use]
    pub fn unit(self, closed_loop: bool) -> &'static str {
        match self {
            Self::Port(port) => port.unit,
            _ => self.spec().map_or("", |spec| if closed_loop { spec.closed_loop_unit } else { spec.unit }),
        }
    }

    /// Whether the unit is another one in closed loop.
    #[must_use]
    pub fn has_two_units(self) -> bool {
        self.unit(false) != self.unit(true)
    }

    /// What may be done with it.
    #[must_use]
    pub fn access(self) -> Access {
        match self {
            Self::Port(port) => {
                Access { read: true, write: port.direction == Direction::Output, store: false }
            }
            // Coordinate 0 stays in RAM (TMCM-1311 §5.7.24, decision).
            Self::Coordinate(number) => Access { read: true, write: true, store: number > 0 },
            Self::Axis(spec) => spec.access,
            Self::Global(entry, _) => entry.parameter.access,
        }
    }

    /// What it may hold.
    #[must_use]
    pub fn range(self) -> ValueSet {
        match self {
            Self::Port(port) => port.range,
            _ => self.spec().map_or(POSITIONS, |spec| spec.range),
        }
    }

    /// Its values that have names.
    #[must_use]
    pub fn values(self) -> &'static [NamedValue] {
        self.spec().map_or(&[], |spec| spec.values)
    }

    /// Its bit fields.
    #[must_use]
    pub fn fields(self) -> &'static [BitField] {
        self.spec().map_or(&[], |spec| spec.fields)
    }

    /// What it is in a configuration.
    #[must_use]
    pub fn role(self) -> Role {
        match self {
            Self::Port(_) => Role::State,
            Self::Coordinate(_) => Role::Setting,
            _ => self.spec().map_or(Role::State, |spec| spec.role),
        }
    }

    /// Whether writing it can set the motor moving.
    #[must_use]
    pub fn starts_motion(self) -> bool {
        self.spec().is_some_and(|spec| spec.starts_motion)
    }

    /// Whether a configuration file holds it: it is no state, and writing it moves nothing.
    #[must_use]
    pub fn is_configuration(self) -> bool {
        self.role() != Role::State && !self.starts_motion()
    }

    /// The value that 32 bits on the wire stand for.
    #[must_use]
    pub fn from_wire(self, bits: i32) -> i64 {
        self.spec().map_or(i64::from(bits), |spec| spec.from_wire(bits))
    }

    /// The 32 bits to write so that `value` is read afterwards; higher bits are dropped.
    #[must_use]
    pub fn to_wire(self, value: i64) -> i32 {
        self.spec().map_or(value as i32, |spec| spec.to_wire(spec.written_for(value)))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use tmcl_tables::MODULES;

    use super::*;

    #[test]
    fn no_two_items_of_a_module_share_a_name_or_a_number() {
        for module in MODULES {
            let (mut names, mut numbers) = (BTreeSet::new(), BTreeSet::new());
            for item in items(module) {
                assert!(names.insert(item.name()), "{}", item.name());
                assert!(numbers.insert(item.number()), "{}", item.number());
            }
        }
    }

    #[test]
    fn what_a_configuration_holds_can_be_read_and_written() {
        for item in MODULES.into_iter().flat_map(items).filter(|item| item.is_configuration()) {
            let access = item.access();
            assert!(access.read && access.write && !item.starts_motion(), "{}", item.name());
        }
    }

    #[test]
    fn motion_and_measurements_are_no_configuration() {
        let module = &tmcl_tables::tmcm_1311::SPEC;
        let is = |name| Item::by_id(module, name).map(Item::is_configuration);
        for name in
            ["target_position", "actual_position", "supply_voltage", "closed_loop_mode", "eeprom_magic"]
        {
            assert_eq!(is(name), Some(false), "{name}");
        }
        for name in ["max_velocity", "chopper_off_time", "serial_address", "eeprom_lock", "timer_0_period"] {
            assert_eq!(is(name), Some(true), "{name}");
        }
        assert_eq!(Item::variable(module, 55).map(Item::is_configuration), Some(true));
        assert_eq!(Item::variable(module, 56).map(Item::is_configuration), Some(false));
    }
}
