//! `[module.motor]`: a motor by its maker's name, or by its figures.

use motor_physics::pmsm::PmsmParameters;
use motor_physics::presets::{PMSMS, STEPPERS, pmsm, stepper};
use motor_physics::stepper::StepperParameters;

use super::error::ConfigError;
use super::quantity::{self, Quantity};
use super::section::Section;
use super::suggest;
use crate::ModuleKind;
use bench_hardware::MotorFamily;

/// A motor.
#[derive(Clone, Debug, PartialEq)]
pub enum MotorConfig {
    /// One of [`motor_physics::presets`], spelt as there.
    Preset(&'static str),
    /// A two-phase hybrid stepper by its figures.
    Stepper(StepperParameters),
    /// A three-phase brushless motor by its figures.
    Bldc(BldcConfig),
}

/// The figures of a brushless motor, as its datasheet gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct BldcConfig {
    /// Pole pairs, half the poles.
    pub pole_pairs: u32,
    /// Torque per ampere of winding current.
    pub torque_constant_nm_per_a: f64,
    /// Resistance between two lines.
    pub line_resistance_ohm: f64,
    /// Inductance between two lines.
    pub line_inductance_h: f64,
    /// Rated current.
    pub rated_current_a: f64,
    /// Moment of inertia of the rotor.
    pub rotor_inertia_kgm2: f64,
    /// Thermal time constant of the winding.
    pub winding_time_constant_s: f64,
}

impl BldcConfig {
    /// The star of three phases that behaves the same: half of what is measured between two lines is a phase's. What the
    /// figures do not say follows from them, at the voltage of the default bench.
    #[must_use]
    pub fn parameters(&self) -> PmsmParameters {
        /// Peak over rated current, as of the presets.
        const PEAK: f64 = 3.0;
        const RATED_V: f64 = 24.0;
        let pole_pairs = f64::from(self.pole_pairs);
        let phase_inductance_h = self.line_inductance_h / 2.0;
        let rated_torque_nm = self.torque_constant_nm_per_a * self.rated_current_a;
        PmsmParameters {
            pole_pairs,
            resistance_ohm: self.line_resistance_ohm / 2.0,
            d_inductance_h: phase_inductance_h,
            q_inductance_h: phase_inductance_h,
            flux_linkage_wb: PmsmParameters::flux_linkage_from(self.torque_constant_nm_per_a, pole_pairs),
            rotor_inertia_kgm2: self.rotor_inertia_kgm2,
            rated_voltage_v: RATED_V,
            rated_velocity_rad_s: (RATED_V - self.rated_current_a * self.line_resistance_ohm).max(0.0)
                / self.torque_constant_nm_per_a,
            rated_current_a: self.rated_current_a,
            rated_torque_nm,
            peak_current_a: PEAK * self.rated_current_a,
            peak_torque_nm: PEAK * rated_torque_nm,
            winding_time_constant_s: self.winding_time_constant_s,
        }
    }
}

impl MotorConfig {
    /// The motor of a module of this kind unless the file says otherwise (decision: the default bench).
    #[must_use]
    pub fn default_for(kind: ModuleKind) -> Self {
        match kind {
            ModuleKind::Tmcm1311 | ModuleKind::Tmcm1076 => Self::Preset("QSH5718-51-28-101"),
            ModuleKind::Tmcm1640 => Self::Preset("QBL4208-61-04-013"),
        }
    }

    /// The figures of a stepper; `None`: it is no stepper.
    #[must_use]
    pub fn stepper(&self) -> Option<StepperParameters> {
        match self {
            Self::Preset(name) => stepper(name),
            Self::Stepper(figures) => Some(*figures),
            Self::Bldc(_) => None,
        }
    }

    /// The figures of a brushless motor; `None`: it is none.
    #[must_use]
    pub fn brushless(&self) -> Option<PmsmParameters> {
        match self {
            Self::Preset(name) => pmsm(name),
            Self::Stepper(_) => None,
            Self::Bldc(figures) => Some(figures.parameters()),
        }
    }

    fn family(&self) -> MotorFamily {
        if self.stepper().is_some() { MotorFamily::Stepper } else { MotorFamily::Brushless }
    }
}

/// What tells the figures of a brushless motor from those of a stepper.
const BLDC_KEYS: [&str; 4] =
    ["pole_pairs", "torque_constant_nm_per_a", "line_resistance_ohm", "line_inductance_h"];

