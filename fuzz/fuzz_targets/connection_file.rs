//! Any text as a `tmcl.toml`: parsing does not panic, an error points into the text, and what parses keeps to its ranges and comes
//! back when it is written and parsed again.
#![no_main]

use std::fmt::Write as _;
use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use tmcl_config::connection::{ConnectionSettings, parse};

/// The settings but for the port, which may hold anything.
fn written(settings: &ConnectionSettings) -> String {
    let mut text = "[connection]\n".to_owned();
    let ConnectionSettings { port: _, baud, address, host_address, timeout, retries } = settings;
    let timeout = timeout.map(|time| format!("\"{}us\"", time.as_nanos() as f64 / 1e3));
    let lines = [
        ("baud", baud.as_ref().map(|baud| format!("\"{baud}\""))),
        ("address", address.map(|address| address.to_string())),
        ("host_address", host_address.map(|address| address.to_string())),
        ("timeout", timeout),
        ("retries", retries.map(|retries| retries.to_string())),
    ];
    for (key, value) in lines {
        if let Some(value) = value {
            writeln!(text, "{key} = {value}").expect("there is room");
        }
    }
    text
}

/// Each text as it is, and as what stands in the table.
fn examine(text: &str) {
    match parse(text) {
        Ok(settings) => {
            let ConnectionSettings { baud, address, host_address, timeout, retries, .. } = &settings;
            assert!(
                baud.iter().all(|baud| !baud.rates().is_empty() && baud.rates().iter().all(|rate| *rate > 0))
            );
            assert!([address, host_address].into_iter().flatten().all(|address| *address <= 0x7FF));
            let allowed = Duration::from_millis(1)..=Duration::from_secs(3600);
            assert!(timeout.iter().all(|timeout| allowed.contains(timeout)));
            assert!(retries.iter().all(|retries| *retries <= 100));
            let again = parse(&written(&settings)).expect("what is written can be read");
            // A time of a fraction of a nanosecond more or less is the same.
            let apart = |one: Option<Duration>, other: Option<Duration>| match (one, other) {
                (Some(one), Some(other)) => one.abs_diff(other) > Duration::from_nanos(1),
                (one, other) => one != other,
            };
            assert!(!apart(again.timeout, settings.timeout));
            assert_eq!(
                ConnectionSettings { timeout: None, port: None, ..again },
                ConnectionSettings { timeout: None, port: None, ..settings }
            );
        }
        Err(finding) => {
            assert!(text.get(finding.span.clone()).is_some());
            assert!(!finding.message.is_empty());
        }
    }
}

fuzz_target!(|text: &str| {
    examine(text);
    examine(&format!("[connection]\n{text}"));
});
