//! A whole module: identity and tables.

use crate::{Interrupt, MODULES, ModuleCommand, ParameterSpec, Status, ValueSet};

/// A global parameter, or a run of equal ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlobalSpec {
    /// The bank.
    pub bank: u8,
    /// The last number the entry stands for; the first is `parameter.number`.
    pub last: u8,
    /// Everything else.
    pub parameter: ParameterSpec,
}

/// Which way a port points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Read with GIO.
    Input,
    /// Written with SIO, read back with GIO.
    Output,
}

/// An input or output that GIO and SIO reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortSpec {
    /// The bank: 0 digital inputs, 1 analogue inputs, 2 outputs.
    pub bank: u8,
    /// The port number.
    pub number: u8,
    /// OpenTMCL's identifier.
    pub id: &'static str,
    /// The name, for people.
    pub name: &'static str,
    /// Which way it points.
    pub direction: Direction,
    /// What it can read.
    pub range: ValueSet,
    /// The unit; empty for logic levels and raw readings.
    pub unit: &'static str,
    /// The section of the manual.
    pub section: &'static str,
}

/// An interrupt of stand-alone programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterruptSpec {
    /// Which.
    pub interrupt: Interrupt,
    /// The number that VECT, EI and DI take; lower numbers go first.
    pub number: u8,
    /// OpenTMCL's identifier.
    pub id: &'static str,
    /// The name, for people.
    pub name: &'static str,
    /// The constant in `Interrupts.inc`.
    pub symbol: &'static str,
    /// The bank-3 parameter that configures it.
    pub parameter: Option<u8>,
    /// The section of the manual.
    pub section: &'static str,
}

/// A status code of a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusSpec {
    /// Which.
    pub status: Status,
    /// OpenTMCL's identifier.
    pub id: &'static str,
    /// The manual's name.
    pub name: &'static str,
    /// What it tells a host.
    pub summary: &'static str,
}

/// Everything the tables say about one module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModuleSpec {
    /// The maker's name for it, `TMCM-1311`.
    pub name: &'static str,
    /// What the command line calls it, `tmcm-1311`.
    pub id: &'static str,
    /// Its number, 1311.
    pub number: u16,
    /// The eight characters that answer command 136, type 0.
    pub version_string: &'static str,
    /// Major and minor firmware version.
    pub firmware: (u8, u8),
    /// What it is, in a line.
    pub summary: &'static str,
    /// The interfaces it has.
    pub interfaces: &'static [&'static str],
    /// Instructions that fit its program memory; 0 for a module without stand-alone programs.
    pub program_memory: u16,
    /// Coordinates it keeps; 0 for a module without coordinates.
    pub coordinates: u8,
    /// Its commands, by number.
    pub commands: &'static [ModuleCommand],
    /// Its axis parameters, by number.
    pub axis_parameters: &'static [ParameterSpec],
    /// Its global parameters, by bank and number.
    pub global_parameters: &'static [GlobalSpec],
    /// Its ports, by bank and number.
    pub ports: &'static [PortSpec],
    /// Its interrupts, by number.
    pub interrupts: &'static [InterruptSpec],
}

