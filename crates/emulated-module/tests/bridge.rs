//! Clients that take turns at one line, with a chip at its end that says back what it hears.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "tests with sockets and threads"
)]

use std::fs::File;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};

use emulated_module::Bridge;

/// A bridge to a chip that says back what it hears, and what tells when the chip is gone.
fn echo() -> (Bridge, UnixStream, Receiver<()>) {
    let (line, chip) = UnixStream::pair().unwrap();
    let (mut reader, mut writer) = (chip.try_clone().unwrap(), chip.try_clone().unwrap());
    std::thread::spawn(move || std::io::copy(&mut reader, &mut writer));
    let (end, ended) = channel();
    let bridge = Bridge::start(line, move || end.send(()).unwrap()).unwrap();
    (bridge, chip, ended)
}

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn asks(client: &mut (impl Read + Write), request: &[u8]) {
    client.write_all(request).unwrap();
    let mut reply = vec![0; request.len()];
    client.read_exact(&mut reply).unwrap();
    assert_eq!(reply, request);
}

fn open(link: &Path) -> File {
    File::options().read(true).write(true).open(link).unwrap()
}

#[test]
fn each_client_hears_the_replies_to_its_own_requests() {
    let (mut bridge, _chip, _ended) = echo();
    let address = bridge.listen_tcp("127.0.0.1:0").unwrap();
    let link = path("bridge-turns");
    bridge.listen_pty(&link).unwrap();
    let mut terminal = open(&link);
    let clients: Vec<_> = (0..3_u8)
        .map(|client| {
            let mut stream = TcpStream::connect(address).unwrap();
            std::thread::spawn(move || (0..5_u8).for_each(|round| asks(&mut stream, &[client, round, 0xFF])))
        })
        .collect();
    // Two ends of lines, which a terminal that is not raw rewrites, and an end of text.
    for round in 0..5 {
        asks(&mut terminal, &[b'\r', b'\n', 4, 9, round]);
    }
    clients.into_iter().for_each(|client| client.join().unwrap());
}

#[test]
fn who_goes_with_replies_under_way_leaves_none_to_the_next() {
    let (mut bridge, _chip, _ended) = echo();
    let address = bridge.listen_tcp("127.0.0.1:0").unwrap();
    for round in 0..5 {
        let mut gone = TcpStream::connect(address).unwrap();
        gone.write_all(&[0xAA; 300]).unwrap();
        gone.shutdown(Shutdown::Both).unwrap();
        asks(&mut TcpStream::connect(address).unwrap(), &[round; 9]);
    }
}

#[test]
fn who_does_not_read_is_hung_up_on_and_holds_nobody_up() {
    let (mut bridge, _chip, _ended) = echo();
    let address = bridge.listen_tcp("127.0.0.1:0").unwrap();
    let mut mute = TcpStream::connect(address).unwrap();
    let block = vec![0x55; 1 << 20];
    // More than the system and the bridge keep for it.
    while mute.write_all(&block).is_ok() {}
    asks(&mut TcpStream::connect(address).unwrap(), &[7; 9]);
}

#[test]
fn nobody_at_a_pseudo_terminal_holds_nobody_up() {
    let (mut bridge, _chip, _ended) = echo();
    let address = bridge.listen_tcp("127.0.0.1:0").unwrap();
    let link = path("bridge-mute");
    bridge.listen_pty(&link).unwrap();
    let mut mute = open(&link);
    for _ in 0..64 {
        mute.write_all(&[0x55; 1 << 10]).unwrap();
    }
    asks(&mut TcpStream::connect(address).unwrap(), &[7; 9]);
}

#[test]
fn a_dropped_bridge_hangs_up_and_takes_its_link_along() {
    let (mut bridge, mut chip, ended) = echo();
    let address = bridge.listen_tcp("127.0.0.1:0").unwrap();
    let link = path("bridge-dropped");
    bridge.listen_pty(&link).unwrap();
    let mut client = TcpStream::connect(address).unwrap();
    asks(&mut client, &[1; 9]);
    drop(bridge);
    assert_eq!(client.read(&mut [0]).unwrap(), 0);
    assert!(!link.is_symlink());
    ended.recv().unwrap();
    assert_eq!(chip.read(&mut [0]).unwrap(), 0);
}

#[test]
fn a_chip_that_goes_is_told() {
    let (mut bridge, chip, ended) = echo();
    let address = bridge.listen_tcp("127.0.0.1:0").unwrap();
    asks(&mut TcpStream::connect(address).unwrap(), &[1; 9]);
    chip.shutdown(Shutdown::Both).unwrap();
    ended.recv().unwrap();
}

#[test]
fn a_taken_path_and_a_taken_address_are_refused() {
    let (mut bridge, _chip, _ended) = echo();
    let link = path("bridge-taken");
    bridge.listen_pty(&link).unwrap();
    let refusal = bridge.listen_pty(&link).unwrap_err().to_string();
    assert_eq!(
        refusal,
        format!("{} exists; choose another path, or remove it if nothing uses it", link.display())
    );
    let address = bridge.listen_tcp("127.0.0.1:0").unwrap();
    assert_eq!(bridge.listen_tcp(&address.to_string()).unwrap_err().kind(), std::io::ErrorKind::AddrInUse);
}
