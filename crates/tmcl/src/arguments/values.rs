//! What options take, and what they say to anything else.

use tmcl_config::nanoseconds;

pub(super) fn code(text: &str) -> Result<tmcl_lang::Code, String> {
    text.parse().map_err(|_| "no such code; `tmcl explain` lists them".to_owned())
}

pub(super) fn tcp_address(text: &str) -> Result<String, String> {
    let (host, port) = text.rsplit_once(':').unwrap_or(("", text));
    let host = if host.is_empty() { "127.0.0.1" } else { host };
    match port.parse::<u16>() {
        Ok(port) => Ok(format!("{host}:{port}")),
        Err(_) => Err("a host and a port from 0 to 65535 are expected, such as 127.0.0.1:5311".to_owned()),
    }
}

/// The rate of an RS485 line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Baud {
    /// What the program at the other end of a pseudo terminal has set.
    Auto,
    /// So many bits a second.
    Fixed(u32),
}

pub(super) fn baud(text: &str) -> Result<Baud, String> {
    if text == "auto" {
        return Ok(Baud::Auto);
    }
    match text.parse() {
        Ok(baud @ 50..=10_000_000) => Ok(Baud::Fixed(baud)),
        _ => Err("auto or a rate from 50 to 10000000 is expected, such as 9600 or 115200".to_owned()),
    }
}

pub(super) fn turns(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if turns.is_finite() && turns.abs() <= 10_000.0 => Ok(turns),
        _ => Err("a number of turns from -10000 to 10000 is expected".to_owned()),
    }
}

/// Within what the module's velocity and acceleration can be set to, and a run can last.
pub(super) fn rpm(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rpm) if (0.01..=3000.0).contains(&rpm) => Ok(rpm),
        _ => Err("a velocity from 0.01 to 3000 rpm is expected".to_owned()),
    }
}

/// A time between samples in nanoseconds: at least a control period.
pub(crate) fn interval(text: &str) -> Result<u64, String> {
    const EXPECTED: &str = "a time from 50us to 1h is expected, such as 500us, 1ms or 0.5s";
    nanoseconds(text)
        .filter(|time_ns| (50_000.0..=3.6e12).contains(time_ns))
        .map_or_else(|| Err(EXPECTED.to_owned()), |time_ns| Ok(time_ns as u64))
}

/// Virtual time is cheap: a program that mostly waits runs for a year in a minute.
pub(crate) fn duration(text: &str) -> Result<u64, String> {
    const EXPECTED: &str = "a time from 50us to 100000h is expected, such as 500ms, 10s, 5min or 1h";
    nanoseconds(text)
        .filter(|time_ns| (50_000.0..=3.6e17).contains(time_ns))
        .map_or_else(|| Err(EXPECTED.to_owned()), |time_ns| Ok(time_ns as u64))
}

pub(super) fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if speed.is_finite() && speed > 0.0 => Ok(speed),
        _ => Err("a positive number is expected, such as 1, 0.1 or 20".to_owned()),
    }
}
