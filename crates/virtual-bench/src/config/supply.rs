//! `[supply]` and `[module.supply]`.
//!
//! Every module has its own source; `[supply]` gives the figures that hold where `[module.supply]` says nothing.

use motor_physics::supply::SupplyParameters;

use super::quantity;
use super::section::Section;
use crate::ModuleKind;

/// What a module of this kind runs on unless the file says otherwise (decision: power stage).
pub(super) const fn default_for(kind: ModuleKind) -> SupplyParameters {
    match kind {
        ModuleKind::Tmcm1311 => SupplyParameters::standard(48.0),
        ModuleKind::Tmcm1640 | ModuleKind::Tmcm1076 => SupplyParameters::standard(24.0),
    }
}

/// The figures that a section gives.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SupplyFigures {
    voltage_v: Option<f64>,
    source_resistance_ohm: Option<f64>,
    capacitance_f: Option<f64>,
}

impl SupplyFigures {
    pub(super) fn read(mut section: Section<'_, '_>) -> Self {
        let figures = Self {
            voltage_v: section.number("voltage_v", &quantity::VOLTAGE),
            source_resistance_ohm: section.number("source_resistance_ohm", &quantity::SOURCE_RESISTANCE),
            capacitance_f: section.number("capacitance_f", &quantity::CAPACITANCE),
        };
        section.finish();
        figures
    }

    /// `base` with these figures in their places.
    pub(super) fn over(self, base: SupplyParameters) -> SupplyParameters {
        SupplyParameters {
            voltage_v: self.voltage_v.unwrap_or(base.voltage_v),
            source_resistance_ohm: self.source_resistance_ohm.unwrap_or(base.source_resistance_ohm),
            capacitance_f: self.capacitance_f.unwrap_or(base.capacitance_f),
        }
    }
}
