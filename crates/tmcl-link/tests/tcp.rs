//! Bytes over a real socket, and what happens when there is nobody at the other end.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "the other end of a link is a socket and a thread"
)]

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use tmcl_link::{Link, LinkError, open};

/// Long enough for a busy machine.
const PATIENCE: Duration = Duration::from_secs(10);

/// A link, and the socket at its other end.
fn connected() -> (Box<dyn Link>, TcpStream) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let link = open(&listener.local_addr().expect("an address").to_string()).expect("somebody listens");
    let (peer, _) = listener.accept().expect("the link connects");
    (link, peer)
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

#[test]
fn every_byte_passes_both_ways() {
    let (mut link, mut peer) = connected();
    let all: Vec<u8> = (0..=255).collect();
    link.write(&all).expect("the link works");
    let mut heard = [0; 256];
    peer.read_exact(&mut heard).expect("the link wrote");
    assert_eq!(heard[..], all);
    peer.write_all(&all).expect("the link listens");
    assert_eq!(read_exactly(&mut link, 256), all);
}

#[test]
fn silence_is_no_error_and_takes_as_long_as_asked() {
    let (mut link, mut peer) = connected();
    for timeout in [Duration::ZERO, Duration::from_millis(30), Duration::from_millis(60)] {
        let start = Instant::now();
        assert_eq!(link.read(&mut [0; 9], timeout).expect("the link works"), 0);
        // A kernel counts in ticks.
        assert!(start.elapsed() + Duration::from_millis(10) >= timeout, "{timeout:?}");
    }
    peer.write_all(&[7]).expect("the link listens");
    assert_eq!(read_exactly(&mut link, 1), [7]);
    assert_eq!(link.read(&mut [], PATIENCE).expect("nothing was asked for"), 0);
}

#[test]
fn discarded_input_is_gone_and_what_follows_is_not() {
    let (mut link, mut peer) = connected();
    link.discard_input().expect("nothing to discard");
    peer.write_all(&[1; 10_000]).expect("the link listens");
    // One byte of it must have arrived, then the rest, on one machine, has too.
    assert_eq!(read_exactly(&mut link, 1), [1]);
    link.discard_input().expect("the link works");
    peer.write_all(&[2, 3]).expect("the link listens");
    assert_eq!(read_exactly(&mut link, 2), [2, 3]);
    // Reading still waits after that.
    std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(30));
            peer.write_all(&[4]).expect("the link listens");
        });
        assert_eq!(read_exactly(&mut link, 1), [4]);
    });
}

#[test]
fn a_peer_that_goes_is_reported() {
    let (mut link, peer) = connected();
    let address = peer.local_addr().expect("an address");
    drop(peer);
    let error = link.read(&mut [0; 9], PATIENCE).expect_err("nobody is there");
    assert!(matches!(error, LinkError::Closed { .. }));
    assert_eq!(error.to_string(), format!("tcp:{address} was closed by the other side"));
    assert!(matches!(link.discard_input(), Err(LinkError::Closed { .. })));
}

#[test]
fn nobody_listening_is_reported_with_what_was_tried() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("an address");
    drop(listener);
    let error = open(&format!("tcp:{address}")).err().expect("nobody listens");
    assert!(matches!(error, LinkError::Open { .. }));
    assert!(error.to_string().starts_with(&format!("cannot open tcp:{address}: ")), "{error}");
}

#[test]
fn what_is_no_address_is_not_tried() {
    assert!(matches!(open("somewhere"), Err(LinkError::Address(_))));
}
