//! What may stand where the cursor is.

use rustyline::completion::{Completer, Pair};
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::validate::Validator;
use rustyline::{Context, Result};
use tmcl_config::{Item, Name, items};
use tmcl_lang::{BUILTIN_INCLUDES, builtin_include};
use tmcl_tables::{BitField, CommandSpec, ModuleSpec, MotorField, Operand, TypeField, ValueField};

use super::line::WORDS;

/// Completes for one module.
pub(super) struct Helper {
    module: &'static ModuleSpec,
    /// The names that the built-in include files define, with their numbers.
    names: Vec<(String, u8)>,
}

/// What is put in, and what is shown for it.
type Candidate = (String, String);

impl Helper {
    pub(super) fn of(module: &'static ModuleSpec) -> Self {
        let files = BUILTIN_INCLUDES.iter().filter_map(|name| builtin_include(name, module));
        let names = files.flat_map(|text| text.lines().filter_map(definition).collect::<Vec<_>>()).collect();
        Self { module, names }
    }

    /// Where the word before the end of `line` begins, and what it may become.
    fn candidates(&self, line: &str) -> (usize, Vec<Candidate>) {
        let trimmed = line.trim_start();
        let Some((word, rest)) = trimmed.split_once(char::is_whitespace) else {
            return (line.len() - trimmed.len(), beginning_with(trimmed, self.first_words()));
        };
        let start = |typed: &str| line.len() - typed.len();
        match word.to_ascii_lowercase().as_str() {
            "get" => {
                let typed = last_of(rest, |letter| letter == ' ' || letter == ',');
                (start(typed), beginning_with(typed, self.parameters(typed, |it| it.access().read, "")))
            }
            "set" => {
                let typed = last_of(rest, |letter| letter == ' ');
                match typed.split_once('=') {
                    None => (
                        start(typed),
                        beginning_with(typed, self.parameters(typed, |it| it.access().write, "=")),
                    ),
                    Some((name, value)) => (start(value), beginning_with(value, self.values_of(name))),
                }
            }
            "help" => {
                let typed = rest.trim_start();
                let all = self.first_words().chain(self.parameters(typed, |_| true, ""));
                (start(typed), beginning_with(typed, all))
            }
            _ => {
                let operands: Vec<&str> = rest.split(',').map(str::trim_start).collect();
                let typed = operands.last().copied().unwrap_or_default();
                (start(typed), beginning_with(typed, self.operands(word, &operands).into_iter()))
            }
        }
    }

    fn first_words(&self) -> impl Iterator<Item = Candidate> {
        let direct =
            self.module.commands.iter().filter(|entry| entry.modes.direct && !entry.spec.mnemonic.is_empty());
        let mnemonics = direct.map(|entry| entry.spec.mnemonic);
        let words = WORDS.iter().filter_map(|(word, _)| word.split(' ').next());
        mnemonics.chain(words).map(|word| (format!("{word} "), word.to_owned()))
    }

    /// Names, and where one is written whole, those of its bits.
    fn parameters(
        &self,
        typed: &str,
        wanted: impl Fn(Item) -> bool,
        after: &str,
    ) -> impl Iterator<Item = Candidate> {
        let names = items(self.module).filter(move |item| wanted(*item)).flat_map(|item| {
            let name = item.name();
            let field = |field: &BitField| format!("{name}.{}", field.id);
            let fields: Vec<String> =
                if typed.starts_with(&name) { item.fields().iter().map(field).collect() } else { Vec::new() };
            std::iter::once(name.clone()).chain(fields).collect::<Vec<_>>()
        });
        names.map(move |name| (format!("{name}{after}"), name))
    }

    fn values_of(&self, name: &str) -> impl Iterator<Item = Candidate> + use<> {
        let values = Name::parse(name, self.module).map_or(&[][..], |name| name.item.values());
        values.iter().map(|named| (named.id.to_owned(), format!("{} ({})", named.id, named.name)))
    }

    /// What the last of these operands may be.
    fn operands(&self, mnemonic: &str, operands: &[&str]) -> Vec<Candidate> {
        let entry =
            self.module.commands.iter().find(|entry| entry.spec.mnemonic.eq_ignore_ascii_case(mnemonic));
        let Some(entry) = entry else { return Vec::new() };
        let spec = entry.spec;
        let index = operands.len() - 1;
        let after = if index + 1 < spec.operands.len() { ", " } else { "" };
        match spec.operands.get(index) {
            Some(Operand::Type) => match spec.type_field {
                TypeField::Named => {
                    let keywords = entry.named_types().filter(|named| !named.keyword.is_empty());
                    keywords
                        .map(|named| {
                            (
                                format!("{}{after}", named.keyword),
                                format!("{} ({})", named.keyword, named.name),
                            )
                        })
                        .collect()
                }
                TypeField::AxisParameter => self.defined("AP", after),
                TypeField::GlobalParameter => self.defined("GP", after),
                TypeField::Interrupt => self.defined("TI_", after),
                TypeField::Port => {
                    let ports = self.module.ports.iter();
                    ports
                        .map(|port| (port.number.to_string(), format!("{} ({})", port.number, port.name)))
                        .collect()
                }
                TypeField::Unused | TypeField::Coordinate => Vec::new(),
            },
            Some(Operand::Motor) if spec.motor_field == MotorField::Motor => {
                vec![(format!("0{after}"), "0".to_owned()), (format!("Motor0{after}"), "Motor0".to_owned())]
            }
            Some(Operand::Value) if spec.value_field == ValueField::ParameterValue => {
                self.values(spec, operands)
            }
            _ => Vec::new(),
        }
    }

