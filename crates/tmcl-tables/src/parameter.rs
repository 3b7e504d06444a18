//! One parameter: its number, range, default and access, and how its value travels.

/// Who says so: the manual, or OpenTMCL where the manual is silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Printed in the module's firmware manual.
    Manual,
    /// Not printed; chosen by OpenTMCL.
    Chosen,
}

/// What may be done with a parameter, the letters R, W and E of the manuals' access columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// R: readable with GAP or GGP.
    pub read: bool,
    /// W: writable with SAP, AAP, SGP or AGP.
    pub write: bool,
    /// E: kept in EEPROM and restored at power-on.
    pub store: bool,
}

impl core::fmt::Display for Access {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let letters = match (self.read, self.write, self.store) {
            (true, true, true) => "RWE",
            (true, true, false) => "RW",
            (true, false, true) => "RE",
            (true, false, false) => "R",
            (false, true, true) => "WE",
            (false, true, false) => "W",
            (false, false, true) => "E",
            (false, false, false) => "-",
        };
        f.pad(letters)
    }
}

/// The values a parameter may take: inclusive intervals, of which only the multiples of `step` count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ValueSet {
    /// Inclusive intervals in ascending order.
    pub intervals: &'static [(i64, i64)],
    /// Only multiples of this are in the set; 1 for every integer.
    pub step: i64,
}

impl ValueSet {
    /// Whether `value` is in the set.
    #[must_use]
    pub fn contains(&self, value: i64) -> bool {
        (self.step == 1 || value.checked_rem(self.step) == Some(0))
            && self.intervals.iter().any(|&(low, high)| (low..=high).contains(&value))
    }
}

impl core::fmt::Display for ValueSet {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for (index, (low, high)) in self.intervals.iter().enumerate() {
            if index > 0 {
                f.write_str(", ")?;
            }
            match high - low {
                0 => write!(f, "{low}")?,
                1 if self.step == 1 => write!(f, "{low}, {high}")?,
                _ => write!(f, "{low}…{high}")?,
            }
        }
        if self.step != 1 {
            write!(f, " in steps of {}", self.step)?;
        }
        Ok(())
    }
}

/// What part a parameter plays in the configuration of a module: what somebody keeps in a file and puts into another module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// How the module behaves.
    Setting,
    /// How the module is reached. Another value may cut the connection, or make two modules answer to one address.
    Connection,
    /// Keeps others from changing or reading something; each bit that is set forbids one thing.
    Lock,
    /// None: it says or commands what happens, or counts it.
    State,
}

/// A value with a name of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NamedValue {
    /// The number.
    pub value: i64,
    /// What to write for it; the same number but for few parameters.
    pub write: i64,
    /// The identifier, as `tmcl set` takes it.
    pub id: &'static str,
    /// The name, for people.
    pub name: &'static str,
}

/// Some bits of a parameter that mean something by themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitField {
    /// The identifier.
    pub id: &'static str,
    /// The lowest bit.
    pub low: u8,
    /// The highest bit.
    pub high: u8,
    /// The name, for people.
    pub name: &'static str,
}

impl BitField {
    /// The field's value within `value`, unsigned.
    #[must_use]
    pub fn extract(&self, value: i64) -> i64 {
        let width = u32::from(self.high.saturating_sub(self.low)) + 1;
        (value >> self.low) & ((1_i64 << width.min(62)) - 1)
    }
}

