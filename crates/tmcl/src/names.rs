//! Parameters by their names, for people who type.

use std::fmt;

use tmcl_tables::{CommandSpec, ModuleSpec, MotorField, Operand, ParameterSpec, TypeField, ValueField};

/// Which parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// An axis parameter.
    Axis(u8),
    /// A global parameter: its bank and number.
    Global(u8, u8),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Axis(number) => write!(f, "axis parameter {number}"),
            Self::Global(bank, number) => write!(f, "global parameter {number} of bank {bank}"),
        }
    }
}

/// Every name, axis parameters first. Of a run of equal ones only the first has it.
pub(crate) fn all(module: &'static ModuleSpec) -> impl Iterator<Item = (Place, &'static ParameterSpec)> {
    let axis = module.axis_parameters.iter().map(|parameter| (Place::Axis(parameter.number), parameter));
    let global = module
        .global_parameters
        .iter()
        .map(|entry| (Place::Global(entry.bank, entry.parameter.number), &entry.parameter));
    axis.chain(global)
}

/// The parameter of that name: `max_velocity`; `4` for axis parameter 4, `2/17` for a global parameter of bank 2.
pub(crate) fn find(
    module: &'static ModuleSpec,
    name: &str,
) -> Result<(Place, &'static ParameterSpec), String> {
    let by_number = match name.split_once('/') {
        Some((bank, number)) => bank.parse().ok().zip(number.parse().ok()).and_then(|(bank, number)| {
            let entry = module.global_parameter(bank, number)?;
            Some((Place::Global(bank, number), &entry.parameter))
        }),
        None => {
            name.parse().ok().and_then(|number| Some((Place::Axis(number), module.axis_parameter(number)?)))
        }
    };
    let by_name = || all(module).find(|(_, parameter)| parameter.id.eq_ignore_ascii_case(name));
    by_number.or_else(by_name).ok_or_else(|| {
        let near = strsim_nearest(name, all(module).map(|(_, parameter)| parameter.id));
        let near = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
        format!("the {} has no parameter `{name}`{near}", module.name)
    })
}

/// A number, or the name of a value.
pub(crate) fn value(parameter: &ParameterSpec, text: &str) -> Result<i64, String> {
    let named = parameter.values.iter().find(|named| named.id.eq_ignore_ascii_case(text));
    let hexadecimal = text.strip_prefix("0x").and_then(|digits| i64::from_str_radix(digits, 16).ok());
    let value = named.map(|named| named.value).or(hexadecimal).or_else(|| text.parse().ok());
    let fits = |value: &i64| (i64::from(i32::MIN)..=i64::from(u32::MAX)).contains(value);
    value.filter(fits).ok_or_else(|| {
        let names: Vec<&str> = parameter.values.iter().map(|named| named.id).collect();
        let names = if names.is_empty() { String::new() } else { format!(" or {}", names.join(", ")) };
        format!("`{text}` is no value of {}: it takes {}{names}", parameter.id, parameter.write_range)
    })
}

/// What an operand is, in a word.
pub(crate) fn operand(spec: &CommandSpec, operand: Operand) -> &'static str {
    match operand {
        Operand::Type => match spec.type_field {
            TypeField::Unused => "TYPE",
            TypeField::Named => "KEYWORD",
            TypeField::AxisParameter | TypeField::GlobalParameter => "PARAMETER",
            TypeField::Port => "PORT",
            TypeField::Coordinate => "COORDINATE",
            TypeField::Interrupt => "INTERRUPT",
        },
        Operand::Motor if spec.motor_field == MotorField::Bank => "BANK",
        Operand::Motor => "MOTOR",
        Operand::Value => match spec.value_field {
            ValueField::Velocity => "VELOCITY",
            ValueField::Position | ValueField::CoordinateValue => "POSITION",
            ValueField::Address => "ADDRESS",
            ValueField::Ticks => "TICKS",
            _ => "VALUE",
        },
    }
}

/// The name that is at most a third different.
fn strsim_nearest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    let distance = |other: &str| strsim::damerau_levenshtein(&name, other);
    names
        .map(|other| (distance(other), other))
        .min()
        .filter(|(distance, other)| distance * 3 <= other.len())
        .map(|it| it.1)
}

#[cfg(test)]
mod tests {
    use tmcl_tables::tmcm_1311;

    use super::*;

    #[test]
    fn parameters_have_names_and_numbers() {
        let found = |name: &str| find(&tmcm_1311::SPEC, name).map(|(place, parameter)| (place, parameter.id));
        assert_eq!(found("actual_position"), Ok((Place::Axis(1), "actual_position")));
        assert_eq!(found("1"), found("Actual_Position"));
        assert_eq!(found("0/66"), Ok((Place::Global(0, 66), "serial_address")));
        assert_eq!(found("serial_address"), found("0/66"));
        assert_eq!(found("2/17").map(|(place, _)| place), Ok(Place::Global(2, 17)));
        let error = found("actual_postion").expect_err("a slip");
        assert_eq!(error, "the TMCM-1311 has no parameter `actual_postion`; did you mean `actual_position`?");
        assert!(found("250").is_err() && found("9/9").is_err() && found("").is_err());
    }

    #[test]
    fn values_are_numbers_or_names() {
        let (_, baud) = find(&tmcm_1311::SPEC, "baud_rate").expect("it is there");
        assert_eq!(value(baud, "baud_115200"), Ok(7));
        assert_eq!(value(baud, "0x7"), Ok(7));
        assert_eq!(value(baud, "-5"), Ok(-5));
        assert!(value(baud, "fast").is_err() && value(baud, "5000000000").is_err());
    }
}
