//! Names for everything one can look at on a bench: `actual_position`, `tick_timer`, `variable.7`, `output.3`,
//! `sensed.encoder_counts`, `sensed.step_pulses`, `physical.rotor_turns`, `eeprom.writes`; with several modules prefixed by
//! the module's name, `m1.actual_position`.

use tmcl_tables::{GlobalParameter, GlobalSpec, ModuleSpec};

use crate::bench::ModuleId;
use crate::config::suggest;
use crate::kind::ModuleKind;
use bench_hardware::MotorFamily;
use bench_hardware::Physical;

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
    /// A global parameter, as GGP reads it, but that no random number is drawn: bank and number. Bank 2 holds the user
    /// variables.
    Global(u8, u8),
    /// A coordinate, as GCO reads it.
    Coordinate(u8),
    /// A port, as GIO reads it: bank and number.
    Port(u8, u8),
    /// The raw count of the encoder.
    EncoderCounts,
    /// Pulses at the step/direction connector since the bench was switched on: those to the right less those to the left.
    StepPulses,
    /// Bytes written to the EEPROM since it was new.
    EepromWrites,
    /// An entry of [`Physical`].
    Physical(usize),
}

impl Quantity {
    /// Whether it changes while everything is at rest: only the tick timer (GP 132) does.
    #[must_use]
    pub fn changes_at_rest(self) -> bool {
        let (bank, number) = GlobalParameter::TickTimer.address();
        self == Self::Global(bank, number)
    }
}

/// Why a name names nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProbeError {
    /// No module of that name.
    #[error("`{0}` names no module; put one of {1} and a dot before it")]
    Module(String, String),
    /// Nothing of that name on the module; and what there is.
    #[error("nothing called `{0}`; {1}")]
    Quantity(String, String),
    /// A parameter that cannot be read.
    #[error("`{0}` can only be written")]
    WriteOnly(String),
}

/// The bank of the user variables (TMCM-1311 §10.3).
const VARIABLES: u8 = 2;

/// What the sensors count; pulses come to modules for steppers only, and a TMCM-1076 has no encoder.
const SENSED: [(&str, Quantity); 2] =
    [("sensed.encoder_counts", Quantity::EncoderCounts), ("sensed.step_pulses", Quantity::StepPulses)];

/// The name of [`Quantity::EepromWrites`].
const EEPROM_WRITES: &str = "eeprom.writes";

/// What a module's sensors count.
fn sensed(spec: &'static ModuleSpec) -> &'static [(&'static str, Quantity)] {
    let [counts, pulses] = &SENSED;
    let has_sensors = ModuleKind::try_from(spec).is_ok_and(ModuleKind::has_sensors);
    match family(spec) {
        MotorFamily::Stepper if has_sensors => &SENSED,
        MotorFamily::Stepper => core::slice::from_ref(pulses),
        MotorFamily::Brushless => core::slice::from_ref(counts),
    }
}

/// The motors that a module drives.
fn family(spec: &'static ModuleSpec) -> MotorFamily {
    ModuleKind::try_from(spec).map_or(MotorFamily::Stepper, ModuleKind::motor)
}

/// The names of ports but for their number, and their banks.
const PORTS: [(&str, u8); 3] = [("input.", 0), ("ain.", 1), ("output.", 2)];

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
            let quantity = quantity(rest, spec).ok_or_else(|| no_quantity(rest, spec))?;
            Ok(Probe { module: ModuleId(index), quantity })
        }
        None => {
            if let Some((_, spec)) = first {
                return Err(no_quantity(name, spec));
            }
            let names: Vec<_> = modules.iter().map(|(name, _)| *name).collect();
            Err(ProbeError::Module(name.to_owned(), names.join(", ")))
        }
    }
}

fn quantity(name: &str, spec: &'static ModuleSpec) -> Option<Quantity> {
    if let Some(physical) = name.strip_prefix("physical.") {
        let mut names = Physical::names_of(family(spec));
        return names.find(|(_, known)| *known == physical).map(|(index, _)| Quantity::Physical(index));
    }
    if let Some((_, sensed)) = sensed(spec).iter().copied().find(|(known, _)| *known == name) {
        return Some(sensed);
    }
    if name == EEPROM_WRITES {
        return Some(Quantity::EepromWrites);
    }
    if let Some(number) = name.strip_prefix("variable.") {
        let number = number.parse().ok()?;
        return spec.global_parameter(VARIABLES, number).map(|_| Quantity::Global(VARIABLES, number));
    }
    if let Some(number) = name.strip_prefix("coordinate.") {
        return number.parse().ok().filter(|number| *number < spec.coordinates).map(Quantity::Coordinate);
    }
    for (prefix, bank) in PORTS {
        if let Some(number) = name.strip_prefix(prefix) {
            let number = number.parse().ok()?;
            return spec.port(bank, number).map(|port| Quantity::Port(port.bank, port.number));
        }
    }
    parameter(name, spec)
}

