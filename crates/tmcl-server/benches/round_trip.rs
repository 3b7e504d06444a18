//! A command and its reply over TCP and over a pseudo terminal, beside a server that only echoes: the difference is what
//! the module costs.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "a benchmark is a client: it has sockets"
)]

use std::fs::File;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tmcl_server::{Server, State};
use tmcl_tables::Command;
use tmcl_wire::{Request, serial};
use virtual_bench::{Bench, BenchConfig, ModuleKind};

fn exchange(stream: &mut (impl Read + Write), request: &[u8; 9]) -> [u8; 9] {
    let mut reply = [0; 9];
    stream.write_all(request).expect("the server takes requests");
    stream.read_exact(&mut reply).expect("the server answers");
    reply
}

/// Sends back what it reads, in one thread per client, as the server does.
fn echo(mut stream: impl Read + Write + Send + 'static) {
    std::thread::spawn(move || {
        let mut buffer = [0; 512];
        while let Ok(length @ 1..) = stream.read(&mut buffer) {
            if stream.write_all(&buffer[..length]).is_err() {
                return;
            }
        }
    });
}

fn connect(address: std::net::SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).expect("the server listens");
    stream.set_nodelay(true).expect("TCP has no delay to set");
    stream
}

fn tcp_echo() -> TcpStream {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let client = connect(listener.local_addr().expect("an address"));
    let (server, _) = listener.accept().expect("the client connects");
    server.set_nodelay(true).expect("TCP has no delay to set");
    echo(server);
    client
}

/// A raw pseudo terminal with an echo behind it.
fn pty_echo() -> File {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo terminal");
    grantpt(&controller).and_then(|()| unlockpt(&controller)).expect("it is ours");
    let name = ptsname(&controller, Vec::new()).expect("it has a name").to_string_lossy().into_owned();
    let terminal = open_raw(&name);
    echo(File::from(controller));
    terminal
}

fn open_raw(path: &str) -> File {
    use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
    let terminal = File::options().read(true).write(true).open(path).expect("the terminal opens");
    let mut settings = tcgetattr(&terminal).expect("it is a terminal");
    settings.make_raw();
    tcsetattr(&terminal, OptionalActions::Now, &settings).expect("it can be raw");
    terminal
}

/// A server whose module keeps its EEPROM, and where it listens.
fn keeping(folder: &std::path::Path) -> (Server, std::net::SocketAddr) {
    let config = BenchConfig::default_for(ModuleKind::Tmcm1311);
    let (state, eeproms, _) = State::open(folder, &config).expect("a folder");
    let mut eeproms = eeproms.into_iter();
    let mut server = Server::start(Bench::with_eeproms(&config, |_| eeproms.next()), 1.0, |_| {});
    server.keep(state);
    let address = server.listen_tcp("127.0.0.1:0").expect("a free port");
    (server, address)
}

fn round_trip(c: &mut Criterion) {
    let link = std::env::temp_dir().join(format!("opentmcl-bench-{}", std::process::id()));
    let bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
    let mut server = Server::start(bench, 1.0, |_| {});
    let address = server.listen_tcp("127.0.0.1:0").expect("a free port");
    server.listen_pty(&link).expect("a pseudo terminal");
    let request = serial::encode_request(1, Request::new(Command::GetAxisParameter, 1, 0, 0));

    let mut group = c.benchmark_group("round trip");
    group.throughput(Throughput::Elements(1));
    let mut stream = tcp_echo();
    group.bench_function("tcp/echo", |b| b.iter(|| exchange(&mut stream, &request)));
    let mut stream = connect(address);
    group.bench_function("tcp/tmcm-1311", |b| b.iter(|| exchange(&mut stream, &request)));
    let folder = std::env::temp_dir().join(format!("opentmcl-state-{}", std::process::id()));
    let keeping = keeping(&folder);
    let mut stream = connect(keeping.1);
    group.bench_function("tcp/tmcm-1311 with --state", |b| b.iter(|| exchange(&mut stream, &request)));
    let mut values = (0..).map(|value| {
        [Command::SetGlobalParameter, Command::StoreGlobalParameter]
            .map(|command| serial::encode_request(1, Request::new(command, 7, 2, value)))
    });
    group.bench_function("tcp/tmcm-1311 with --state, SGP and STGP of another value", |b| {
        b.iter(|| values.next().map(|requests| requests.map(|request| exchange(&mut stream, &request))));
    });
    drop(keeping);
    let _ = std::fs::remove_dir_all(&folder);
    let mut terminal = pty_echo();
    group.bench_function("pty/echo", |b| b.iter(|| exchange(&mut terminal, &request)));
    let mut terminal = open_raw(&link.to_string_lossy());
    group.bench_function("pty/tmcm-1311", |b| b.iter(|| exchange(&mut terminal, &request)));
    group.finish();
}

criterion_group!(benches, round_trip);
criterion_main!(benches);