    fn defined(&self, beginning: &str, after: &str) -> Vec<Candidate> {
        let names = self.names.iter().filter(|(name, _)| name.starts_with(beginning));
        names.map(|(name, _)| (format!("{name}{after}"), name.clone())).collect()
    }

    /// The values with names of the parameter that the operands before are about.
    fn values(&self, spec: &CommandSpec, operands: &[&str]) -> Vec<Candidate> {
        let number = |index: usize| operands.get(index).and_then(|text| self.number(text.trim_end()));
        let parameter = match spec.type_field {
            TypeField::AxisParameter => number(0).and_then(|number| self.module.axis_parameter(number)),
            TypeField::GlobalParameter => number(0).zip(number(1)).and_then(|(number, bank)| {
                self.module.global_parameter(bank, number).map(|entry| &entry.parameter)
            }),
            _ => None,
        };
        let values = parameter.map_or(&[][..], |parameter| parameter.values);
        values
            .iter()
            .map(|named| (named.value.to_string(), format!("{} ({})", named.value, named.name)))
            .collect()
    }

    fn number(&self, text: &str) -> Option<u8> {
        let named =
            || self.names.iter().find(|(name, _)| name.eq_ignore_ascii_case(text)).map(|(_, number)| *number);
        text.parse().ok().or_else(named)
    }
}

/// `NAME = 5 // what it is`.
fn definition(line: &str) -> Option<(String, u8)> {
    let (name, rest) = line.split_once('=')?;
    let value = rest.split("//").next()?;
    Some((name.trim().to_owned(), value.trim().parse().ok()?))
}

fn last_of(text: &str, separates: impl Fn(char) -> bool) -> &str {
    text.rsplit(separates).next().unwrap_or_default()
}

fn beginning_with(typed: &str, candidates: impl Iterator<Item = Candidate>) -> Vec<Candidate> {
    let begins = |text: &str| text.get(..typed.len()).is_some_and(|head| head.eq_ignore_ascii_case(typed));
    candidates.filter(|(put, _)| begins(put)).collect()
}

impl Completer for Helper {
    type Candidate = Pair;

    fn complete(&self, line: &str, position: usize, _: &Context<'_>) -> Result<(usize, Vec<Pair>)> {
        let (start, candidates) = self.candidates(line.get(..position).unwrap_or(line));
        let pair = |(replacement, display)| Pair { display, replacement };
        Ok((start, candidates.into_iter().map(pair).collect()))
    }
}

impl Hinter for Helper {
    type Hint = String;
}

impl Highlighter for Helper {}

impl Validator for Helper {}

impl rustyline::Helper for Helper {}

#[cfg(test)]
mod tests {
    use tmcl_tables::tmcm_1311;

    use super::*;

    fn completed(line: &str) -> Vec<String> {
        let (start, candidates) = Helper::of(&tmcm_1311::SPEC).candidates(line);
        candidates.into_iter().map(|(put, _)| format!("{}{put}", &line[..start])).collect()
    }

    #[test]
    fn commands_and_words() {
        assert_eq!(completed("MV"), ["MVP "]);
        assert_eq!(completed("ge"), ["get "]);
        assert_eq!(completed("  qui"), ["  quit "]);
        assert!(completed("J").is_empty(), "a host cannot jump");
    }

    #[test]
    fn keywords_parameters_and_values() {
        assert_eq!(completed("MVP "), ["MVP ABS, ", "MVP REL, ", "MVP COORD, "]);
        assert_eq!(completed("mvp r"), ["mvp REL, "]);
        assert_eq!(completed("GAP apactualp"), ["GAP APActualPosition, "]);
        assert_eq!(completed("SAP APMicrostepResolution, 0, 8"), ["SAP APMicrostepResolution, 0, 8"]);
        assert_eq!(completed("SAP 140, Mot"), ["SAP 140, Motor0, "]);
        assert_eq!(completed("SGP 65, 0, 1").len(), 3, "1, 10 and 11");
        assert!(completed("GAP 1, 0, ").is_empty() && completed("XYZ 1").is_empty());
    }

    #[test]
    fn named_parameters() {
        assert_eq!(completed("get actual_pos"), ["get actual_position"]);
        assert_eq!(completed("set actual_pos"), ["set actual_position="]);
        assert_eq!(completed("get actual_position, target_pos"), ["get actual_position, target_position"]);
        assert_eq!(completed("set baud_rate=baud_11"), ["set baud_rate=baud_115200"]);
        assert_eq!(completed("help mst"), ["help MST "]);
        assert_eq!(
            completed("get variable.25"),
            [
                "get variable.25",
                "get variable.250",
                "get variable.251",
                "get variable.252",
                "get variable.253",
                "get variable.254",
                "get variable.255",
            ]
        );
        assert_eq!(completed("set encoder_mode.null_active"), ["set encoder_mode.null_active_high="]);
    }

    proptest::proptest! {
        #[test]
        fn any_line_is_completed(line in "(get |set |GAP |SGP 65, )?\\PC{0,20}") {
            static HELPER: std::sync::LazyLock<Helper> = std::sync::LazyLock::new(|| Helper::of(&tmcm_1311::SPEC));
            let (start, _) = HELPER.candidates(&line);
            proptest::prop_assert!(line.is_char_boundary(start));
        }
    }
}
