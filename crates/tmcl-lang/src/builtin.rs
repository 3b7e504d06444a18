//! The include files that come along, made from the tables (decision §4).
//!
//! The vendor's files of these names are not ours to ship. Ours define the names that the manuals use, and one for every
//! parameter.

use std::collections::BTreeMap;
use std::fmt::Write;

use tmcl_tables::{ModuleSpec, ParameterSpec};

use crate::instruction::ALL;

/// Their names; they are the same in any case.
pub const BUILTIN_INCLUDES: [&str; 2] = ["TMCLParam.tmc", "Interrupts.inc"];

/// The built-in include file of that name for a module.
#[must_use]
pub fn builtin_include(name: &str, module: &ModuleSpec) -> Option<String> {
    let known = BUILTIN_INCLUDES.iter().find(|known| known.eq_ignore_ascii_case(name))?;
    let definitions = definitions(known, module);
    let mut text =
        format!("// {known} for the {}: made by OpenTMCL from its tables of the module.\n\n", module.name);
    let width = definitions.iter().map(|definition| definition.name.len()).max().unwrap_or(0);
    for Definition { name, value, comment } in definitions {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:width$} = {value:<3} // {comment}");
    }
    Some(text)
}

/// A name that a built-in file defines.
#[derive(Clone, Debug)]
pub(crate) struct BuiltinName {
    pub(crate) name: String,
    pub(crate) file: &'static str,
}

/// Every name that the built-in files define, by the name in lower case.
pub(crate) fn builtin_names(module: &ModuleSpec) -> BTreeMap<String, BuiltinName> {
    let named = |file| move |Definition { name, .. }| (name.to_lowercase(), BuiltinName { name, file });
    let files = BUILTIN_INCLUDES.into_iter();
    files.flat_map(|file| definitions(file, module).into_iter().map(named(file))).collect()
}

struct Definition {
    name: String,
    value: u8,
    comment: String,
}

fn definitions(file: &str, module: &ModuleSpec) -> Vec<Definition> {
    if file == BUILTIN_INCLUDES[0] { parameters(module) } else { interrupts(module) }
}

/// `Motor0`, and every axis parameter and every global parameter of the banks 0 and 3 by its identifier and by the manual's
/// name for it. The user variables of bank 2 have no names.
fn parameters(module: &ModuleSpec) -> Vec<Definition> {
    const NAMED_BANKS: [u8; 2] = [0, 3];
    let axis = module.axis_parameters.iter().map(|parameter| ("AP", None, parameter));
    let named = module.global_parameters.iter().filter(|entry| NAMED_BANKS.contains(&entry.bank));
    let global = named.map(|entry| ("GP", Some(entry.bank), &entry.parameter));
    let all: Vec<_> = axis.chain(global).collect();

    // Identifiers go first: a manual's name that means something else elsewhere is left out.
    let mut taken: BTreeMap<String, u8> = BTreeMap::new();
    for (prefix, _, parameter) in &all {
        taken
            .entry(format!("{prefix}{}", camel_case(parameter.id)).to_lowercase())
            .or_insert(parameter.number);
    }
    let mut definitions =
        vec![Definition { name: "Motor0".to_owned(), value: 0, comment: "the only motor".to_owned() }];
    for (prefix, bank, parameter) in all {
        let define = |name| Definition { name, value: parameter.number, comment: comment(bank, parameter) };
        definitions.push(define(format!("{prefix}{}", camel_case(parameter.id))));
        let alias = format!("{prefix}{}", manual_name(parameter.name));
        if let std::collections::btree_map::Entry::Vacant(free) = taken.entry(alias.to_lowercase()) {
            free.insert(parameter.number);
            definitions.push(define(alias));
        }
    }
    definitions
}

fn comment(bank: Option<u8>, parameter: &ParameterSpec) -> String {
    let bank = bank.map_or_else(String::new, |bank| format!("bank {bank}: "));
    let unit = if parameter.unit.is_empty() { String::new() } else { format!(", {}", parameter.unit) };
    format!("{bank}{}{unit}", parameter.name)
}

fn interrupts(module: &ModuleSpec) -> Vec<Definition> {
    let each = module.interrupts.iter().map(|interrupt| Definition {
        name: interrupt.symbol.to_owned(),
        value: interrupt.number,
        comment: interrupt.name.to_owned(),
    });
    let all = Definition {
        name: "TI_GLOBAL".to_owned(),
        value: ALL,
        comment: "all interrupts, in EI and DI".to_owned(),
    };
    each.chain([all]).collect()
}

/// The manual's name as an identifier: "Maximum positioning speed" is `MaxPositioningSpeed`. What is in parentheses is left
/// out.
fn manual_name(name: &str) -> String {
    let mut depth = 0_u32;
    let outside = name.chars().filter(|letter| {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => return depth == 0,
        }
        false
    });
    let outside: String = outside.map(|letter| if letter == '²' { '2' } else { letter }).collect();
    camel_case(&outside)
}

/// The words of a text, each with a capital; Maximum and Minimum are shortened, as the manuals do.
fn camel_case(text: &str) -> String {
    let words = text.split(|letter: char| !letter.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words
        .map(|word| match word.to_ascii_lowercase().as_str() {
            "maximum" => "Max".to_owned(),
            "minimum" => "Min".to_owned(),
            _ => capitalised(word),
        })
        .collect()
}

fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_manuals() {
        assert_eq!(manual_name("Maximum positioning speed"), "MaxPositioningSpeed");
        assert_eq!(manual_name("Absolute max. current (CS / Current Scale)"), "AbsoluteMaxCurrent");
        assert_eq!(manual_name("I²t limit"), "I2tLimit");
        assert_eq!(manual_name("Start/Stop velocity"), "StartStopVelocity");
        assert_eq!(manual_name("smartEnergy current minimum (SEIMIN)"), "SmartEnergyCurrentMin");
        assert_eq!(camel_case("max_velocity"), "MaxVelocity");
    }
}
