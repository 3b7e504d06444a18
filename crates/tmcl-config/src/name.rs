//! What stands for a parameter.

use std::fmt;

use tmcl_tables::{BitField, ModuleSpec};

use crate::item::{Item, items};
use crate::{suggest, wildcard};

/// A parameter, or some of its bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Name {
    /// The parameter.
    pub item: Item,
    /// The bits, where only some are meant.
    pub field: Option<&'static BitField>,
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.item.name())?;
        self.field.map_or(Ok(()), |field| write!(f, ".{}", field.id))
    }
}

/// Why a name names nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Nothing of that name; and what might have been meant, or what there is.
    #[error("nothing called `{0}`; {1}")]
    Unknown(String, String),
    /// The parameter is there, but not that bit field; and what there is.
    #[error("`{0}` has no bit field `{1}`; {2}")]
    Field(String, String, String),
    /// A pattern that nothing is like.
    #[error("nothing of the {1} is like `{0}`")]
    Pattern(String, &'static str),
}

impl Name {
    /// The parameter as a whole.
    #[must_use]
    pub fn of(item: Item) -> Self {
        Self { item, field: None }
    }

    /// What `text` names on a module: an identifier (`max_velocity`, `timer_0_period`), the number of an axis parameter
    /// (`4`, `axis.4`), bank and number of a global parameter (`0/66`), `variable.3`, `coordinate.2`, a port (`input.0`,
    /// `ain.4`, `output.3`), or one of these that has bit fields, a dot and a field.
    ///
    /// # Errors
    /// [`NameError`] when it names nothing.
    pub fn parse(text: &str, module: &'static ModuleSpec) -> Result<Self, NameError> {
        if let Some(item) = item(text, module) {
            return Ok(Self::of(item));
        }
        if let Some((before, id)) = text.rsplit_once('.')
            && let Some(item) = item(before, module)
        {
            let field = item.fields().iter().find(|field| field.id == id);
            let field = field.ok_or_else(|| no_field(item, id))?;
            return Ok(Self { item, field: Some(field) });
        }
        Err(NameError::Unknown(text.to_owned(), help(text, module)))
    }

    /// The value of the bits that are meant within the parameter's value.
    #[must_use]
    pub fn extract(&self, value: i64) -> i64 {
        self.field.map_or(value, |field| field.extract(value))
    }

    /// The parameter's value once the bits that are meant are `value`.
    #[must_use]
    pub fn insert(&self, before: i64, value: i64) -> i64 {
        match self.field {
            None => value,
            Some(field) => {
                let mask = field.extract(-1) << field.low;
                (before & !mask) | ((value << field.low) & mask)
            }
        }
    }
}

