//! What a parameter is to be set to, and what it holds, in words.

use tmcl_tables::{NamedValue, ValueSet};

use crate::item::Item;
use crate::name::Name;
use crate::suggest;

/// Why a text is no value of a parameter. Every message says which parameter and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValueError {
    /// It cannot be written.
    #[error("`{0}` can only be read")]
    ReadOnly(String),
    /// Neither a number nor the name of a value.
    #[error("`{name}` cannot be `{text}`: {allowed}")]
    Text {
        /// The parameter.
        name: String,
        /// What was written.
        text: String,
        /// What is allowed.
        allowed: String,
    },
    /// A number that is not allowed.
    #[error("`{name}` cannot be {value}: {allowed}")]
    Range {
        /// The parameter.
        name: String,
        /// What was written.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// A number with the unit of something else.
    #[error("`{name}` is in {unit}, not in {found}")]
    Unit {
        /// The parameter.
        name: String,
        /// Its unit.
        unit: &'static str,
        /// What was written.
        found: String,
    },
    /// A number with a unit, for what has none.
    #[error("`{name}` is a number without a unit, not one in {found}")]
    NoUnit {
        /// The parameter.
        name: String,
        /// What was written.
        found: String,
    },
}

/// The value that `text` says `name` is to have, as it is read afterwards: a whole number, decimal, hexadecimal (`0x1F`) or
/// binary (`0b101`), with `_` between digits where it is long, and with the unit behind it or not; or the identifier of a
/// value. `closed_loop` says which unit counts where there are two.
///
/// # Errors
/// [`ValueError`] when it is none, or the parameter does not take it.
pub fn parse_value(text: &str, name: &Name, closed_loop: bool) -> Result<i64, ValueError> {
    if !name.item.access().write {
        return Err(ValueError::ReadOnly(name.to_string()));
    }
    let text = text.trim();
    let mut named = values(name).iter().filter(|named| may_become(named.value, name.item));
    if let Some(named) = named.find(|named| named.id.eq_ignore_ascii_case(text)) {
        return Ok(named.value);
    }
    let wrong =
        || ValueError::Text { name: name.to_string(), text: text.to_owned(), allowed: allowed(name, text) };
    let (number, rest) = number(text).ok_or_else(wrong)?;
    check_unit(rest.trim(), name, closed_loop).map_err(|error| error.unwrap_or_else(wrong))?;
    number.and_then(|number| accepted(number, name)).ok_or_else(|| ValueError::Range {
        name: name.to_string(),
        value: text.to_owned(),
        allowed: allowed(name, ""),
    })
}

/// What stands behind a number: nothing, or the unit. The inner error is absent where it is not even a unit.
fn check_unit(rest: &str, name: &Name, closed_loop: bool) -> Result<(), Option<ValueError>> {
    let unit = if name.field.is_some() { "" } else { name.item.unit(closed_loop) };
    if rest.is_empty() || (!unit.is_empty() && spelled(rest) == spelled(unit)) {
        return Ok(());
    }
    if !rest.starts_with(|letter: char| letter.is_alphabetic() || letter == '°' || letter == '%') {
        return Err(None);
    }
    let (name, found) = (name.to_string(), rest.to_owned());
    Err(Some(if unit.is_empty() {
        ValueError::NoUnit { name, found }
    } else {
        ValueError::Unit { name, unit, found }
    }))
}

/// A unit as it is compared: there are two letters µ, and many keyboards have none.
fn spelled(unit: &str) -> String {
    unit.replace(['µ', 'μ'], "u")
}

/// The number that stands at the start, and what follows it; the number is absent where it has too many digits.
fn number(text: &str) -> Option<(Option<i64>, &str)> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    let (radix, digits) = [("0x", 16), ("0X", 16), ("0b", 2), ("0B", 2)]
        .into_iter()
        .find_map(|(prefix, radix)| Some((radix, digits.strip_prefix(prefix)?)))
        .unwrap_or((10, digits));
    let end = digits.find(|letter: char| !letter.is_digit(radix) && letter != '_').unwrap_or(digits.len());
    let (digits, rest) = digits.split_at(end);
    if !digits.starts_with(|letter: char| letter.is_digit(radix)) || digits.ends_with('_') {
        return None;
    }
    let value = i64::from_str_radix(&digits.replace('_', ""), radix).ok();
    Some((value.map(|value| if negative { -value } else { value }), rest))
}

