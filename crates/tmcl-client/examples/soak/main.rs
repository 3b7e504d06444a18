//! A busy bus for a day: two modules, a host, a line that is sometimes bad, restarts, stores, downloads and moves, in virtual
//! time. What the modules confirmed is held against what they really hold, all along; it ends with an error at the first
//! difference, or with figures.
//!
//! `cargo run --release -p tmcl-client --example soak -- --for 24h --seed 1`
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "a program of its own: arguments, clock and memory figures"
)]

#[path = "../../tests/common/bus.rs"]
mod bus;
mod checksum;
mod host;
mod memory;
mod model;
#[path = "../../tests/common/random.rs"]
mod random;
mod soak;

use std::process::ExitCode;
use std::time::{Duration, Instant};

const USAGE: &str = "usage: soak [--for SPAN] [--seed N]   SPAN: a number and s, min or h; 24h unless said";

fn main() -> ExitCode {
    let (span, seed) = match arguments() {
        Ok(found) => found,
        Err(error) => {
            eprintln!("error: {error}\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    let start = Instant::now();
    let mut soak = soak::Soak::new(seed);
    // The first minutes fill what grows to its size once.
    soak.run_until(span / 100);
    let before = memory::resident_kib();
    soak.run_until(span);
    let after = memory::resident_kib();
    println!("{}", soak.report());
    match before.zip(after) {
        Some((before, after)) => {
            println!("resident memory: {before} KiB after a hundredth of it, {after} KiB at the end");
        }
        None => println!("resident memory: this system does not tell"),
    }
    println!("took {:.1} s", start.elapsed().as_secs_f64());
    ExitCode::SUCCESS
}

fn arguments() -> Result<(Duration, u64), String> {
    let (mut span, mut seed) = (Duration::from_secs(24 * 3600), 1);
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{name} needs a value"))?;
        match name.as_str() {
            "--for" => span = parse_span(&value).ok_or_else(|| format!("\"{value}\" is no span of time"))?,
            "--seed" => seed = value.parse().map_err(|_| format!("\"{value}\" is no seed"))?,
            _ => return Err(format!("there is no argument {name}")),
        }
    }
    Ok((span, seed))
}

fn parse_span(text: &str) -> Option<Duration> {
    let unit = text.trim_start_matches(|letter: char| letter.is_ascii_digit());
    let count: u64 = text.strip_suffix(unit)?.parse().ok()?;
    let seconds = match unit {
        "s" => 1,
        "min" => 60,
        "h" => 3600,
        _ => return None,
    };
    count.checked_mul(seconds).map(Duration::from_secs)
}
