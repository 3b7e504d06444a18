//! `tmcl serve`: virtual modules on ports.

mod advice;
mod wiring;

use std::path::Path;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, PoisonError};

use tmcl_server::{Advance, Notice, Server, Settings};
use virtual_bench::{Bench, PORTS};

use crate::arguments::{Baud, Serve};
use crate::bench_file;
use crate::exit::{Code, Failure, Outcome};
use crate::recording::Recorder;
use crate::{print, state};
use advice::Advice;
use wiring::Lines;

/// Where it listens when nothing is said.
const DEFAULT_ADDRESS: &str = "127.0.0.1:5311";

/// Time between samples of a trace when nothing is said.
const SAMPLE_NS: u64 = 10_000_000;

/// Serves until a signal ends it.
pub(crate) fn run(options: &Serve) -> Outcome {
    let mut config = bench_file::load_several(&options.modules, options.bench.as_deref())?;
    let lines = Lines::of(options, &config)?;
    config.bus.interface = lines.interface();
    let (bench, state) = state::bench(&config, options.state.as_deref())?;
    let advice = Advice::of(&config, &bench);
    let follows_terminal = options.baud == Some(Baud::Auto);
    lines.warn(&bench, &config, follows_terminal);
    let recording = &options.recording;
    let recorder = Recorder::wanted(&bench, recording, SAMPLE_NS)?;
    let recorder = recorder.map(|recorder| Arc::new(Mutex::new(recorder)));
    let (stop, stopped) = channel();
    ctrlc::set_handler(move || {
        // A second signal finds nobody waiting, and that is fine.
        let _ = stop.send(());
    })
    .map_err(|error| Failure::new(Code::Connection, format!("cannot wait for signals: {error}")))?;
    let settings = Settings { speed: options.speed, serial: lines.serial, follows_terminal };
    let mut server = Server::start_with(bench, settings, advance(recorder.clone()), say);
    if let Some(state) = state {
        server.keep(state);
    }
    listen(&mut server, options, lines, &advice)?;
    // An error would mean that the handler is gone, and with it the only way to be told.
    let _ = stopped.recv();
    let wear = server.finish().map_err(state::failure);
    drop(server);
    if let Some(folder) = &options.state {
        state::report_wear(&wear?, folder);
    }
    if let Some(recorder) = recorder {
        recorder.lock().unwrap_or_else(PoisonError::into_inner).finish(recording, advice.first)?;
    }
    Ok(())
}

/// How the bench is run on: plainly, or with the recorder looking on.
fn advance(recorder: Option<Arc<Mutex<Recorder>>>) -> Advance {
    match recorder {
        None => Box::new(Bench::advance_to),
        Some(recorder) => Box::new(move |bench, time_ns| {
            recorder.lock().unwrap_or_else(PoisonError::into_inner).advance_to(bench, time_ns);
        }),
    }
}

fn listen(server: &mut Server, options: &Serve, lines: Lines, advice: &Advice) -> Outcome {
    let default = [DEFAULT_ADDRESS.to_owned()];
    let addresses = if options.tcp.is_empty() && options.pty.is_empty() && !lines.can {
        &default[..]
    } else {
        &options.tcp
    };
    for address in addresses {
        let address = server.listen_tcp(address).map_err(failure)?;
        print::text(&format!("listening tcp {address}\n"))?;
        advice.give("socket_serial_tmcl", &address.to_string(), "");
    }
    let rate = lines.baud().map(|baud| format!(" --data-rate {baud}")).unwrap_or_default();
    for path in &options.pty {
        listen_pty(server, path)?;
        print::text(&format!("listening pty {}\n", path.display()))?;
        advice.give("serial_tmcl", &path.display().to_string(), &rate);
    }
    for path in &options.slcan {
        listen_slcan(server, path)?;
        print::text(&format!("listening slcan {}\n", path.display()))?;
        advice.give("slcan_tmcl", &path.display().to_string(), "");
    }
    for interface in &options.can {
        server.join_can(interface).map_err(failure)?;
        print::text(&format!("listening can {interface}\n"))?;
        advice.give("socketcan_tmcl", interface, "");
    }
    Ok(())
}

fn failure(error: impl std::fmt::Display) -> Failure {
    Failure::new(Code::Connection, error.to_string())
}

#[cfg(unix)]
fn listen_pty(server: &mut Server, path: &Path) -> Result<(), Failure> {
    server.listen_pty(path).map_err(failure)
}

#[cfg(unix)]
fn listen_slcan(server: &mut Server, path: &Path) -> Result<(), Failure> {
    server.listen_slcan(path).map_err(failure)
}

#[cfg(not(unix))]
fn listen_pty(_server: &mut Server, _path: &Path) -> Result<(), Failure> {
    Err(Failure::new(Code::Usage, "this system has no pseudo terminals; use --tcp"))
}

#[cfg(not(unix))]
fn listen_slcan(server: &mut Server, path: &Path) -> Result<(), Failure> {
    listen_pty(server, path)
}

fn say(notice: Notice) {
    print::note(&match notice {
        Notice::Slipped(by) => {
            format!(
                "this machine is too slow for the speed asked for: virtual time gave up {} ms",
                by.as_millis()
            )
        }
        Notice::Refused(peer) => format!("turned {peer} away: all {PORTS} ports of the module are in use"),
        Notice::NotKept(error) => {
            format!("what is stored is not kept for now, and lost if this goes on to the end: {error}")
        }
        Notice::NotSent(error) => {
            format!("what the modules say does not get out, and is lost until it does: {error}")
        }
        Notice::ClientFailed(error) => format!("a client could not be served: {error}"),
    });
}
