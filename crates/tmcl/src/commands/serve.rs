//! `tmcl serve`: a virtual module on ports.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::mpsc::channel;

use tmcl_server::{Notice, Server};
use tmcl_tables::GlobalParameter;
use virtual_bench::{Bench, BenchConfig, PORTS};

use crate::arguments::Serve;
use crate::exit::{Code, Failure, Outcome};
use crate::print;

/// Where it listens when nothing is said.
const DEFAULT_ADDRESS: &str = "127.0.0.1:5311";

/// Serves until a signal ends it.
pub(crate) fn run(options: &Serve) -> Outcome {
    check_ports(options)?;
    let (stop, stopped) = channel();
    ctrlc::set_handler(move || {
        // A second signal finds nobody waiting, and that is fine.
        let _ = stop.send(());
    })
    .map_err(|error| Failure::new(Code::Connection, format!("cannot wait for signals: {error}")))?;
    let mut config = BenchConfig::default_for(options.module.kind);
    config.modules[0].address = options.module.address;
    let mut server = Server::start(Bench::new(&config), options.speed, say);
    let default = [DEFAULT_ADDRESS.to_owned()];
    let addresses =
        if options.tcp.is_empty() && options.pty.is_empty() { &default[..] } else { &options.tcp };
    for address in addresses {
        let address =
            server.listen_tcp(address).map_err(|error| Failure::new(Code::Connection, error.to_string()))?;
        print::text(&format!("listening tcp {address}\n"))?;
        advise_tcp(options, address);
    }
    for path in &options.pty {
        listen_pty(&mut server, path)?;
        print::text(&format!("listening pty {}\n", path.display()))?;
        advise_pty(options, path);
    }
    // An error would mean that the handler is gone, and with it the only way to be told.
    let _ = stopped.recv();
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

/// What to type to drive the module with PyTrinamic.
fn advise(options: &Serve, interface: &str, port: &str) {
    let spec = options.module.kind.spec();
    let (bank, number) = GlobalParameter::SerialAddress.address();
    let default = spec.global_parameter(bank, number).map_or(1, |entry| entry.parameter.default);
    let address = options.module.address.map_or(default, i64::from);
    let class = spec.name.replace('-', "");
    let module_id = if address == 1 { String::new() } else { format!(" --module-id {address}") };
    anstream::eprintln!(
        "\nPyTrinamic (pip install pytrinamic):\n\n    from pytrinamic.connections import ConnectionManager\n    \
         from pytrinamic.modules import {class}\n    \
         connection = ConnectionManager(\"--interface {interface} --port {port}{module_id}\").connect()\n    \
         motor = {class}(connection{}).motors[0]\n    motor.move_to(51200)\n",
        if address == 1 { String::new() } else { format!(", {address}") },
    );
}

fn advise_tcp(options: &Serve, address: SocketAddr) {
    advise(options, "socket_serial_tmcl", &address.to_string());
}

fn advise_pty(options: &Serve, path: &Path) {
    advise(options, "serial_tmcl", &path.display().to_string());
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
        Notice::ListenerFailed(error) => format!("a client could not be served: {error}"),
    });
}
