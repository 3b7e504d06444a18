//! Bytes over a pseudo terminal, which to a program is a serial port like any other.
#![cfg(unix)]
#![allow(clippy::disallowed_methods, reason = "the other end of a link is a file")]

use std::fs::File;
use std::io::{Read, Write};
use std::time::Duration;

use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use tmcl_link::{Link, LinkError, SerialLink, open};

/// Long enough for a busy machine.
const PATIENCE: Duration = Duration::from_secs(10);

/// The controlling side of a pseudo terminal, its name, and the terminal held open as a server does.
struct Terminal {
    controller: File,
    name: String,
    _held: File,
}

impl Terminal {
    fn new() -> Self {
        let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo terminal");
        grantpt(&controller).and_then(|()| unlockpt(&controller)).expect("it is ours");
        let name = ptsname(&controller, Vec::new()).expect("it has a name").to_string_lossy().into_owned();
        let held = open_plainly(&name);
        Self { controller: File::from(controller), name, _held: held }
    }

    fn say(&mut self, bytes: &[u8]) {
        self.controller.write_all(bytes).expect("the terminal is open");
    }

    fn hear(&mut self, length: usize) -> Vec<u8> {
        let mut bytes = vec![0; length];
        self.controller.read_exact(&mut bytes).expect("the link wrote");
        bytes
    }
}

fn open_plainly(name: &str) -> File {
    let flags = OFlags::RDWR | OFlags::NOCTTY;
    File::from(rustix::fs::open(name, flags, Mode::empty()).expect("the terminal opens"))
}

fn read_exactly(link: &mut impl Link, length: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while bytes.len() < length {
        let mut buffer = [0; 16];
        let room = buffer.len().min(length - bytes.len());
        let read = link.read(&mut buffer[..room], PATIENCE).expect("the link works");
        assert!(read > 0, "only {bytes:?} came");
        bytes.extend(&buffer[..read]);
    }
    bytes
}

/// No byte means anything to the line: no line ends, flow control, interrupt or end of file.
#[test]
fn every_byte_passes_both_ways() {
    let mut terminal = Terminal::new();
    let mut link = open(&terminal.name).expect("the terminal opens");
    let all: Vec<u8> = (0..=255).collect();
    link.write(&all).expect("the link works");
    assert_eq!(terminal.hear(256), all);
    terminal.say(&all);
    assert_eq!(read_exactly(&mut link, 256), all);
}

#[test]
fn any_baud_rate_will_do() {
    let mut terminal = Terminal::new();
    for baud_rate in [9600, 19_200, 115_200, 250_000, 1_000_000] {
        let mut link = open(&format!("serial:{}@{baud_rate}", terminal.name)).expect("the terminal opens");
        link.write(&[1, 2, 3]).expect("the link works");
        assert_eq!(terminal.hear(3), [1, 2, 3]);
    }
}

#[test]
fn silence_is_no_error_and_discarded_input_is_gone() {
    let mut terminal = Terminal::new();
    let mut link = open(&terminal.name).expect("the terminal opens");
    assert_eq!(link.read(&mut [0; 9], Duration::from_millis(20)).expect("the link works"), 0);
    assert_eq!(link.read(&mut [0; 9], Duration::ZERO).expect("the link works"), 0);
    terminal.say(&[1; 20]);
    assert_eq!(read_exactly(&mut link, 1), [1]);
    link.discard_input().expect("the link works");
    terminal.say(&[2]);
    assert_eq!(read_exactly(&mut link, 1), [2]);
}

#[test]
fn two_at_once_would_hear_half_of_each_others_replies() {
    let terminal = Terminal::new();
    let first = SerialLink::open(&terminal.name, 9600).expect("the terminal opens");
    let error = SerialLink::open(&terminal.name, 9600).expect_err("the first has it");
    assert!(matches!(error, LinkError::InUse { .. }), "{error}");
    assert_eq!(
        error.to_string(),
        format!("cannot open serial:{}@9600: another program has it open", terminal.name)
    );
    drop(first);
    SerialLink::open(&terminal.name, 9600).expect("it is free again");
}

/// The kernel's lock would outlive a client that is killed. (Nothing locks root out: this test bites for other users.)
#[test]
fn the_lock_of_a_client_goes_with_it() {
    let terminal = Terminal::new();
    let link = SerialLink::open(&terminal.name, 9600).expect("the terminal opens");
    open_plainly(&terminal.name);
    drop(link);
}

#[test]
fn a_terminal_that_goes_is_reported() {
    let mut terminal = Terminal::new();
    let mut link = open(&terminal.name).expect("the terminal opens");
    terminal.say(&[1]);
    assert_eq!(read_exactly(&mut link, 1), [1]);
    let name = terminal.name.clone();
    drop(terminal);
    let error = link.read(&mut [0; 9], PATIENCE).expect_err("nobody is there");
    assert_eq!(error.to_string(), format!("serial:{name}@9600 was closed by the other side"));
}

#[test]
fn a_port_that_is_not_there_is_reported_with_what_was_tried() {
    let error = open("/dev/no-such-port@115200").err().expect("there is none");
    assert!(matches!(error, LinkError::Open { .. }));
    assert!(
        error.to_string().starts_with("cannot open serial:/dev/no-such-port@115200: No such file"),
        "{error}"
    );
    let error = open("/dev/null").err().expect("it is no terminal");
    assert!(error.to_string().starts_with("cannot open serial:/dev/null@9600: "), "{error}");
}
