//! Names for everything one can look at on a bench: `actual_position`, `output.3`, `sensed.encoder_counts`,
//! `physical.rotor_turns`; with several modules prefixed by the module's name, `m1.actual_position`.

use tmcl_tables::ModuleSpec;

use crate::bench::ModuleId;
use crate::hardware::Physical;

/// Something to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Probe {
    /// Whose.
    pub module: ModuleId,
    /// What.
    pub quantity: Quantity,
}

/// What there is to look at on a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// An axis parameter, as GAP reads it.
    Parameter(u8),
    /// A port, as GIO reads it: bank and number.
    Port(u8, u8),
    /// The raw count of the encoder.
    EncoderCounts,
    /// An entry of [`Physical`].
    Physical(usize),
}

/// Why a name names nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProbeError {
    /// No module of that name.
    #[error("`{0}` names no module; put one of {1} and a dot before it")]
    Module(String, String),
    /// Nothing of that name on the module.
    #[error(
        "nothing called `{0}`; there are axis parameters such as `actual_position`, `input.N`, `output.N`, `ain.N`, `sensed.encoder_counts`, and physical.{{{1}}}"
    )]
    Quantity(String, String),
}

/// What `name` means on a bench with these modules.
///
/// # Errors
/// [`ProbeError`] when it means nothing.
pub(crate) fn parse(name: &str, modules: &[(&str, &'static ModuleSpec)]) -> Result<Probe, ProbeError> {
    let first = modules.first().filter(|_| modules.len() == 1);
    let direct = first.and_then(|(_, spec)| quantity(name, spec));
    if let Some(quantity) = direct {
        return Ok(Probe { module: ModuleId(0), quantity });
    }
    let (prefix, rest) = name.split_once('.').unwrap_or(("", name));
    let found = modules.iter().position(|(module, _)| *module == prefix);
    match found.zip(found.and_then(|index| modules.get(index))) {
        Some((index, (_, spec))) => {
            let quantity = quantity(rest, spec).ok_or_else(|| no_quantity(rest))?;
            Ok(Probe { module: ModuleId(index), quantity })
        }
        None if modules.len() == 1 => Err(no_quantity(name)),
        None => {
            let names: Vec<_> = modules.iter().map(|(name, _)| *name).collect();
            Err(ProbeError::Module(name.to_owned(), names.join(", ")))
        }
    }
}

fn no_quantity(name: &str) -> ProbeError {
    let names: Vec<_> = Physical::NAMES.iter().map(|(name, _)| *name).collect();
    ProbeError::Quantity(name.to_owned(), names.join(", "))
}

fn quantity(name: &str, spec: &'static ModuleSpec) -> Option<Quantity> {
    if let Some(physical) = name.strip_prefix("physical.") {
        return Physical::NAMES.iter().position(|(known, _)| *known == physical).map(Quantity::Physical);
    }
    if name == "sensed.encoder_counts" {
        return Some(Quantity::EncoderCounts);
    }
    for (prefix, bank) in [("input.", 0), ("ain.", 1), ("output.", 2)] {
        if let Some(number) = name.strip_prefix(prefix) {
            let number = number.parse().ok()?;
            return spec.port(bank, number).map(|port| Quantity::Port(port.bank, port.number));
        }
    }
    let parameter = spec.axis_parameters.iter().find(|parameter| parameter.id == name)?;
    parameter.access.read.then_some(Quantity::Parameter(parameter.number))
}

/// The unit of a quantity on a module; empty for plain numbers.
pub(crate) fn unit(quantity: Quantity, spec: &ModuleSpec) -> &'static str {
    match quantity {
        Quantity::Parameter(number) => spec.axis_parameter(number).map_or("", |parameter| parameter.unit),
        Quantity::Port(bank, number) => spec.port(bank, number).map_or("", |port| port.unit),
        Quantity::EncoderCounts => "count",
        Quantity::Physical(index) => Physical::NAMES.get(index).map_or("", |(_, unit)| unit),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEC: &ModuleSpec = &tmcl_tables::tmcm_1311::SPEC;

    #[test]
    fn names_with_and_without_a_prefix() {
        let one = [("m1", SPEC)];
        let actual_position = Probe { module: ModuleId(0), quantity: Quantity::Parameter(1) };
        assert_eq!(parse("actual_position", &one), Ok(actual_position));
        assert_eq!(parse("m1.actual_position", &one), Ok(actual_position));
        let two = [("m1", SPEC), ("lift", SPEC)];
        let turns = Probe { module: ModuleId(1), quantity: Quantity::Physical(0) };
        assert_eq!(parse("lift.physical.rotor_turns", &two), Ok(turns));
        let output = Probe { module: ModuleId(0), quantity: Quantity::Port(2, 3) };
        assert_eq!(parse("m1.output.3", &two), Ok(output));
    }

    #[test]
    fn what_names_nothing_is_refused_with_what_there_is() {
        let one = [("m1", SPEC)];
        for name in ["actual_positio", "output.8", "physical.turns", "clear_i2t_flag"] {
            assert!(matches!(parse(name, &one), Err(ProbeError::Quantity(..))), "{name}");
        }
        let two = [("m1", SPEC), ("m2", SPEC)];
        assert!(matches!(parse("m3.output.0", &two), Err(ProbeError::Module(..))));
        assert!(matches!(parse("output.0", &two), Err(ProbeError::Module(..))));
    }
}
