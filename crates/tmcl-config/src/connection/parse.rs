//! `tmcl.toml`: settings that are the same every day.
//!
//! ```toml
//! [connection]
//! port = "/dev/ttyACM0"
//! timeout = "500ms"
//! ```

use std::borrow::Cow;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{ConnectionSettings, values};
use crate::finding::Finding;

/// The one table there is.
const TABLE: &str = "connection";

const KEYS: [&str; 6] = ["port", "baud", "address", "host_address", "timeout", "retries"];

type Value<'t> = Spanned<DeValue<'t>>;

/// Reads the text of a `tmcl.toml`.
///
/// # Errors
/// The first thing that is wrong with it: no TOML, tables and keys that nobody knows, values that a setting does not take.
pub fn parse(text: &str) -> Result<ConnectionSettings, Finding> {
    let table = DeTable::parse(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        let end = span.end.min(text.len());
        Finding::new(span.start.min(end)..end, format!("not TOML: {}", error.message()))
    })?;
    let mut settings = ConnectionSettings::default();
    for (key, value) in table.get_ref() {
        match (key.get_ref().as_ref(), value.get_ref()) {
            (TABLE, DeValue::Table(connection)) => {
                for (key, value) in connection {
                    set(&mut settings, key, value)?;
                }
            }
            (TABLE, _) => {
                let finding = Finding::new(key.span(), format!("`{TABLE}` is a table here"));
                return Err(finding.with_help(format!("write [{TABLE}]")));
            }
            (other, _) => {
                let help = format!("there is the table [{TABLE}], with {}", KEYS.join(", "));
                return Err(Finding::new(key.span(), format!("unknown key `{other}`")).with_help(help));
            }
        }
    }
    Ok(settings)
}

/// Takes one key in; `host-address`, as the command line writes it, is `host_address` too.
fn set(
    settings: &mut ConnectionSettings,
    key: &Spanned<Cow<'_, str>>,
    value: &Value<'_>,
) -> Result<(), Finding> {
    match key.get_ref().as_ref() {
        "port" => settings.port = Some(checked(value, |text| Ok(text.to_owned()))?),
        "baud" => settings.baud = Some(checked(value, values::baud_rates)?),
        "address" => settings.address = Some(checked(value, values::address)?),
        "host_address" | "host-address" => settings.host_address = Some(checked(value, values::address)?),
        "timeout" => settings.timeout = Some(checked(value, values::timeout)?),
        "retries" => settings.retries = Some(checked(value, values::retries)?),
        other => {
            let help = format!("[{TABLE}] takes {}", KEYS.join(", "));
            return Err(Finding::new(key.span(), format!("unknown key `{other}`")).with_help(help));
        }
    }
    Ok(())
}

/// A text or a whole number, as the command line would take it.
fn checked<T>(value: &Value<'_>, parse: impl Fn(&str) -> Result<T, String>) -> Result<T, Finding> {
    let text = match value.get_ref() {
        DeValue::String(text) => text.to_string(),
        DeValue::Integer(number) => number.to_string(),
        _ => return Err(Finding::new(value.span(), "a text or a whole number is expected")),
    };
    parse(&text).map_err(|message| Finding::new(value.span(), message))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn all_keys() {
        let text = "[connection]\nport = \"/dev/ttyUSB0\"\nbaud = 115200\naddress = 5\nhost_address = 6\n\
                    timeout = \"250ms\"\nretries = 0\n";
        let expected = ConnectionSettings {
            port: Some("/dev/ttyUSB0".to_owned()),
            baud: values::baud_rates("115200").ok(),
            address: Some(5),
            host_address: Some(6),
            timeout: Some(Duration::from_millis(250)),
            retries: Some(0),
        };
        assert_eq!(parse(text), Ok(expected));
        assert_eq!(parse(""), Ok(ConnectionSettings::default()));
    }

    #[test]
    fn a_finding_has_its_place() {
        let place = |text: &'static str| text.get(parse(text).expect_err("something is wrong").span);
        assert_eq!(place("[connection]\nprot = \"COM3\"\n"), Some("prot"));
        assert_eq!(place("port = \"COM3\"\n"), Some("port"));
        assert_eq!(place("connection = 3\n"), Some("connection"));
        assert_eq!(place("[connection]\ntimeout = 5\n"), Some("5"));
        assert_eq!(place("[connection]\naddress = 0x800\n"), Some("0x800"));
        assert_eq!(place("[connection]\nretries = [1]\n"), Some("[1]"));
    }

    proptest::proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "(\\[connection\\]\n)?([a-z_\\[\\]\"= 0-9\n]|\\PC){0,60}") {
            if let Err(finding) = parse(&text) {
                proptest::prop_assert!(text.get(finding.span).is_some());
            }
        }
    }
}