/// One axis or global parameter of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterSpec {
    /// The number in the type field of SAP, GAP, SGP, GGP.
    pub number: u8,
    /// The manual's name.
    pub name: &'static str,
    /// OpenTMCL's identifier.
    pub id: &'static str,
    /// What it is, in a line.
    pub summary: &'static str,
    /// The unit; empty for flags, enumerations and plain numbers.
    pub unit: &'static str,
    /// The unit in closed-loop operation; the same as `unit` where nothing changes.
    pub closed_loop_unit: &'static str,
    /// What it may hold and a read may return.
    pub range: ValueSet,
    /// Who says so.
    pub range_from: Source,
    /// What a write may carry.
    pub write_range: ValueSet,
    /// The factory setting; for measured values, what a module at rest reads.
    pub default: i64,
    /// Who says so.
    pub default_from: Source,
    /// Readable, writable, storable.
    pub access: Access,
    /// What it is in a configuration.
    pub role: Role,
    /// Whether the 32 bits on the wire are unsigned.
    pub unsigned: bool,
    /// Values with names.
    pub values: &'static [NamedValue],
    /// Bit fields.
    pub fields: &'static [BitField],
    /// Whether writing it can set the motor moving.
    pub starts_motion: bool,
    /// Whether reading or writing it twice is the same as once.
    pub repeat_safe: bool,
    /// The section of the manual.
    pub section: &'static str,
    /// Where it comes from when the manual does not have it; empty otherwise.
    pub beyond_manual: &'static str,
    /// How a slip or contradiction in the manual was decided; empty otherwise.
    pub note: &'static str,
}

impl ParameterSpec {
    /// The value that 32 bits on the wire stand for.
    #[must_use]
    pub fn from_wire(&self, bits: i32) -> i64 {
        if self.unsigned { i64::from(bits.cast_unsigned()) } else { i64::from(bits) }
    }

    /// The 32 bits that `value` travels as; higher bits are dropped.
    #[must_use]
    pub fn to_wire(&self, value: i64) -> i32 {
        #[expect(clippy::cast_possible_truncation, reason = "two's complement is the wire format")]
        {
            value as i32
        }
    }

    /// Whether the manual allows a write of these 32 bits.
    #[must_use]
    pub fn allows_write(&self, bits: i32) -> bool {
        self.write_range.contains(self.from_wire(bits))
    }

    /// The factory setting as it travels.
    #[must_use]
    pub fn default_bits(&self) -> i32 {
        self.to_wire(self.default)
    }

    /// What to write so that `value` is read afterwards: the same but for few parameters.
    #[must_use]
    pub fn written_for(&self, value: i64) -> i64 {
        self.values.iter().find(|named| named.value == value).map_or(value, |named| named.write)
    }

    /// The name of `value`, where it has one.
    #[must_use]
    pub fn value_name(&self, value: i64) -> Option<&'static str> {
        self.values.iter().find(|named| named.value == value).map(|named| named.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_with_a_hole_and_one_with_a_step() {
        let with_hole = ValueSet { intervals: &[(0, 0), (2, 15)], step: 1 };
        assert!(with_hole.contains(0) && with_hole.contains(2) && with_hole.contains(15));
        assert!(!with_hole.contains(1) && !with_hole.contains(16) && !with_hole.contains(-1));
        let sums = ValueSet { intervals: &[(0, 28)], step: 4 };
        assert!(sums.contains(0) && sums.contains(12) && !sums.contains(6) && !sums.contains(32));
    }

    #[test]
    fn unsigned_values_travel_as_twos_complement() {
        let sum = crate::tmcm_1311::AxisParameter::I2tLimit.spec();
        assert!(sum.unsigned);
        assert_eq!(sum.from_wire(-1), 4_294_967_295);
        assert_eq!(sum.to_wire(4_294_967_295), -1);
        assert!(sum.allows_write(-1));
    }

    #[test]
    fn the_lock_is_written_with_other_numbers_than_it_reads() {
        let (bank, number) = crate::GlobalParameter::EepromLock.address();
        let lock = crate::tmcm_1311::SPEC.global_parameter(bank, number).expect("it has one").parameter;
        assert_eq!((lock.written_for(1), lock.written_for(0)), (1234, 4321));
        let role = |parameter: crate::tmcm_1311::AxisParameter| parameter.spec().role;
        use crate::tmcm_1311::AxisParameter as P;
        assert_eq!((role(P::MaxVelocity), role(P::ActualPosition)), (Role::Setting, Role::State));
        assert_eq!((role(P::SupplyVoltage), lock.role), (Role::State, Role::Lock));
    }

    #[test]
    fn a_bit_field_is_cut_out() {
        let field = BitField { id: "toff", low: 4, high: 6, name: "" };
        assert_eq!(field.extract(0b0101_1111), 0b101);
    }
}
