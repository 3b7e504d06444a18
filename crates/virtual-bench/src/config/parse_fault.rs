//! What can break on a running bench, by name: `fault.coil_open`, `fault.hall_2`.

use core::ops::RangeInclusive;

use super::module::ModuleConfig;
use super::parse_setting::{SettingError, SettingValue, choice, quantity_of, unknown, whole};
use super::quantity;
use bench_hardware::MotorFamily;
use bench_hardware::{Coil, Contact, EncoderLine, HallSensor, Phase, Setting, SwitchName};

/// Full steps that an event may make the rotor slip.
const DROPPED_STEPS: RangeInclusive<i32> = -1_000_000..=1_000_000;

const COILS: [(&str, Option<Coil>); 3] = [("none", None), ("a", Some(Coil::A)), ("b", Some(Coil::B))];

const PHASES: [(&str, Option<Phase>); 4] =
    [("none", None), ("u", Some(Phase::U)), ("v", Some(Phase::V)), ("w", Some(Phase::W))];

const LINES: [(&str, Option<EncoderLine>); 4] = [
    ("none", None),
    ("a", Some(EncoderLine::A)),
    ("b", Some(EncoderLine::B)),
    ("index", Some(EncoderLine::Index)),
];

const LEVELS: [(&str, Option<bool>); 3] = [("none", None), ("low", Some(false)), ("high", Some(true))];

const CONTACTS: [(&str, Option<Contact>); 3] =
    [("none", None), ("open", Some(Contact::Open)), ("closed", Some(Contact::Closed))];

/// `fault.…` of a module; `name` is the whole name.
pub(super) fn parse_fault(
    module: &ModuleConfig,
    fault: &str,
    name: &str,
    value: SettingValue<'_>,
) -> Result<Setting, SettingError> {
    match fault {
        "encoder_line" if !module.kind.has_sensors() => {
            let message = format!("{} has no encoder", module.name);
            Err(SettingError::name(message, format!("it is a {}", module.kind.spec().id)))
        }
        "encoder_line" => choice(name, value, &LINES).map(Setting::EncoderLine),
        "switch_left" => contact(module, SwitchName::Left, name, value),
        "switch_right" => contact(module, SwitchName::Right, name, value),
        "switch_home" => contact(module, SwitchName::Home, name, value),
        "eeprom_cut" if value == SettingValue::Text("none") => Ok(Setting::EepromCut(None)),
        "eeprom_cut" => whole(name, value, 0..=u32::MAX)
            .map(|writes| Setting::EepromCut(Some(writes)))
            .map_err(|error| SettingError { help: Some("or \"none\"".to_owned()), ..error }),
        "board_temperature_c" => match value {
            SettingValue::Text("none") => Ok(Setting::BoardTemperatureC(None)),
            SettingValue::Text(_) => Err(SettingError::value(format!("{name} must be a number or \"none\""))),
            SettingValue::Number(_) => quantity_of(name, value, &quantity::TEMPERATURE)
                .map(|temperature_c| Setting::BoardTemperatureC(Some(temperature_c))),
        },
        "coil_open" | "coil_short" | "dropped_steps" => {
            check_family(module, MotorFamily::Stepper, name)?;
            stepper_fault(fault, name, value)
        }
        "phase_open" | "phase_short" | "hall_1" | "hall_2" | "hall_3" => {
            check_family(module, MotorFamily::Brushless, name)?;
            brushless_fault(fault, name, value)
        }
        _ => Err(unknown(name, Some(module.kind.motor()))),
    }
}

fn stepper_fault(fault: &str, name: &str, value: SettingValue<'_>) -> Result<Setting, SettingError> {
    match fault {
        "coil_open" => choice(name, value, &COILS).map(Setting::CoilOpen),
        "coil_short" => choice(name, value, &COILS).map(Setting::CoilShort),
        _ => whole(name, value, DROPPED_STEPS).map(Setting::DroppedSteps),
    }
}

fn brushless_fault(fault: &str, name: &str, value: SettingValue<'_>) -> Result<Setting, SettingError> {
    let hall = |sensor| choice(name, value, &LEVELS).map(|stuck| Setting::HallLine { sensor, stuck });
    match fault {
        "phase_open" => choice(name, value, &PHASES).map(Setting::PhaseOpen),
        "phase_short" => choice(name, value, &PHASES).map(Setting::PhaseShort),
        "hall_1" => hall(HallSensor::H1),
        "hall_2" => hall(HallSensor::H2),
        _ => hall(HallSensor::H3),
    }
}

/// Complains about a fault of a motor that the module does not drive.
fn check_family(module: &ModuleConfig, family: MotorFamily, name: &str) -> Result<(), SettingError> {
    if module.kind.motor() == family {
        return Ok(());
    }
    let (motor, instead) = match family {
        MotorFamily::Stepper => {
            ("stepper", "fault.phase_open, fault.phase_short, fault.hall_1 to fault.hall_3")
        }
        MotorFamily::Brushless => {
            ("brushless motor", "fault.coil_open, fault.coil_short, fault.dropped_steps")
        }
    };
    let message = format!("{name} is a fault of a {motor}, which {} does not drive", module.name);
    Err(SettingError::name(message, format!("what can break here instead: {instead}")))
}

fn contact(
    module: &ModuleConfig,
    switch: SwitchName,
    name: &str,
    value: SettingValue<'_>,
) -> Result<Setting, SettingError> {
    let stuck = choice(name, value, &CONTACTS)?;
    let missing = || {
        let message = format!("{} has no {} switch", module.name, switch.word());
        SettingError::name(message, "a switch needs a place in [module.switches], however far away")
    };
    module.switches.get(switch).map(|_| Setting::SwitchContact { switch, stuck }).ok_or_else(missing)
}
