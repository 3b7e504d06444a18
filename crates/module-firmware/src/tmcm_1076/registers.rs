//! Registers that can be written whole and field by field (decisions §7.3, §7.4).
//!
//! The manual's defaults for a register and for its fields contradict each other. A factory-fresh module reads the one and the
//! other as they are printed, and the fields' are in effect. From the first write to either on, all are views of one register.

use tmcl_tables::ParameterSpec;

use super::AxisParameter;

/// Some of a register's bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bits {
    low: u32,
    width: u32,
    signed: bool,
}

impl Bits {
    const fn unsigned(low: u32, width: u32) -> Self {
        Self { low, width, signed: false }
    }

    const fn mask(self) -> u32 {
        ((1 << self.width) - 1) << self.low
    }
}

/// CHOPCONF, MRES.
const MRES: Bits = Bits::unsigned(24, 4);
const INTPOL: Bits = Bits::unsigned(28, 1);
const DEDGE: Bits = Bits::unsigned(29, 1);

/// The bits of COOLCONF that a parameter is; None: it is another.
pub(super) const fn coolconf_field(parameter: AxisParameter) -> Option<Bits> {
    match parameter {
        AxisParameter::CoolstepHysteresisStart => Some(Bits::unsigned(0, 4)),
        AxisParameter::CoolstepUpStep => Some(Bits::unsigned(5, 2)),
        AxisParameter::CoolstepHysteresis => Some(Bits::unsigned(8, 4)),
        AxisParameter::CoolstepDownStep => Some(Bits::unsigned(13, 2)),
        AxisParameter::CoolstepMinCurrent => Some(Bits::unsigned(15, 1)),
        AxisParameter::Stallguard2Threshold => Some(Bits { low: 16, width: 7, signed: true }),
        AxisParameter::Stallguard2Filter => Some(Bits::unsigned(24, 1)),
        _ => None,
    }
}

/// The bits of CHOPCONF that a parameter is; None: it is another.
pub(super) const fn chopconf_field(parameter: AxisParameter) -> Option<Bits> {
    match parameter {
        AxisParameter::MicrostepInterpolation => Some(INTPOL),
        AxisParameter::DoubleEdgeSteps => Some(DEDGE),
        _ => None,
    }
}

/// CHOPCONF with the resolution of AP 140.
pub(super) fn with_resolution(chopconf: u32, microstep_resolution: u8) -> u32 {
    let mres = 8_u8.saturating_sub(microstep_resolution);
    (chopconf & !MRES.mask()) | u32::from(mres) << MRES.low
}

/// A register of which parameters are fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SharedRegister {
    /// What is in effect.
    bits: u32,
    /// What the register reads although it is not in effect, until it or a field is written.
    printed: Option<u32>,
    /// Bits that no write to the register changes; they read 0.
    excluded: u32,
}

/// COOLCONF as its fields' defaults have it.
pub(super) fn factory_coolconf() -> SharedRegister {
    factory(AxisParameter::Coolconf, coolconf_field, 0, 0)
}

/// CHOPCONF with its fields' defaults; what has no field is as its own default has it.
pub(super) fn factory_chopconf() -> SharedRegister {
    let printed = bits_of(AxisParameter::Chopconf.spec());
    factory(AxisParameter::Chopconf, chopconf_field, printed, MRES.mask())
}

fn factory(
    register: AxisParameter,
    field: fn(AxisParameter) -> Option<Bits>,
    bits: u32,
    excluded: u32,
) -> SharedRegister {
    let mut shared = SharedRegister { bits: bits & !excluded, printed: None, excluded };
    for parameter in AxisParameter::ALL {
        if let Some(bits) = field(*parameter) {
            shared.write_field(bits, parameter.spec().default_bits());
        }
    }
    SharedRegister { printed: Some(bits_of(register.spec())), ..shared }
}

fn bits_of(spec: &ParameterSpec) -> u32 {
    spec.default_bits().cast_unsigned()
}

impl SharedRegister {
    /// What the driver gets.
    pub(super) fn effective(self) -> u32 {
        self.bits
    }

    /// The register's value as it reads.
    pub(super) fn read(self) -> i32 {
        self.printed.unwrap_or(self.bits).cast_signed()
    }

    pub(super) fn write(&mut self, bits: i32) {
        self.bits = bits.cast_unsigned() & !self.excluded;
        self.printed = None;
    }

    pub(super) fn read_field(self, field: Bits) -> i32 {
        let above = 32 - field.width - field.low;
        let at_top = self.bits << above;
        let below = 32 - field.width;
        if field.signed { at_top.cast_signed() >> below } else { (at_top >> below).cast_signed() }
    }

    pub(super) fn write_field(&mut self, field: Bits, value: i32) {
        let mask = field.mask();
        self.bits = (self.bits & !mask) | (value.cast_unsigned() << field.low & mask);
        self.printed = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresh_registers_read_as_printed_and_act_as_their_fields_say() {
        let coolconf = factory_coolconf();
        assert_eq!((coolconf.read(), coolconf.effective()), (33_011, 0));
        let chopconf = factory_chopconf();
        assert_eq!((chopconf.read(), chopconf.effective()), (33_011, 33_011 | 1 << 28));
    }

    #[test]
    fn from_the_first_write_on_all_are_views_of_one_register() {
        let threshold = coolconf_field(AxisParameter::Stallguard2Threshold).expect("a field");
        let start = coolconf_field(AxisParameter::CoolstepHysteresisStart).expect("a field");
        let mut coolconf = factory_coolconf();
        coolconf.write_field(threshold, -3);
        assert_eq!(coolconf.read(), 0x7D << 16);
        assert_eq!(coolconf.read_field(threshold), -3);
        coolconf.write(33_011);
        assert_eq!((coolconf.read_field(threshold), coolconf.read_field(start)), (0, 3));
        let mut chopconf = factory_chopconf();
        chopconf.write(-1);
        assert_eq!(chopconf.read().cast_unsigned(), 0xF0FF_FFFF, "all but MRES");
        assert_eq!(with_resolution(chopconf.effective(), 3), 0xF5FF_FFFF);
    }

    #[test]
    fn fields_do_not_overlap() {
        for field in [coolconf_field, chopconf_field] {
            let masks = AxisParameter::ALL.iter().filter_map(|parameter| field(*parameter)).map(Bits::mask);
            masks.fold(0, |all, mask| {
                assert_eq!(all & mask, 0);
                all | mask
            });
        }
    }
}
