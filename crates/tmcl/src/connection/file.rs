//! `tmcl.toml`: settings that are the same every day.
//!
//! ```toml
//! [connection]
//! port = "/dev/ttyACM0"
//! timeout = "500ms"
//! ```

use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};
use virtual_bench::config::ConfigError;

use super::place::{self, VIRTUAL};
use super::{ConnectionOptions, values};
use crate::exit::{Code, Failure};

/// What the file is called.
const NAME: &str = "tmcl.toml";

/// The one table there is.
const TABLE: &str = "connection";

const KEYS: &str = "port, baud, address, host_address, timeout, retries";

type Value<'t> = Spanned<DeValue<'t>>;

/// The file that is nearest: in `folder`, or in one above it.
pub(super) fn find(folder: &Path) -> Option<PathBuf> {
    folder.ancestors().map(|folder| folder.join(NAME)).find(|path| path.is_file())
}

/// What the file says. A bench file that it names is looked for beside it.
pub(super) fn read(path: &Path) -> Result<ConnectionOptions, Failure> {
    let name = path.display().to_string();
    let usage = |message: String| Failure::new(Code::Usage, message);
    let text =
        std::fs::read_to_string(path).map_err(|error| usage(format!("cannot read {name}: {error}")))?;
    let mut options =
        parse(&text).map_err(|error| usage(error.report(&name, &text).trim_end().to_owned()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    options.port = options.port.map(|port| beside(folder, port));
    Ok(options)
}

/// `virtual:bench.toml` with the folder of the file that says so.
fn beside(folder: &Path, port: String) -> String {
    match port.strip_prefix(VIRTUAL) {
        Some(bench) if place::is_bench(bench) => format!("{VIRTUAL}{}", folder.join(bench).display()),
        _ => port,
    }
}

/// The first thing that is wrong is the error.
fn parse(text: &str) -> Result<ConnectionOptions, ConfigError> {
    let table = DeTable::parse(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        complaint(
            span.start.min(text.len())..span.end.min(text.len()),
            format!("not TOML: {}", error.message()),
            "",
        )
    })?;
    let mut options = ConnectionOptions::default();
    for (key, value) in table.get_ref() {
        match (key.get_ref().as_ref(), value.get_ref()) {
            (TABLE, DeValue::Table(connection)) => {
                for (key, value) in connection {
                    set(&mut options, key, value)?;
                }
            }
            (TABLE, _) => {
                let message = format!("`{TABLE}` is a table here");
                return Err(complaint(key.span(), message, &format!("write [{TABLE}]")));
            }
            (other, _) => {
                let help = format!("there is the table [{TABLE}], with {KEYS}");
                return Err(complaint(key.span(), format!("unknown key `{other}`"), &help));
            }
        }
    }
    Ok(options)
}

/// Takes one key in; `host-address`, as the command line writes it, is `host_address` too.
fn set(
    options: &mut ConnectionOptions,
    key: &Spanned<std::borrow::Cow<'_, str>>,
    value: &Value<'_>,
) -> Result<(), ConfigError> {
    match key.get_ref().as_ref() {
        "port" => options.port = Some(checked(value, |text| Ok(text.to_owned()))?),
        "baud" => options.baud = Some(checked(value, values::baud_rates)?),
        "address" => options.address = Some(checked(value, values::address)?),
        "host_address" | "host-address" => options.host_address = Some(checked(value, values::address)?),
        "timeout" => options.timeout = Some(checked(value, values::timeout)?),
        "retries" => options.retries = Some(checked(value, values::retries)?),
        other => {
            let help = format!("[{TABLE}] takes {KEYS}");
            return Err(complaint(key.span(), format!("unknown key `{other}`"), &help));
        }
    }
    Ok(())
}

/// A text or a whole number, as the command line would take it.
fn checked<T>(value: &Value<'_>, parse: impl Fn(&str) -> Result<T, String>) -> Result<T, ConfigError> {
    let text = match value.get_ref() {
        DeValue::String(text) => text.to_string(),
        DeValue::Integer(number) => number.to_string(),
        _ => return Err(complaint(value.span(), "a text or a whole number is expected".to_owned(), "")),
    };
    parse(&text).map_err(|message| complaint(value.span(), message, ""))
}

fn complaint(span: std::ops::Range<usize>, message: String, help: &str) -> ConfigError {
    ConfigError { message, span, help: (!help.is_empty()).then(|| help.to_owned()) }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn all_keys() {
        let text = "[connection]\nport = \"/dev/ttyUSB0\"\nbaud = 115200\naddress = 5\nhost_address = 6\n\
                    timeout = \"250ms\"\nretries = 0\n";
        let expected = ConnectionOptions {
            port: Some("/dev/ttyUSB0".to_owned()),
            baud: values::baud_rates("115200").ok(),
            address: Some(5),
            host_address: Some(6),
            timeout: Some(Duration::from_millis(250)),
            retries: Some(0),
        };
        assert_eq!(parse(text), Ok(expected));
        assert_eq!(parse(""), Ok(ConnectionOptions::default()));
    }

    #[test]
    fn errors_name_the_line() {
        let error = |text: &str| parse(text).expect_err("something is wrong").report("tmcl.toml", text);
        let texts = [
            "[connection]\nprot = \"COM3\"\n",
            "port = \"COM3\"\n",
            "connection = 3\n",
            "[connection]\ntimeout = 5\n",
            "[connection]\naddress = 2048\n",
            "[connection]\nretries = [1]\n",
            "[connection\n",
        ];
        insta::assert_snapshot!(texts.map(error).join("\n"));
    }

    #[test]
    fn a_bench_stands_beside_the_file() {
        let beside = |port: &str| beside(Path::new("/home/me/axis"), port.to_owned());
        assert_eq!(beside("virtual:lift.toml"), "virtual:/home/me/axis/lift.toml");
        assert_eq!(beside("virtual:lift.toml#m2"), "virtual:/home/me/axis/lift.toml#m2");
        assert_eq!(beside("virtual:/lift.toml"), "virtual:/lift.toml");
        assert_eq!(beside("virtual:tmcm-1311"), "virtual:tmcm-1311");
        assert_eq!(beside("./ttyTMCL"), "./ttyTMCL");
    }

    proptest::proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "(\\[connection\\]\n)?([a-z_\\[\\]\"= 0-9\n]|\\PC){0,60}") {
            if let Err(error) = parse(&text) {
                proptest::prop_assert!(!error.report("tmcl.toml", &text).is_empty());
            }
        }
    }
}