impl ModuleSpec {
    /// The command with this number, if the module has it.
    #[must_use]
    pub fn command(&self, number: u8) -> Option<&'static ModuleCommand> {
        find(self.commands, |entry| entry.spec.number.cmp(&number))
    }

    /// The axis parameter with this number, if the module has it.
    #[must_use]
    pub fn axis_parameter(&self, number: u8) -> Option<&'static ParameterSpec> {
        find(self.axis_parameters, |entry| entry.number.cmp(&number))
    }

    /// The global parameter with this bank and number, if the module has it.
    #[must_use]
    pub fn global_parameter(&self, bank: u8, number: u8) -> Option<&'static GlobalSpec> {
        find(self.global_parameters, |entry| {
            entry.bank.cmp(&bank).then(if entry.last < number {
                core::cmp::Ordering::Less
            } else {
                entry.parameter.number.cmp(&number).max(core::cmp::Ordering::Equal)
            })
        })
    }

    /// The port with this bank and number, if the module has it.
    #[must_use]
    pub fn port(&self, bank: u8, number: u8) -> Option<&'static PortSpec> {
        find(self.ports, |entry| (entry.bank, entry.number).cmp(&(bank, number)))
    }

    /// The interrupt with this number, if the module has it.
    #[must_use]
    pub fn interrupt(&self, number: u8) -> Option<&'static InterruptSpec> {
        find(self.interrupts, |entry| entry.number.cmp(&number))
    }

    /// The binary answer to command 136, type 1: module number, major and minor version.
    #[must_use]
    pub fn version_number(&self) -> i32 {
        let (major, minor) = self.firmware;
        let [high, low] = self.number.to_be_bytes();
        i32::from_be_bytes([high, low, major, minor])
    }
}

/// Binary search in a table sorted by what `compare` looks at.
fn find<T>(table: &'static [T], compare: impl FnMut(&T) -> core::cmp::Ordering) -> Option<&'static T> {
    table.binary_search_by(compare).ok().and_then(|index| table.get(index))
}

/// No module of that name; the known ones are in [`MODULES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownModule;

/// The module that people call `name`: `tmcm-1311`, `TMCM-1311`, `1311`.
///
/// # Errors
/// [`UnknownModule`] when no module answers to that name.
pub fn module_by_id(name: &str) -> Result<&'static ModuleSpec, UnknownModule> {
    MODULES
        .iter()
        .copied()
        .find(|spec| {
            let digits = spec.id.trim_start_matches("tmcm-");
            [spec.id, digits].iter().any(|candidate| name.eq_ignore_ascii_case(candidate))
        })
        .ok_or(UnknownModule)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_found_by_its_number() {
        for spec in MODULES {
            for entry in spec.commands {
                assert_eq!(spec.command(entry.spec.number), Some(entry));
            }
            for entry in spec.axis_parameters {
                assert_eq!(spec.axis_parameter(entry.number), Some(entry));
            }
            for entry in spec.global_parameters {
                for number in entry.parameter.number..=entry.last {
                    assert_eq!(spec.global_parameter(entry.bank, number), Some(entry));
                }
            }
            for entry in spec.ports {
                assert_eq!(spec.port(entry.bank, entry.number), Some(entry));
            }
            for entry in spec.interrupts {
                assert_eq!(spec.interrupt(entry.number), Some(entry));
            }
        }
    }

    #[test]
    fn what_is_not_there_is_not_found() {
        let spec = &crate::tmcm_1311::SPEC;
        assert_eq!(spec.axis_parameter(21), None);
        assert_eq!(spec.axis_parameter(255), None);
        assert_eq!(spec.global_parameter(0, 63), None);
        assert_eq!(spec.global_parameter(1, 0), None);
        assert_eq!(spec.global_parameter(3, 3), None);
        assert_eq!(spec.command(0), None);
        assert_eq!(spec.port(1, 1), None);
    }

    #[test]
    fn modules_are_found_by_the_names_people_use() {
        assert_eq!(module_by_id("tmcm-1311").map(|spec| spec.number), Ok(1311));
        assert_eq!(module_by_id("TMCM-1640").map(|spec| spec.number), Ok(1640));
        assert_eq!(module_by_id("1076").map(|spec| spec.number), Ok(1076));
        assert_eq!(module_by_id("tmcm-1312"), Err(UnknownModule));
    }

    /// TMCM-1311 §5.7.39 and TMCM-1640 §4.6.25, read as decisions §1.5 has it.
    #[test]
    fn version_numbers() {
        let versions = MODULES.map(ModuleSpec::version_number);
        assert_eq!(versions, [0x0434_0102, 0x051F_010B, 0x0668_0200]);
    }
}