/// Reads the section. `None`: it was wrong.
pub(super) fn read(mut section: Section<'_, '_>, kind: ModuleKind) -> Option<MotorConfig> {
    let motor = if section.entry("preset").is_some() {
        read_preset(section, kind)?
    } else {
        let family = described(&section, kind);
        check_family(&mut section, kind, family);
        match family {
            MotorFamily::Stepper => MotorConfig::Stepper(read_stepper(section)?),
            MotorFamily::Brushless => MotorConfig::Bldc(read_bldc(section)?),
        }
    };
    (motor.family() == kind.motor()).then_some(motor)
}

/// The family whose figures the section gives; where none tells, the one that the module drives.
fn described(section: &Section<'_, '_>, kind: ModuleKind) -> MotorFamily {
    let has = |keys: &[&str]| keys.iter().any(|key| section.key_span(key).is_some());
    if has(&BLDC_KEYS) {
        MotorFamily::Brushless
    } else if has(&STEPPER_ONLY_KEYS) {
        MotorFamily::Stepper
    } else {
        kind.motor()
    }
}

fn check_family(section: &mut Section<'_, '_>, kind: ModuleKind, family: MotorFamily) {
    if family != kind.motor() {
        let (found, wanted) = match family {
            MotorFamily::Stepper => ("a stepper motor", "brushless motors"),
            MotorFamily::Brushless => ("a brushless motor", "stepper motors"),
        };
        let message =
            format!("{} describes {found}; the {} drives {wanted}", section.title(), kind.spec().id);
        section.complain_here(message, Some(format!("presets: {}", presets(kind).join(", "))));
    }
}

/// The names of motors that a kind of module drives.
fn presets(kind: ModuleKind) -> Vec<&'static str> {
    match kind.motor() {
        MotorFamily::Stepper => steppers().collect(),
        MotorFamily::Brushless => brushless().collect(),
    }
}

fn steppers() -> impl Iterator<Item = &'static str> {
    STEPPERS.iter().map(|(name, _)| *name)
}

fn brushless() -> impl Iterator<Item = &'static str> {
    PMSMS.iter().map(|(name, _)| *name)
}

fn read_preset(mut section: Section<'_, '_>, kind: ModuleKind) -> Option<MotorConfig> {
    let name = section.text("preset");
    let preset = name.and_then(|(name, span)| {
        let found = steppers().chain(brushless()).find(|preset| preset.eq_ignore_ascii_case(name));
        if found.is_none() {
            let error = ConfigError::new(span, format!("unknown motor \"{name}\""));
            section.complain(error.with_help(suggest::help(name, &presets(kind))));
        }
        found
    });
    let motor = preset.map(MotorConfig::Preset);
    if let Some(motor) = &motor {
        check_family(&mut section, kind, motor.family());
    }
    for key in STEPPER_KEYS.into_iter().chain(BLDC_KEYS) {
        if section.entry(key).is_some()
            && let Some(span) = section.key_span(key)
        {
            section.complain(
                ConfigError::new(span, format!("{key} and preset exclude each other"))
                    .with_help("a motor is given by its preset, or by all of its figures"),
            );
        }
    }
    section.finish();
    motor
}

/// What tells the figures of a stepper from those of a brushless motor.
const STEPPER_ONLY_KEYS: [&str; 5] =
    ["resistance_ohm", "inductance_h", "holding_torque_nm", "detent_torque_nm", "full_steps"];

const STEPPER_KEYS: [&str; 8] = [
    "rated_current_a",
    "resistance_ohm",
    "inductance_h",
    "holding_torque_nm",
    "detent_torque_nm",
    "rotor_inertia_kgm2",
    "full_steps",
    "winding_time_constant_s",
];

/// Thermal time constant of a winding that says nothing about it: 22 minutes, as of two of the four motors in the decisions.
const DEFAULT_TIME_CONSTANT_S: f64 = 1320.0;

/// The same for a brushless motor: what the TMCM-1640's I²t monitor assumes (§9).
const DEFAULT_BRUSHLESS_TIME_CONSTANT_S: f64 = 13.2;

