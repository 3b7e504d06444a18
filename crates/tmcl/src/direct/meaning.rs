//! What the value of a reply is about.

use tmcl_tables::{Command, CommandSpec, Direction, ModuleSpec, ParameterSpec, TypeField, ValueField};
use tmcl_wire::Request;

/// Stands for all ports of a bank (TMCM-1311 §5.7.15).
const ALL: u8 = 255;

/// A value in the light of the tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Meaning {
    /// The number that the 32 bits stand for.
    pub(crate) value: i64,
    /// Its unit; empty where it has none.
    pub(crate) unit: &'static str,
    /// What it is, and what this value is called.
    pub(crate) name: String,
}

impl Meaning {
    pub(crate) fn of(request: Request, bits: i32, module: &'static ModuleSpec) -> Self {
        let plain = Self { value: bits.into(), unit: "", name: String::new() };
        let Ok(spec) = Command::try_from(request.command).map(Command::spec) else { return plain };
        match spec.type_field {
            TypeField::AxisParameter | TypeField::GlobalParameter => match parameter(request, spec, module) {
                Some(parameter) if carries_value(spec) => of_parameter(parameter, bits),
                Some(parameter) => Self { name: parameter.name.to_owned(), ..plain },
                None => plain,
            },
            TypeField::Port => {
                Self { unit: port_unit(request, module), name: port(request, module), ..plain }
            }
            TypeField::Coordinate => Self { name: format!("Coordinate {}", request.kind), ..plain },
            TypeField::Unused | TypeField::Named | TypeField::Interrupt => {
                Self { name: spec.name.to_owned(), ..plain }
            }
        }
    }
}

/// Whether the value of the reply is the parameter's: the one that was read or written.
fn carries_value(spec: &CommandSpec) -> bool {
    use Command::{
        AccumulatorToAxisParameter, AccumulatorToGlobalParameter, GetAxisParameter, GetGlobalParameter,
    };
    let reads =
        [GetAxisParameter, GetGlobalParameter, AccumulatorToAxisParameter, AccumulatorToGlobalParameter];
    spec.value_field == ValueField::ParameterValue || reads.contains(&spec.command)
}

/// The parameter that a command is about.
pub(super) fn parameter(
    request: Request,
    spec: &CommandSpec,
    module: &'static ModuleSpec,
) -> Option<&'static ParameterSpec> {
    match spec.type_field {
        TypeField::AxisParameter => module.axis_parameter(request.kind),
        TypeField::GlobalParameter => {
            module.global_parameter(request.motor, request.kind).map(|entry| &entry.parameter)
        }
        _ => None,
    }
}

fn of_parameter(parameter: &'static ParameterSpec, bits: i32) -> Meaning {
    let value = parameter.from_wire(bits);
    let said = match parameter.value_name(value) {
        Some(name) => format!(": {name}"),
        None => fields(parameter, value),
    };
    // Which of the two units it is, only the module knows.
    let other = match parameter.closed_loop_unit {
        unit if unit == parameter.unit => String::new(),
        unit => format!(" ({unit} in closed loop)"),
    };
    Meaning { value, unit: parameter.unit, name: format!("{}{said}{other}", parameter.name) }
}

/// The bits that are set: `: overtemperature, phase=3`.
fn fields(parameter: &ParameterSpec, value: i64) -> String {
    let set =
        parameter.fields.iter().filter_map(|field| match (field.extract(value), field.high == field.low) {
            (0, _) => None,
            (_, true) => Some(field.id.to_owned()),
            (value, false) => Some(format!("{}={value}", field.id)),
        });
    let set: Vec<String> = set.collect();
    if set.is_empty() { String::new() } else { format!(": {}", set.join(", ")) }
}

fn port(request: Request, module: &'static ModuleSpec) -> String {
    match module.port(request.motor, request.kind) {
        Some(port) => port.name.to_owned(),
        None if request.kind == ALL => {
            let names = module.ports.iter().filter(|port| port.bank == request.motor);
            let is_output = names.clone().any(|port| port.direction == Direction::Output);
            format!("All {} {}s", names.count(), if is_output { "output" } else { "input" })
        }
        None => String::new(),
    }
}

fn port_unit(request: Request, module: &'static ModuleSpec) -> &'static str {
    module.port(request.motor, request.kind).map_or("", |port| port.unit)
}

#[cfg(test)]
mod tests {
    use tmcl_tables::tmcm_1311;

    use super::*;

    fn meaning(command: Command, kind: u8, motor: u8, bits: i32) -> (i64, &'static str, String) {
        let Meaning { value, unit, name } =
            Meaning::of(Request::new(command, kind, motor, 0), bits, &tmcm_1311::SPEC);
        (value, unit, name)
    }

    #[test]
    fn values_have_units_and_names() {
        use Command::{GetAxisParameter, GetGlobalParameter, GetInput, MotorStop};
        assert_eq!(meaning(GetAxisParameter, 140, 0, 8).2, "Microstep resolution: 256 microsteps");
        assert_eq!(meaning(GetAxisParameter, 26, 0, -1).0, 4_294_967_295);
        assert_eq!(meaning(GetGlobalParameter, 65, 0, 7).2, "RS485 baud rate: 115200 baud");
        assert_eq!(meaning(GetInput, 8, 1, 240).1, "0.1 V");
        assert_eq!(meaning(MotorStop, 0, 0, 0), (0, "", "Motor stop".to_owned()));
    }

    #[test]
    fn bits_that_are_set_are_named() {
        assert_eq!(
            meaning(Command::GetAxisParameter, 18, 0, 1 << 11 | 1 << 13).2,
            "Status word: overtemperature, i2t_exceeded"
        );
    }
}