/// A parameter by its identifier; where an axis and a global parameter have the same, the axis parameter.
fn parameter(id: &str, spec: &'static ModuleSpec) -> Option<Quantity> {
    if let Some(parameter) = spec.axis_parameters.iter().find(|parameter| parameter.id == id) {
        return parameter.access.read.then_some(Quantity::Parameter(parameter.number));
    }
    let GlobalSpec { bank, parameter, .. } = globals(spec).find(|entry| entry.parameter.id == id)?;
    parameter.access.read.then_some(Quantity::Global(*bank, parameter.number))
}

/// The global parameters that have a name each.
fn globals(spec: &'static ModuleSpec) -> impl Iterator<Item = &'static GlobalSpec> {
    spec.global_parameters.iter().filter(|entry| entry.bank != VARIABLES)
}

fn no_quantity(name: &str, spec: &'static ModuleSpec) -> ProbeError {
    let parameters = || spec.axis_parameters.iter().chain(globals(spec).map(|entry| &entry.parameter));
    if parameters().any(|parameter| parameter.id == name) {
        return ProbeError::WriteOnly(name.to_owned());
    }
    let help = numbered(name, spec).unwrap_or_else(|| {
        let physical: Vec<_> =
            Physical::names_of(family(spec)).map(|(_, name)| format!("physical.{name}")).collect();
        let ids = parameters().filter(|parameter| parameter.access.read).map(|parameter| parameter.id);
        let others = physical.iter().map(String::as_str).chain(sensed(spec).iter().map(|(name, _)| *name));
        let choices: Vec<_> = ids.chain(others).chain([EEPROM_WRITES]).collect();
        suggest::nearest(name, &choices)
            .map_or_else(|| all_kinds(spec), |choice| format!("did you mean `{choice}`?"))
    });
    ProbeError::Quantity(name.to_owned(), help)
}

/// The numbers there are, for a name that ends in one.
fn numbered(name: &str, spec: &ModuleSpec) -> Option<String> {
    if name.starts_with("variable.") && has_variables(spec) {
        return Some("there are `variable.0` to `variable.255`".to_owned());
    }
    if name.starts_with("coordinate.") {
        let last = spec.coordinates.checked_sub(1)?;
        return Some(format!("there are `coordinate.0` to `coordinate.{last}`"));
    }
    let (prefix, bank) = PORTS.into_iter().find(|(prefix, _)| name.starts_with(prefix))?;
    let ports = spec.ports.iter().filter(|port| port.bank == bank);
    let names: Vec<_> = ports.map(|port| format!("`{prefix}{}`", port.number)).collect();
    (!names.is_empty()).then(|| format!("there are {}", names.join(", ")))
}

/// Whether a module has user variables: one without programs has none.
fn has_variables(spec: &ModuleSpec) -> bool {
    spec.global_parameter(VARIABLES, 0).is_some()
}

/// What there is on a module.
fn all_kinds(spec: &'static ModuleSpec) -> String {
    let physical: Vec<_> = Physical::names_of(family(spec)).map(|(_, name)| name).collect();
    let coordinates = if spec.coordinates > 0 { "`coordinate.N`, " } else { "" };
    let sensed: Vec<_> = sensed(spec).iter().map(|(name, _)| format!("`{name}`")).collect();
    let parameters = if has_variables(spec) {
        "axis and global parameters such as `actual_position` and `tick_timer`, `variable.N`"
    } else {
        "axis parameters such as `max_current`"
    };
    let ports = [("`input.N`, ", 0), ("`output.N`, ", 2), ("`ain.N`, ", 1)];
    let ports = ports.iter().filter(|(_, bank)| spec.ports.iter().any(|port| port.bank == *bank));
    let ports: String = ports.map(|(name, _)| *name).collect();
    format!(
        "there are {parameters}, {coordinates}{ports}`{EEPROM_WRITES}`, {}, and physical.{{{}}}",
        sensed.join(", "),
        physical.join(", ")
    )
}

/// The unit of a quantity on a module; empty for plain numbers.
pub(crate) fn unit(quantity: Quantity, spec: &ModuleSpec) -> &'static str {
    match quantity {
        Quantity::Parameter(number) => spec.axis_parameter(number).map_or("", |parameter| parameter.unit),
        Quantity::Global(bank, number) => {
            spec.global_parameter(bank, number).map_or("", |entry| entry.parameter.unit)
        }
        Quantity::Coordinate(_) => "",
        Quantity::Port(bank, number) => spec.port(bank, number).map_or("", |port| port.unit),
        Quantity::EncoderCounts => "count",
        Quantity::StepPulses => "pulse",
        Quantity::EepromWrites => "",
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
        let pulses = Probe { module: ModuleId(1), quantity: Quantity::StepPulses };
        assert_eq!(parse("lift.sensed.step_pulses", &two), Ok(pulses));
    }

    #[test]
    fn global_parameters_variables_and_coordinates() {
        let one = [("m1", SPEC)];
        let quantity = |name| parse(name, &one).map(|probe| probe.quantity);
        assert_eq!(quantity("tick_timer"), Ok(Quantity::Global(0, 132)));
        assert_eq!(quantity("m1.program_counter"), Ok(Quantity::Global(0, 130)));
        assert_eq!(quantity("application_status"), Ok(Quantity::Global(0, 128)));
        assert_eq!(quantity("timer_0_period"), Ok(Quantity::Global(3, 0)));
        assert_eq!(quantity("variable.0"), Ok(Quantity::Global(2, 0)));
        assert_eq!(quantity("variable.255"), Ok(Quantity::Global(2, 255)));
        assert_eq!(quantity("coordinate.20"), Ok(Quantity::Coordinate(20)));
        assert!(quantity("user_variable").is_err(), "which of them?");
    }

    /// Every readable parameter has a name that finds it.
    #[test]
    fn no_parameter_is_hidden() {
        for entry in globals(SPEC).filter(|entry| entry.parameter.access.read) {
            let found = parameter(entry.parameter.id, SPEC);
            assert_eq!(found, Some(Quantity::Global(entry.bank, entry.parameter.number)));
        }
        for entry in SPEC.axis_parameters.iter().filter(|entry| entry.access.read) {
            assert_eq!(parameter(entry.id, SPEC), Some(Quantity::Parameter(entry.number)));
        }
    }

    #[test]
    fn each_motor_has_its_own_currents() {
        let brushless = [("m1", &tmcl_tables::tmcm_1640::SPEC)];
        for name in ["current_d_a", "current_q_a", "phase_u_a", "phase_v_a", "phase_w_a"] {
            let name = format!("physical.{name}");
            let found = parse(&name, &brushless).map(|probe| unit(probe.quantity, brushless[0].1));
            assert_eq!(found, Ok("A"), "{name}");
            assert!(parse(&name, &[("m1", SPEC)]).is_err(), "{name}");
        }
        for name in ["physical.coil_a_a", "physical.coil_b_a", "sensed.step_pulses", "coordinate.0"] {
            assert!(parse(name, &brushless).is_err() && parse(name, &[("m1", SPEC)]).is_ok(), "{name}");
        }
        assert!(parse("sensed.encoder_counts", &brushless).is_ok());
        let says = parse("colour", &brushless).expect_err("nothing").to_string();
        assert!(says.contains("phase_w_a") && !says.contains("coil_a_a"), "{says}");
        assert!(!says.contains("coordinate") && !says.contains("step_pulses"), "{says}");
    }

    #[test]
    fn what_names_nothing_is_refused_with_what_there_is() {
        let one = [("m1", SPEC)];
        let says = |name| parse(name, &one).expect_err(name).to_string();
        assert_eq!(
            says("actual_positio"),
            "nothing called `actual_positio`; did you mean `actual_position`?"
        );
        assert_eq!(says("m1.tick_time"), "nothing called `tick_time`; did you mean `tick_timer`?");
        assert_eq!(says("clear_i2t_flag"), "`clear_i2t_flag` can only be written");
        assert_eq!(
            says("coordinate.21"),
            "nothing called `coordinate.21`; there are `coordinate.0` to `coordinate.20`"
        );
        assert_eq!(
            says("sensed.step_pulse"),
            "nothing called `sensed.step_pulse`; did you mean `sensed.step_pulses`?"
        );
        assert!(says("variable.256").ends_with("there are `variable.0` to `variable.255`"));
        assert!(says("output.8").ends_with("`output.6`, `output.7`"));
        for name in ["", "colour", "physical.", "physical.turns", "sensed.", "."] {
            assert!(says(name).contains("there are axis and global parameters"), "{name}");
        }
        let two = [("m1", SPEC), ("m2", SPEC)];
        assert!(matches!(parse("m3.output.0", &two), Err(ProbeError::Module(..))));
        assert!(matches!(parse("output.0", &two), Err(ProbeError::Module(..))));
        assert!(matches!(parse("m2.output.8", &two), Err(ProbeError::Quantity(..))));
    }
}
