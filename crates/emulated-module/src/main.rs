//! `emulated-module`: a module on an emulated chip, on ports. `cargo xtask firmware --run` builds and starts it.
#![allow(clippy::disallowed_types, reason = "an edge: it listens")]

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::channel;

use clap::Parser;
use emulated_module::{Bridge, DeskModule};

/// Where it listens when nothing is said.
const DEFAULT_ADDRESS: &str = "127.0.0.1:5311";

/// Exit code where something that has to be there is not: what `tmcl serve` ends with.
const CONNECTION: u8 = 3;

/// A module on an emulated chip: the physics of the default bench around it, its UART on ports
#[derive(Parser)]
struct Arguments {
    /// Which module
    #[arg(value_parser = ["tmcm-1311", "tmcm-1640"])]
    module: String,
    /// Listen here, `host:port`; port 0 picks a free one [default: 127.0.0.1:5311, unless there is --pty]
    #[arg(long, value_name = "ADDRESS")]
    tcp: Vec<String>,
    /// Open a pseudo terminal and link this path to it
    #[arg(long, value_name = "PATH")]
    pty: Vec<PathBuf>,
    /// The file that is its flash and EEPROM [default: target/firmware/MODULE.psram]
    #[arg(long, value_name = "FILE")]
    memory: Option<PathBuf>,
}

/// Why it ended.
enum End {
    Asked,
    ChipGone,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell(&format!("error: {error}"));
            ExitCode::from(CONNECTION)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let (end, ended) = channel();
    let asked = end.clone();
    ctrlc::set_handler(move || {
        // A second signal finds nobody waiting, and that is fine.
        let _ = asked.send(End::Asked);
    })
    .map_err(|error| format!("cannot wait for signals: {error}"))?;
    try_addresses(arguments)?;
    let memory = memory(arguments)?;
    let (_module, line) =
        DeskModule::start(&image(&arguments.module), &arguments.module, &memory).map_err(text)?;
    tell(&format!(
        "note: {} on an emulated chip; it keeps what it stores in {}",
        arguments.module,
        memory.display()
    ));
    let mut bridge = Bridge::start(line, move || {
        let _ = end.send(End::ChipGone);
    })
    .map_err(text)?;
    listen(&mut bridge, arguments)?;
    match ended.recv() {
        Ok(End::ChipGone) => Err("the emulated chip is gone: QEMU has ended".to_owned()),
        Ok(End::Asked) | Err(_) => Ok(()),
    }
}

/// Refuses what cannot be listened at before a chip is started for it.
fn try_addresses(arguments: &Arguments) -> Result<(), String> {
    let default = DEFAULT_ADDRESS.to_owned();
    let unsaid = arguments.tcp.is_empty() && arguments.pty.is_empty();
    for address in arguments.tcp.iter().chain(unsaid.then_some(&default)) {
        std::net::TcpListener::bind(address)
            .map_err(|error| format!("cannot listen on {address}: {error}"))?;
    }
    for path in &arguments.pty {
        tmcl_server::Pty::open(path).map_err(text)?;
    }
    Ok(())
}

fn listen(bridge: &mut Bridge, arguments: &Arguments) -> Result<(), String> {
    let default = [DEFAULT_ADDRESS.to_owned()];
    let unsaid = arguments.tcp.is_empty() && arguments.pty.is_empty();
    for address in if unsaid { &default[..] } else { &arguments.tcp } {
        let address =
            bridge.listen_tcp(address).map_err(|error| format!("cannot listen on {address}: {error}"))?;
        say(&format!("listening tcp {address}"))?;
    }
    for path in &arguments.pty {
        bridge.listen_pty(path).map_err(text)?;
        say(&format!("listening pty {}", path.display()))?;
    }
    Ok(())
}

/// A message; that nobody hears it is no reason to end.
fn tell(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{message}");
}

fn say(line: &str) -> Result<(), String> {
    let mut out = io::stdout().lock();
    writeln!(out, "{line}").and_then(|()| out.flush()).map_err(text)
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn root() -> &'static Path {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    folder.ancestors().nth(2).unwrap_or(folder)
}

fn image(module: &str) -> PathBuf {
    root().join("firmware/target/thumbv7m-none-eabi/release").join(format!("{module}-bench"))
}

fn memory(arguments: &Arguments) -> Result<PathBuf, String> {
    if let Some(file) = &arguments.memory {
        return Ok(file.clone());
    }
    let folder = root().join("target/firmware");
    std::fs::create_dir_all(&folder).map_err(|error| format!("making {}: {error}", folder.display()))?;
    Ok(folder.join(format!("{}.psram", arguments.module)))
}
