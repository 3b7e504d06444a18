//! `TMCL_PORT` and its neighbours.

use std::ffi::OsString;

use tmcl_config::connection;

use super::ConnectionOptions;
use crate::exit::{Code, Failure};

/// What the environment says; `variable` looks up one. A variable that is empty says nothing.
pub(super) fn read(variable: impl Fn(&str) -> Option<OsString>) -> Result<ConnectionOptions, Failure> {
    let text = |name: &str| match variable(name).map(OsString::into_string) {
        None => Ok(None),
        Some(Ok(text)) => Ok(Some(text).filter(|text| !text.is_empty())),
        Some(Err(_)) => Err(complaint(name, "it is no text")),
    };
    Ok(ConnectionOptions {
        port: text("TMCL_PORT")?,
        baud: parsed("TMCL_BAUD", text("TMCL_BAUD")?, connection::baud_rates)?,
        address: parsed("TMCL_ADDRESS", text("TMCL_ADDRESS")?, connection::address)?,
        host_address: parsed("TMCL_HOST_ADDRESS", text("TMCL_HOST_ADDRESS")?, connection::address)?,
        timeout: parsed("TMCL_TIMEOUT", text("TMCL_TIMEOUT")?, connection::timeout)?,
        retries: parsed("TMCL_RETRIES", text("TMCL_RETRIES")?, connection::retries)?,
    })
}

fn parsed<T>(
    name: &str,
    text: Option<String>,
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<Option<T>, Failure> {
    let parse =
        |text: String| parse(&text).map_err(|message| complaint(name, &format!("`{text}`: {message}")));
    text.map(parse).transpose()
}

fn complaint(name: &str, what: &str) -> Failure {
    Failure::new(Code::Usage, format!("in the environment variable {name}: {what}"))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn environment(pairs: &[(&str, &str)]) -> Result<ConnectionOptions, Failure> {
        read(|name| pairs.iter().find(|(key, _)| *key == name).map(|(_, value)| OsString::from(value)))
    }

    #[test]
    fn every_setting_has_its_variable() {
        let pairs = [
            ("TMCL_PORT", "/dev/ttyACM0"),
            ("TMCL_BAUD", "115200"),
            ("TMCL_ADDRESS", "3"),
            ("TMCL_HOST_ADDRESS", "4"),
            ("TMCL_TIMEOUT", "250ms"),
            ("TMCL_RETRIES", "0"),
        ];
        let expected = ConnectionOptions {
            port: Some("/dev/ttyACM0".to_owned()),
            baud: connection::baud_rates("115200").ok(),
            address: Some(3),
            host_address: Some(4),
            timeout: Some(Duration::from_millis(250)),
            retries: Some(0),
        };
        assert_eq!(environment(&pairs).expect("it is in order"), expected);
        assert_eq!(environment(&[("TMCL_PORT", "")]).expect("it is in order"), ConnectionOptions::default());
    }

    #[test]
    fn what_is_wrong_is_named() {
        let failure = environment(&[("TMCL_TIMEOUT", "500")]).expect_err("there is no unit");
        let message = "in the environment variable TMCL_TIMEOUT: `500`: a time from 1ms to 1h is expected, such as \
                       500ms or 1s";
        assert_eq!((failure.code(), failure.message()), (Code::Usage, message));
    }
}
