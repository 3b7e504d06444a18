//! `tmcl serve`: a virtual module on ports.

use std::path::Path;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, PoisonError};

use tmcl_server::{Advance, Notice, Server};
use tmcl_tables::GlobalParameter;
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PORTS, Probe, Quantity};

use crate::arguments::Serve;
use crate::bench_file;
use crate::exit::{Code, Failure, Outcome};
use crate::recording::Recorder;
use crate::{print, state};

/// Where it listens when nothing is said.
const DEFAULT_ADDRESS: &str = "127.0.0.1:5311";

/// Time between samples of a trace when nothing is said.
const SAMPLE_NS: u64 = 10_000_000;

/// Serves until a signal ends it.
pub(crate) fn run(options: &Serve) -> Outcome {
    check_ports(options)?;
    let config = bench_file::load(options.module, options.bench.as_deref())?;
    let (bench, state) = state::bench(&config, options.state.as_deref())?;
    let client = Client::of(&config, &bench);
    let recording = &options.recording;
    let recorder = Recorder::wanted(&bench, recording, SAMPLE_NS)?;
    let recorder = recorder.map(|recorder| Arc::new(Mutex::new(recorder)));
    let (stop, stopped) = channel();
    ctrlc::set_handler(move || {
        // A second signal finds nobody waiting, and that is fine.
        let _ = stop.send(());
    })
    .map_err(|error| Failure::new(Code::Connection, format!("cannot wait for signals: {error}")))?;
    let mut server = Server::start_with(bench, options.speed, advance(recorder.clone()), say);
    if let Some(state) = state {
        server.keep(state);
    }
    listen(&mut server, options, &client)?;
    // An error would mean that the handler is gone, and with it the only way to be told.
    let _ = stopped.recv();
    let wear = server.finish().map_err(state::failure);
    drop(server);
    if let Some(folder) = &options.state {
        state::report_wear(&wear?, folder);
    }
    if let Some(recorder) = recorder {
        recorder.lock().unwrap_or_else(PoisonError::into_inner).finish(recording, client.name)?;
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

fn listen(server: &mut Server, options: &Serve, client: &Client) -> Outcome {
    let default = [DEFAULT_ADDRESS.to_owned()];
    let addresses =
        if options.tcp.is_empty() && options.pty.is_empty() { &default[..] } else { &options.tcp };
    for address in addresses {
        let address =
            server.listen_tcp(address).map_err(|error| Failure::new(Code::Connection, error.to_string()))?;
        print::text(&format!("listening tcp {address}\n"))?;
        client.advise("socket_serial_tmcl", &address.to_string());
    }
    for path in &options.pty {
        listen_pty(server, path)?;
        print::text(&format!("listening pty {}\n", path.display()))?;
        client.advise("serial_tmcl", &path.display().to_string());
    }
    Ok(())
}

/// Each pseudo terminal holds a port of the module, and TCP clients want one too.
fn check_ports(options: &Serve) -> Result<(), Failure> {
    let needed = options.pty.len() + usize::from(!options.tcp.is_empty());
    if needed > PORTS {
        let message =
            format!("a module has {PORTS} ports: each --pty holds one, and --tcp needs one for its clients");
        return Err(Failure::new(Code::Usage, message));
    }
    Ok(())
}

#[cfg(unix)]
fn listen_pty(server: &mut Server, path: &Path) -> Result<(), Failure> {
    server.listen_pty(path).map_err(|error| Failure::new(Code::Connection, error.to_string()))
}

#[cfg(not(unix))]
fn listen_pty(_server: &mut Server, _path: &Path) -> Result<(), Failure> {
    Err(Failure::new(Code::Usage, "this system has no pseudo terminals; use --tcp"))
}

/// What a client has to know of the module at the ports.
struct Client {
    name: &'static str,
    address: i64,
    /// What moves the motor as the module comes.
    motion: &'static str,
}

impl Client {
    fn of(config: &BenchConfig, bench: &Bench) -> Self {
        let first = config.modules.first();
        let spec = first.map_or(&tmcl_tables::tmcm_1311::SPEC, |module| module.kind.spec());
        let (bank, number) = GlobalParameter::SerialAddress.address();
        let address = bench.read(Probe { module: ModuleId(0), quantity: Quantity::Global(bank, number) });
        let motion = match first.map(|module| module.kind) {
            Some(ModuleKind::Tmcm1640) => "rotate(1000)",
            Some(ModuleKind::Tmcm1311) | None => "move_to(51200)",
        };
        Self { name: spec.name, address: address as i64, motion }
    }

    /// What to type to drive the module with PyTrinamic.
    fn advise(&self, interface: &str, port: &str) {
        let class = self.name.replace('-', "");
        let motion = self.motion;
        let (option, argument) = match self.address {
            1 => (String::new(), String::new()),
            address => (format!(" --module-id {address}"), format!(", {address}")),
        };
        anstream::eprintln!(
            "\nPyTrinamic (pip install pytrinamic):\n\n    from pytrinamic.connections import ConnectionManager\n    \
             from pytrinamic.modules import {class}\n    \
             connection = ConnectionManager(\"--interface {interface} --port {port}{option}\").connect()\n    \
             motor = {class}(connection{argument}).motors[0]\n    motor.{motion}\n"
        );
    }
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
        Notice::ClientFailed(error) => format!("a client could not be served: {error}"),
    });
}
