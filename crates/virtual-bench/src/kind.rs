//! The kinds of modules that the bench can build.

use bench_hardware::MotorFamily;
use tmcl_tables::{GlobalParameter, ModuleSpec};

/// A kind of module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModuleKind {
    /// The TMCM-1311, for steppers.
    Tmcm1311,
    /// The TMCM-1640, for brushless motors.
    Tmcm1640,
    /// The TMCM-1076, which makes a stepper follow step and direction pulses.
    Tmcm1076,
}

/// The tables know this module, but there is no virtual one yet; the kinds there are stand in [`ModuleKind::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no virtual {0} yet")]
pub struct UnknownModuleKind(pub &'static str);

impl ModuleKind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Tmcm1311, Self::Tmcm1640, Self::Tmcm1076];

    /// The module's tables.
    #[must_use]
    pub fn spec(self) -> &'static ModuleSpec {
        match self {
            Self::Tmcm1311 => &tmcl_tables::tmcm_1311::SPEC,
            Self::Tmcm1640 => &tmcl_tables::tmcm_1640::SPEC,
            Self::Tmcm1076 => &tmcl_tables::tmcm_1076::SPEC,
        }
    }

    /// The motors that it drives.
    pub(crate) const fn motor(self) -> MotorFamily {
        match self {
            Self::Tmcm1311 | Self::Tmcm1076 => MotorFamily::Stepper,
            Self::Tmcm1640 => MotorFamily::Brushless,
        }
    }
}

impl ModuleKind {
    /// It looks at an encoder and at switches.
    pub(crate) const fn has_sensors(self) -> bool {
        match self {
            Self::Tmcm1311 | Self::Tmcm1640 => true,
            Self::Tmcm1076 => false,
        }
    }

    /// Its serial address can be another one.
    #[must_use]
    pub fn has_settable_address(self) -> bool {
        let (bank, number) = GlobalParameter::SerialAddress.address();
        self.spec().global_parameter(bank, number).is_some()
    }
}

impl TryFrom<&'static ModuleSpec> for ModuleKind {
    type Error = UnknownModuleKind;

    fn try_from(spec: &'static ModuleSpec) -> Result<Self, UnknownModuleKind> {
        let kind = Self::ALL.into_iter().find(|kind| kind.spec().number == spec.number);
        kind.ok_or(UnknownModuleKind(spec.id))
    }
}
