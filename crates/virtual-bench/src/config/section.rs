//! Reading a table of a bench file, key by key.

use core::ops::{Range, RangeInclusive};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::ConfigError;
use super::quantity::Quantity;
use super::suggest;

/// A value and where it stands.
pub(super) type Entry<'t> = &'t Spanned<DeValue<'t>>;

/// A table that is being read. It notes the keys it was asked for: [`Section::finish`] complains about the others.
///
/// A reading method returns `None` for a key that is not there and for one that is wrong; the latter it has complained
/// about, so that whoever asks may go on with a default and find what else is wrong.
pub(super) struct Section<'t, 'e> {
    table: &'t DeTable<'t>,
    /// The header, `[module.load]`.
    title: String,
    span: Range<usize>,
    known: Vec<&'static str>,
    errors: &'e mut Vec<ConfigError>,
}

impl<'t, 'e> Section<'t, 'e> {
    pub(super) fn new(
        table: &'t DeTable<'t>,
        title: impl Into<String>,
        span: Range<usize>,
        errors: &'e mut Vec<ConfigError>,
    ) -> Self {
        Self { table, title: title.into(), span, known: Vec::new(), errors }
    }

    /// What messages call this section.
    pub(super) fn title(&self) -> &str {
        &self.title
    }

    /// Complains.
    pub(super) fn complain(&mut self, error: ConfigError) {
        self.errors.push(error);
    }

    /// Complains about the section as a whole.
    pub(super) fn complain_here(&mut self, message: impl Into<String>, help: Option<String>) {
        let error = ConfigError::new(self.span.clone(), message);
        self.errors.push(ConfigError { help, ..error });
    }

    /// A key's value, whatever it is.
    pub(super) fn entry(&mut self, key: &'static str) -> Option<Entry<'t>> {
        self.known.push(key);
        self.table.get(key)
    }

    /// Where a key stands, if it does.
    pub(super) fn key_span(&self, key: &str) -> Option<Range<usize>> {
        self.table.get_key_value(key).map(|(key, _)| key.span())
    }

    /// A physical quantity.
    pub(super) fn number(&mut self, key: &'static str, quantity: &Quantity) -> Option<f64> {
        let entry = self.entry(key)?;
        let checked = number(key, entry).and_then(|value| {
            quantity.check(key, value).map_err(|message| ConfigError::new(entry.span(), message))
        });
        self.kept(checked)
    }

    /// A whole number.
    pub(super) fn integer(&mut self, key: &'static str, allowed: &RangeInclusive<i64>) -> Option<i64> {
        let entry = self.entry(key)?;
        let checked = integer(key, entry, allowed);
        self.kept(checked)
    }

    /// `true` or `false`.
    pub(super) fn boolean(&mut self, key: &'static str) -> Option<bool> {
        let entry = self.entry(key)?;
        let value = entry.get_ref().as_bool().ok_or_else(|| wrong_type(key, "true or false", entry));
        self.kept(value)
    }

    /// A text.
    pub(super) fn text(&mut self, key: &'static str) -> Option<(&'t str, Range<usize>)> {
        let entry = self.entry(key)?;
        let value = entry.get_ref().as_str().ok_or_else(|| wrong_type(key, "text in quotes", entry));
        self.kept(value).map(|text| (text, entry.span()))
    }

    /// One of a few words.
    pub(super) fn choice<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)]) -> Option<T> {
        let (word, span) = self.text(key)?;
        let found = choices.iter().find(|(choice, _)| *choice == word).map(|(_, value)| *value);
        if found.is_none() {
            let words: Vec<&str> = choices.iter().map(|(choice, _)| *choice).collect();
            let error = ConfigError::new(span, format!("{key} cannot be \"{word}\""));
            self.complain(error.with_help(suggest::help(word, &words)));
        }
        found
    }

    /// A section within this one, `name` with its full path.
    pub(super) fn section(&mut self, key: &'static str, name: &str) -> Option<Section<'t, '_>> {
        let entry = self.entry(key)?;
        let span = self.key_span(key).unwrap_or_else(|| entry.span());
        match entry.get_ref() {
            DeValue::Table(table) => Some(Section::new(table, format!("[{name}]"), span, self.errors)),
            _ => {
                let error = wrong_type(key, &format!("a section, [{name}]"), entry);
                self.complain(error);
                None
            }
        }
    }

    /// The sections under a `[[key]]` header, in their order.
    pub(super) fn sections(&mut self, key: &'static str) -> Vec<Table<'t>> {
        let Some(entry) = self.entry(key) else { return Vec::new() };
        let DeValue::Array(array) = entry.get_ref() else {
            let span = self.key_span(key).unwrap_or_else(|| entry.span());
            let error =
                ConfigError::new(span, format!("{key} sections are written [[{key}]], in double brackets"));
            self.complain(error);
            return Vec::new();
        };
        let mut tables = Vec::new();
        for entry in array {
            match entry.get_ref() {
                DeValue::Table(table) => tables.push(Table { table, span: entry.span() }),
                _ => {
                    let error = wrong_type(key, &format!("a list of sections, [[{key}]]"), entry);
                    self.complain(error);
                }
            }
        }
        tables
    }

    /// Where the list of errors is, for those who read a [`Table`].
    pub(super) fn errors(&mut self) -> &mut Vec<ConfigError> {
        self.errors
    }

    /// Complains about every key nobody asked for.
    pub(super) fn finish(mut self) {
        self.known.sort_unstable();
        self.known.dedup();
        for (key, _) in self.table {
            let name: &str = key.get_ref();
            if !self.known.contains(&name) {
                let error = ConfigError::new(key.span(), format!("unknown key \"{name}\" in {}", self.title));
                self.errors.push(error.with_help(suggest::help(name, &self.known)));
            }
        }
    }

    fn kept<T>(&mut self, checked: Result<T, ConfigError>) -> Option<T> {
        checked.map_err(|error| self.errors.push(error)).ok()
    }
}

/// A table in a list of them.
pub(super) struct Table<'t> {
    pub(super) table: &'t DeTable<'t>,
    pub(super) span: Range<usize>,
}

/// A number, whole or not; not yet known to be finite.
pub(super) fn number(name: &str, entry: Entry<'_>) -> Result<f64, ConfigError> {
    let value = match entry.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(whole) => {
            i64::from_str_radix(whole.as_str(), whole.radix()).ok().map(|whole| whole as f64)
        }
        _ => None,
    };
    value.ok_or_else(|| wrong_type(name, "a number", entry))
}

/// A whole number within bounds.
pub(super) fn integer(
    name: &str,
    entry: Entry<'_>,
    allowed: &RangeInclusive<i64>,
) -> Result<i64, ConfigError> {
    let (value, written) = match entry.get_ref() {
        DeValue::Integer(whole) => {
            (i64::from_str_radix(whole.as_str(), whole.radix()).ok(), whole.to_string())
        }
        DeValue::Float(float) => (None, float.to_string()),
        _ => return Err(wrong_type(name, "a whole number", entry)),
    };
    value.filter(|value| allowed.contains(value)).ok_or_else(|| {
        let (low, high) = (allowed.start(), allowed.end());
        let message = format!("{name} must be a whole number from {low} to {high}, not {written}");
        ConfigError::new(entry.span(), message)
    })
}

/// A complaint about a value of the wrong type.
pub(super) fn wrong_type(name: &str, wanted: &str, entry: Entry<'_>) -> ConfigError {
    let found = match entry.get_ref() {
        DeValue::String(_) => "text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a section",
    };
    ConfigError::new(entry.span(), format!("{name} must be {wanted}, not {found}"))
}
