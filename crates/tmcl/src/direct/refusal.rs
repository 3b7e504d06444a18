//! Why a module refused a command, as far as the tables know.

use tmcl_client::{Client, Described};
use tmcl_link::Link;
use tmcl_tables::{Command, CommandSpec, ModuleSpec, MotorField, STATUSES, Status, TypeField, ValueField};
use tmcl_wire::Request;

use super::meaning;

/// What was sent, what came back, what that means, and which operand it is about.
pub(crate) fn refusal<L: Link>(
    client: &Client<L>,
    request: Request,
    status: Status,
    module: &'static ModuleSpec,
) -> String {
    let line = client.last_exchange().map_or_else(String::new, |exchange| format!("\n{exchange}"));
    explanation(request, status, module) + &line
}

fn explanation(request: Request, status: Status, module: &'static ModuleSpec) -> String {
    let spec = STATUSES.iter().find(|spec| spec.status == status);
    let (name, summary) = spec.map_or(("", ""), |spec| (spec.name, spec.summary));
    let about =
        Command::try_from(request.command).ok().and_then(|it| operand(request, it.spec(), status, module));
    let about = about.map_or_else(String::new, |about| format!("; {about}"));
    format!(
        "the module refused {} with status {}, {name}: {}{about}",
        Described(request),
        status.number(),
        lower_case(summary),
    )
}

fn lower_case(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// The operand that a status is about.
fn operand(
    request: Request,
    spec: &CommandSpec,
    status: Status,
    module: &'static ModuleSpec,
) -> Option<String> {
    match status {
        Status::WrongType => Some(format!("the type is in question: {}", type_text(request, spec, module))),
        Status::InvalidValue if names_other_motor(request, spec) => Some(format!(
            "the motor is in question: {}, and the {} has motor 0 only",
            request.motor, module.name
        )),
        Status::InvalidValue if names_other_coordinate(request, spec, module) => {
            Some(format!("the coordinate is in question: {}, and {}", request.kind, coordinates(module)))
        }
        Status::InvalidValue => {
            Some(format!("the value is in question: {}", value_text(request, spec, module)))
        }
        Status::EepromLocked => Some("`SGP 73, 0, 4321` unlocks it, 1234 locks it again".to_owned()),
        _ => None,
    }
}

fn names_other_motor(request: Request, spec: &CommandSpec) -> bool {
    spec.motor_field == MotorField::Motor && request.motor != 0
}

fn names_other_coordinate(request: Request, spec: &CommandSpec, module: &ModuleSpec) -> bool {
    spec.type_field == TypeField::Coordinate && request.kind >= module.coordinates
}

/// Which coordinates there are.
fn coordinates(module: &ModuleSpec) -> String {
    match module.coordinates.checked_sub(1) {
        Some(last) => format!("the {} has the coordinates 0 to {last}", module.name),
        None => format!("the {} has no coordinates", module.name),
    }
}

/// Which addresses a program can have.
pub(crate) fn addresses(module: &ModuleSpec) -> String {
    match module.program_memory.checked_sub(1) {
        Some(last) => format!("the program memory of the {} has the addresses 0 to {last}", module.name),
        None => format!("the {} has no program memory", module.name),
    }
}

fn type_text(request: Request, spec: &CommandSpec, module: &'static ModuleSpec) -> String {
    let (kind, motor) = (request.kind, request.motor);
    let what = match spec.type_field {
        TypeField::AxisParameter => format!("axis parameter {kind}"),
        TypeField::GlobalParameter => format!("global parameter {kind} of bank {motor}"),
        TypeField::Port => format!("port {kind} of bank {motor}"),
        TypeField::Coordinate => format!("coordinate {kind}"),
        TypeField::Interrupt => format!("interrupt {kind}"),
        TypeField::Unused | TypeField::Named => kind.to_string(),
    };
    match meaning::parameter(request, spec, module) {
        Some(parameter) => format!("{what}, {}, has the access {}", parameter.name, parameter.access),
        None => what,
    }
}

fn value_text(request: Request, spec: &CommandSpec, module: &'static ModuleSpec) -> String {
    let written =
        meaning::parameter(request, spec, module).filter(|_| spec.value_field == ValueField::ParameterValue);
    match written {
        Some(parameter) => format!(
            "{}, and {} takes {} {}",
            parameter.from_wire(request.value),
            parameter.name,
            parameter.write_range,
            parameter.unit
        )
        .trim_end()
        .to_owned(),
        None => {
            let allowed = allowed(request, spec, module);
            allowed.map_or_else(|| request.value.to_string(), |text| format!("{}, and {text}", request.value))
        }
    }
}

/// What a value that is no parameter's may be, where the tables of the module bound it.
fn allowed(request: Request, spec: &CommandSpec, module: &ModuleSpec) -> Option<String> {
    let is_coordinate = || {
        let named = spec.types.iter().find(|named| named.value == request.kind);
        named.is_some_and(|named| named.keyword == "COORD")
    };
    match spec.value_field {
        ValueField::Address => Some(addresses(module)),
        ValueField::Position if is_coordinate() => Some(coordinates(module)),
        ValueField::Magic => Some("only 1234 confirms it".to_owned()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use tmcl_tables::tmcm_1311;

    use super::*;

    #[test]
    fn the_operand_is_named() {
        use Command::{
            ApplicationRun, FactoryReset, GetAxisParameter, MoveToPosition, ReadProgramMemory,
            SetAxisParameter, SetCoordinate, SetOutput, StoreAxisParameter,
        };
        let refused = [
            (Request::new(GetAxisParameter, 29, 0, 0), Status::WrongType),
            (Request::new(GetAxisParameter, 250, 0, 0), Status::WrongType),
            (Request::new(SetAxisParameter, 140, 0, 9), Status::InvalidValue),
            (Request::new(MoveToPosition, 0, 3, 9), Status::InvalidValue),
            (Request::new(SetOutput, 9, 2, 1), Status::WrongType),
            (Request::new(StoreAxisParameter, 4, 0, 0), Status::EepromLocked),
            (Request::new(FactoryReset, 0, 0, 1), Status::InvalidValue),
            (Request::new(ApplicationRun, 1, 0, 5000), Status::InvalidValue),
            (Request::new(ReadProgramMemory, 0, 0, 2048), Status::InvalidValue),
            (Request::new(SetCoordinate, 21, 0, 7), Status::InvalidValue),
            (Request::new(MoveToPosition, 2, 0, 99), Status::InvalidValue),
            (Request { command: 200, ..Request::default() }, Status::InvalidCommand),
        ];
        let messages = refused.map(|(request, status)| explanation(request, status, &tmcm_1311::SPEC));
        insta::assert_snapshot!(messages.join("\n"));
    }
}