/// The value that is read once `number` is written, if the parameter takes it.
fn accepted(number: i64, name: &Name) -> Option<i64> {
    if let Some(field) = name.field {
        return (0..=field.extract(-1)).contains(&number).then_some(number);
    }
    if may_become(number, name.item) {
        return Some(number);
    }
    let mut others = name.item.values().iter().filter(|named| named.write != named.value);
    others.find(|named| named.write == number).map(|named| named.value)
}

/// Whether there is something to write so that `value` is read afterwards.
fn may_become(value: i64, item: Item) -> bool {
    let written = item.spec().is_none_or(|spec| spec.write_range.contains(spec.written_for(value)));
    written && item.range().contains(value)
}

impl Name {
    /// Whether a write can make the whole parameter hold this value; `Err` says what is allowed.
    ///
    /// # Errors
    /// [`ValueError::Range`] when it cannot.
    pub fn check_whole(&self, value: i64) -> Result<(), ValueError> {
        if may_become(value, self.item) {
            return Ok(());
        }
        let whole = Self::of(self.item);
        Err(ValueError::Range {
            name: whole.to_string(),
            value: value.to_string(),
            allowed: allowed(&whole, ""),
        })
    }
}

fn values(name: &Name) -> &'static [NamedValue] {
    if name.field.is_some() { &[] } else { name.item.values() }
}

/// What may be written, in words.
fn allowed(name: &Name, text: &str) -> String {
    let range = match (name.field, name.item.spec()) {
        (Some(field), _) => match field.extract(-1) {
            1 => "0, 1".to_owned(),
            most => format!("0…{most}"),
        },
        (None, Some(spec)) if spec.values.iter().any(|named| named.write != named.value) => String::new(),
        (None, spec) => spec.map_or_else(|| name.item.range(), |spec| spec.write_range).to_string(),
    };
    let unit = if name.field.is_some() { "" } else { name.item.unit(false) };
    let named = values(name).iter().filter(|named| may_become(named.value, name.item));
    let named: Vec<_> = named.map(|named| named.id).collect();
    let separator = if unit.is_empty() { "" } else { " " };
    let mut sentence = match (range.is_empty(), named.is_empty()) {
        (false, true) => format!("allowed is {range}{separator}{unit}"),
        (false, false) => format!("allowed is {range}{separator}{unit}, or one of {}", named.join(", ")),
        (true, _) => format!("allowed is one of {}", named.join(", ")),
    };
    if let Some(nearest) = suggest::nearest(text, named.iter().copied()) {
        sentence = format!("did you mean `{nearest}`? Otherwise {sentence}");
    }
    sentence
}

/// What a value means, in words: the identifier of a named value, or the bit fields; empty for plain numbers.
#[must_use]
pub fn described(name: &Name, value: i64) -> String {
    if let Some(named) = values(name).iter().find(|named| named.value == value) {
        return named.id.to_owned();
    }
    if name.field.is_some() {
        return String::new();
    }
    let fields = name.item.fields().iter();
    fields.map(|field| format!("{}={}", field.id, field.extract(value))).collect::<Vec<_>>().join(" ")
}