/// The parameters that `texts` name, each once, in this order. A pattern with `*` and `?` stands for every parameter that is
/// like it and of which `usable` holds.
///
/// # Errors
/// [`NameError`] for the first text that names nothing.
pub fn select(
    texts: &[String],
    module: &'static ModuleSpec,
    usable: impl Fn(Item) -> bool,
) -> Result<Vec<Name>, NameError> {
    let mut names: Vec<Name> = Vec::new();
    for text in texts {
        let found = if wildcard::is_pattern(text) {
            let like = items(module).filter(|item| usable(*item) && wildcard::matches(text, &item.name()));
            let found: Vec<_> = like.map(Name::of).collect();
            if found.is_empty() {
                return Err(NameError::Pattern(text.clone(), module.name));
            }
            found
        } else {
            vec![Name::parse(text, module)?]
        };
        for name in found {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    Ok(names)
}

fn item(text: &str, module: &'static ModuleSpec) -> Option<Item> {
    if let Some((bank, number)) = text.split_once('/') {
        return Item::global(module, digits(bank)?, digits(number)?);
    }
    if let Some((prefix, number)) = text.split_once('.') {
        let number = digits(number)?;
        return match prefix {
            "axis" => Item::axis(module, number),
            "variable" => Item::variable(module, number),
            "coordinate" => Item::coordinate(module, number),
            _ => Item::port(module, prefix, number),
        };
    }
    match digits(text) {
        Some(number) => Item::axis(module, number),
        None => Item::by_id(module, text),
    }
}

/// A number without sign or anything else.
fn digits(text: &str) -> Option<u8> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

fn no_field(item: Item, field: &str) -> NameError {
    let fields: Vec<_> = item.fields().iter().map(|field| field.id).collect();
    let help = match (suggest::nearest(field, fields.iter().copied()), fields.is_empty()) {
        (_, true) => "it has none".to_owned(),
        (Some(nearest), _) => format!("did you mean `{}.{nearest}`?", item.name()),
        (None, false) => format!("there are {}", listed(&fields)),
    };
    NameError::Field(item.name(), field.to_owned(), help)
}

/// What there is in place of what there is not.
fn help(text: &str, module: &'static ModuleSpec) -> String {
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let prefix = text.split_once('.').map_or(text, |(prefix, _)| prefix);
    if is_number(text) || prefix == "axis" {
        return format!(
            "the {} has no axis parameter of that number; `tmcl params {}` lists them",
            module.name, module.id
        );
    }
    if text.split_once('/').is_some_and(|(bank, number)| is_number(bank) && is_number(number)) {
        return format!(
            "the {} has no global parameter of that bank and number; `tmcl params {}` lists them",
            module.name, module.id
        );
    }
    if prefix.ends_with("variable") || prefix == "user_variables" {
        return numbered("variable", items(module).filter(|item| item.is_variable()));
    }
    if prefix == "coordinate" {
        return numbered("coordinate", (0..module.coordinates).map(Item::Coordinate));
    }
    if ["input", "ain", "output"].contains(&prefix) {
        let ports = module.ports.iter().map(Item::Port).map(Item::name);
        let ports: Vec<_> = ports.filter(|name| name.split('.').next() == Some(prefix)).collect();
        return format!("there are {}", listed(&ports.iter().map(String::as_str).collect::<Vec<_>>()));
    }
    let ids =
        items(module).filter(|item| !item.is_variable()).filter_map(|item| item.spec().map(|spec| spec.id));
    match suggest::nearest(text, ids) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => format!("`tmcl params {}` lists what there is", module.id),
    }
}

fn numbered(what: &str, mut items: impl Iterator<Item = Item>) -> String {
    match (items.next(), items.last()) {
        (Some(first), Some(last)) => format!("there are `{}` to `{}`", first.name(), last.name()),
        _ => format!("there is no {what}"),
    }
}

fn listed(names: &[&str]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tmcl_tables::MODULES;

    use super::*;

    const SPEC: &ModuleSpec = &tmcl_tables::tmcm_1311::SPEC;

    #[test]
    fn every_item_is_found_by_its_name_and_by_its_number() {
        for module in MODULES {
            for item in items(module) {
                assert_eq!(Name::parse(&item.name(), module), Ok(Name::of(item)));
                assert_eq!(Name::parse(&item.number(), module), Ok(Name::of(item)));
                for field in item.fields() {
                    let name = Name { item, field: Some(field) };
                    assert_eq!(Name::parse(&name.to_string(), module), Ok(name));
                    assert_eq!(Name::parse(&format!("{}.{}", item.number(), field.id), module), Ok(name));
                }
            }
        }
    }

    #[test]
    fn an_axis_parameter_needs_only_its_number() {
        let name = |text| Name::parse(text, SPEC).map(|name| name.to_string());
        assert_eq!(name("4"), Ok("max_velocity".to_owned()));
        assert_eq!(name("0/66"), Ok("serial_address".to_owned()));
        assert_eq!(name("2/3"), Ok("variable.3".to_owned()));
        let chopper = Name::parse("139.toff", &tmcl_tables::tmcm_1076::SPEC).map(|name| name.to_string());
        assert_eq!(chopper, Ok("chopconf.toff".to_owned()));
    }

    #[test]
    fn what_names_nothing_says_what_there_is() {
        let says = |text| Name::parse(text, SPEC).expect_err(text).to_string();
        let text = [
            "max_velocty",
            "21",
            "axis.300",
            "1/0",
            "variable.256",
            "user_variable",
            "coordinate.21",
            "output.8",
            "encoder_mode.clear_on_nul",
            "encoder_mode.x",
            "max_velocity.x",
            "colour",
            "",
            ".",
            "+4",
            "0/+66",
            "4/",
        ]
        .map(says)
        .join("\n");
        insta::assert_snapshot!(text);
    }

    #[test]
    fn patterns_and_names_select_each_parameter_once() {
        let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        let names = |list: &[&str]| -> Vec<String> {
            let found = select(&texts(list), SPEC, |item| item.access().read).expect("they name something");
            found.iter().map(Name::to_string).collect()
        };
        assert_eq!(names(&["max_vel*", "4", "max_velocity"]), ["max_velocity"]);
        assert_eq!(names(&["timer_?_period"]), ["timer_0_period", "timer_1_period", "timer_2_period"]);
        assert_eq!(names(&["variable.*"]).len(), 256);
        // What can only be written is not read by a pattern, but can be named.
        assert_eq!(names(&["clear_i2t_flag"]), ["clear_i2t_flag"]);
        assert!(select(&texts(&["clear_i2t*"]), SPEC, |item| item.access().read).is_err());
        let none = select(&texts(&["max_*", "x*"]), SPEC, |_| true).expect_err("nothing is like x*");
        assert_eq!(none.to_string(), "nothing of the TMCM-1311 is like `x*`");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn any_text_is_a_name_or_an_error(text in "\\PC{0,24}") {
            for module in MODULES {
                let _ = Name::parse(&text, module);
                let _ = select(std::slice::from_ref(&text), module, |_| true);
            }
        }

        /// Other bits stay, and what was put in is read back.
        #[test]
        fn a_field_is_put_in_and_taken_out(before in any::<u32>(), value in 0_i64..16) {
            let name = Name::parse("chopconf.toff", &tmcl_tables::tmcm_1076::SPEC).expect("it has it");
            let after = name.insert(before.into(), value);
            prop_assert_eq!(name.extract(after), value);
            prop_assert_eq!(name.insert(after, name.extract(before.into())), i64::from(before));
        }
    }
}