fn read_stepper(section: Section<'_, '_>) -> Option<StepperParameters> {
    let mut figures = Figures { section, missing: Vec::new() };
    let rated_current_a = figures.number("rated_current_a", &quantity::CURRENT);
    let resistance_ohm = figures.number("resistance_ohm", &quantity::WINDING_RESISTANCE);
    let inductance_h = figures.number("inductance_h", &quantity::INDUCTANCE);
    let holding_torque_nm = figures.number("holding_torque_nm", &quantity::HOLDING_TORQUE);
    let rotor_inertia_kgm2 = figures.number("rotor_inertia_kgm2", &quantity::ROTOR_INERTIA);
    let section = &mut figures.section;
    let detent_torque_nm = section.number("detent_torque_nm", &quantity::DETENT_TORQUE).unwrap_or(0.0);
    check_detent(section, detent_torque_nm, holding_torque_nm);
    let full_steps = read_full_steps(section);
    let winding_time_constant_s = section
        .number("winding_time_constant_s", &quantity::TIME_CONSTANT)
        .unwrap_or(DEFAULT_TIME_CONSTANT_S);
    figures.finish("preset, or these figures of a stepper");
    Some(StepperParameters {
        rated_current_rms_a: rated_current_a?,
        resistance_ohm: resistance_ohm?,
        inductance_h: inductance_h?,
        holding_torque_nm: holding_torque_nm?,
        detent_torque_nm,
        rotor_inertia_kgm2: rotor_inertia_kgm2?,
        pole_pairs: f64::from(full_steps) / 4.0,
        winding_time_constant_s,
    })
}

fn check_detent(section: &mut Section<'_, '_>, detent_torque_nm: f64, holding_torque_nm: Option<f64>) {
    let holding = holding_torque_nm.filter(|holding| detent_torque_nm > *holding);
    if let (Some(holding), Some(span)) = (holding, section.key_span("detent_torque_nm")) {
        let message =
            format!("detent_torque_nm must be at most holding_torque_nm, {holding}, not {detent_torque_nm}");
        section.complain(ConfigError::new(span, message));
    }
}

fn read_full_steps(section: &mut Section<'_, '_>) -> u32 {
    const DEFAULT: u32 = 200;
    let full_steps = section.integer("full_steps", &(4..=4000)).and_then(|steps| u32::try_from(steps).ok());
    if let (Some(steps), Some(span)) = (full_steps, section.key_span("full_steps"))
        && steps % 4 != 0
    {
        section.complain(ConfigError::new(span, format!("full_steps must be a multiple of 4, not {steps}")));
    }
    full_steps.unwrap_or(DEFAULT)
}

fn read_bldc(section: Section<'_, '_>) -> Option<BldcConfig> {
    let mut figures = Figures { section, missing: Vec::new() };
    let pole_pairs = figures.section.integer("pole_pairs", &(1..=100));
    figures.note_missing("pole_pairs");
    let torque_constant_nm_per_a = figures.number("torque_constant_nm_per_a", &quantity::TORQUE_CONSTANT);
    let line_resistance_ohm = figures.number("line_resistance_ohm", &quantity::WINDING_RESISTANCE);
    let line_inductance_h = figures.number("line_inductance_h", &quantity::INDUCTANCE);
    let rated_current_a = figures.number("rated_current_a", &quantity::CURRENT);
    let rotor_inertia_kgm2 = figures.number("rotor_inertia_kgm2", &quantity::ROTOR_INERTIA);
    let winding_time_constant_s = figures
        .section
        .number("winding_time_constant_s", &quantity::TIME_CONSTANT)
        .unwrap_or(DEFAULT_BRUSHLESS_TIME_CONSTANT_S);
    figures.finish("preset, or these figures of a brushless motor");
    Some(BldcConfig {
        pole_pairs: u32::try_from(pole_pairs?).ok()?,
        torque_constant_nm_per_a: torque_constant_nm_per_a?,
        line_resistance_ohm: line_resistance_ohm?,
        line_inductance_h: line_inductance_h?,
        rated_current_a: rated_current_a?,
        rotor_inertia_kgm2: rotor_inertia_kgm2?,
        winding_time_constant_s,
    })
}

/// A section all of whose figures must be there.
struct Figures<'t, 'e> {
    section: Section<'t, 'e>,
    missing: Vec<&'static str>,
}

impl Figures<'_, '_> {
    fn number(&mut self, key: &'static str, quantity: &Quantity) -> Option<f64> {
        self.note_missing(key);
        self.section.number(key, quantity)
    }

    fn note_missing(&mut self, key: &'static str) {
        if self.section.key_span(key).is_none() {
            self.missing.push(key);
        }
    }

    /// Complains once about all that is missing.
    fn finish(mut self, alternatives: &str) {
        if !self.missing.is_empty() {
            let message = format!("{} lacks {}", self.section.title(), self.missing.join(", "));
            self.section.complain_here(message, Some(format!("it takes {alternatives}, all of them")));
        }
        self.section.finish();
    }
}