/// A set of values in words, as [`ValueSet`] says it; all of 32 bits is nothing to say.
pub(crate) fn range_in_words(range: ValueSet) -> String {
    let all = [(i64::from(i32::MIN), i64::from(i32::MAX)), (0, i64::from(u32::MAX))];
    match range.intervals {
        [interval] if range.step == 1 && all.contains(interval) => String::new(),
        _ => range.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tmcl_tables::{MODULES, ModuleSpec};

    use super::*;
    use crate::item::items;

    const SPEC: &ModuleSpec = &tmcl_tables::tmcm_1311::SPEC;

    fn value(name: &str, text: &str) -> Result<i64, ValueError> {
        parse_value(text, &Name::parse(name, SPEC).expect("there is one"), false)
    }

    #[test]
    fn numbers_units_and_names() {
        assert_eq!(value("max_velocity", "51_200"), Ok(51_200));
        assert_eq!(value("max_velocity", " 0xC800 pps"), Ok(51_200));
        assert_eq!(value("max_velocity", "0b1_0000"), Ok(16));
        assert_eq!(value("target_position", "-512µstep"), Ok(-512));
        assert_eq!(value("target_position", "-512 ustep"), Ok(-512));
        assert_eq!(value("auto_start", "on"), Ok(1));
        assert_eq!(value("auto_start", "ON"), Ok(1));
        assert_eq!(value("baud_rate", "baud_115200"), Ok(7));
        assert_eq!(value("i2t_limit", "4294967295"), Ok(4_294_967_295));
        assert_eq!(value("encoder_mode.null_active_high", "1"), Ok(1));
        assert_eq!(value("variable.3", "-1"), Ok(-1));
        assert_eq!(value("coordinate.3", "77"), Ok(77));
        assert_eq!(value("output.3", "1"), Ok(1));
    }

    /// What is written to the lock is another number than what is read.
    #[test]
    fn a_lock_takes_its_names_and_both_kinds_of_numbers() {
        for text in ["locked", "1", "1234"] {
            assert_eq!(value("eeprom_lock", text), Ok(1));
        }
        for text in ["unlocked", "0", "4321"] {
            assert_eq!(value("eeprom_lock", text), Ok(0));
        }
        let lock = Name::parse("eeprom_lock", SPEC).expect("it has one").item;
        assert_eq!((lock.to_wire(1), lock.to_wire(0)), (1234, 4321));
    }

    #[test]
    fn in_closed_loop_positions_have_another_unit() {
        let name = Name::parse("actual_position", SPEC).expect("there is one");
        assert_eq!(parse_value("5 encoder step", &name, true), Ok(5));
        assert!(parse_value("5 µstep", &name, true).is_err());
        assert_eq!(parse_value("5 µstep", &name, false), Ok(5));
    }

    #[test]
    fn what_is_wrong_is_said_with_what_is_allowed() {
        let text = [
            ("supply_voltage", "3"),
            ("max_velocity", "-1"),
            ("max_velocity", "400000000"),
            ("max_velocity", "fast"),
            ("max_velocity", "100 rpm"),
            ("max_velocity", "1.5"),
            ("max_velocity", ""),
            ("max_velocity", "1_"),
            ("max_velocity", "0x"),
            ("max_velocity", "12345678901234567890123"),
            ("max_current", "5 mA"),
            ("auto_start", "onn"),
            ("auto_start", "2"),
            ("chopper_off_time", "1"),
            ("encoder_mode", "3"),
            ("encoder_mode.null_active_high", "2"),
            ("eeprom_lock", "7"),
            ("eeprom_lock", "lokced"),
            ("output.3", "2"),
        ]
        .map(|(name, text)| value(name, text).expect_err(text).to_string())
        .join("\n");
        insta::assert_snapshot!(text);
    }

    #[test]
    fn values_in_words() {
        let words = |name: &str, value| described(&Name::parse(name, SPEC).expect("there is one"), value);
        assert_eq!(words("auto_start", 1), "on");
        assert_eq!(words("auto_start", 7), "");
        assert_eq!(
            words("encoder_mode", 20),
            "clear_on_next_null=1 clear_on_every_null=0 null_active_high=1"
        );
        assert_eq!(words("encoder_mode.null_active_high", 1), "");
        assert_eq!(words("max_velocity", 1), "");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// Whatever is taken can be written, and each value that a parameter may be made to hold is taken.
        #[test]
        fn what_is_taken_is_allowed(text in "\\PC{0,12}|-?[0-9]{1,10}|0x[0-9a-f]{1,9}") {
            for item in MODULES.into_iter().flat_map(items) {
                if let Ok(value) = parse_value(&text, &Name::of(item), false) {
                    prop_assert!(may_become(value, item));
                    prop_assert_eq!(parse_value(&value.to_string(), &Name::of(item), false), Ok(value));
                    prop_assert!(item.spec().is_none_or(|spec| spec.allows_write(item.to_wire(value))));
                }
            }
        }
    }
}
