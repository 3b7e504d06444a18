//! TCP sockets.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::Duration;

use crate::error::{Errors, is_timeout};
use crate::{Link, LinkAddress, LinkError};

/// How long each of a host's addresses has to answer.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// How long the other side may take nothing.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// The shortest wait; a socket takes zero for "forever".
const SHORTEST_WAIT: Duration = Duration::from_micros(1);

/// Input is thrown away this much at a time …
const DISCARD_SIZE: usize = 4096;

/// … and this often at most: a peer that never stops talking must not keep us here.
const DISCARD_LIMIT: usize = 256;

/// A TCP connection.
#[derive(Debug)]
pub struct TcpLink {
    stream: TcpStream,
    /// What the socket's read timeout is set to; setting it costs a system call.
    timeout: Option<Duration>,
    errors: Errors,
}

impl TcpLink {
    /// Connects to `host`, which has five seconds to answer for each of its addresses.
    ///
    /// # Errors
    /// [`LinkError`] when the host has no address, or none of them answers.
    pub fn connect(host: &str, port: u16) -> Result<Self, LinkError> {
        let errors = Errors::of(LinkAddress::Tcp { host: host.to_owned(), port });
        let addresses = (host, port).to_socket_addrs().map_err(|error| errors.resolve(error))?;
        let stream = connect_to_any(addresses).map_err(|error| errors.open(error))?;
        Ok(Self { stream, timeout: None, errors })
    }

    fn set_timeout(&mut self, timeout: Duration) -> io::Result<()> {
        let timeout = Some(timeout.max(SHORTEST_WAIT));
        if self.timeout != timeout {
            self.stream.set_read_timeout(timeout)?;
            self.timeout = timeout;
        }
        Ok(())
    }

    fn read_once(&mut self, buffer: &mut [u8]) -> Result<usize, LinkError> {
        loop {
            match self.stream.read(buffer) {
                Ok(0) => return Err(self.errors.closed()),
                Ok(length) => return Ok(length),
                Err(error) if is_timeout(&error) => return Ok(0),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(self.errors.read(error)),
            }
        }
    }

    fn read_away(&mut self) -> Result<(), LinkError> {
        let mut rubbish = [0; DISCARD_SIZE];
        for _ in 0..DISCARD_LIMIT {
            if self.read_once(&mut rubbish)? == 0 {
                break;
            }
        }
        Ok(())
    }
}

impl Link for TcpLink {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.stream.write_all(bytes).map_err(|error| self.errors.write(error))
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        if buffer.is_empty() {
            return Ok(0);
        }
        self.set_timeout(timeout).map_err(|error| self.errors.read(error))?;
        self.read_once(buffer)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.stream.set_nonblocking(true).map_err(|error| self.errors.read(error))?;
        let discarded = self.read_away();
        self.stream.set_nonblocking(false).map_err(|error| self.errors.read(error))?;
        discarded
    }
}

/// The first of the addresses that answers, or what went wrong with the last.
fn connect_to_any(addresses: impl Iterator<Item = SocketAddr>) -> io::Result<TcpStream> {
    let mut failure = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
    for address in addresses {
        match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT) {
            Ok(stream) => {
                // A request is nine bytes, and somebody waits for the reply.
                stream.set_nodelay(true)?;
                stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
                return Ok(stream);
            }
            Err(error) => failure = error,
        }
    }
    Err(failure)
}
