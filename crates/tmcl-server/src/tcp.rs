//! TCP listeners: each client has a line of the bench to itself while it stays.

use std::io;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use virtual_bench::Wiring;

use crate::connection::Connection;
use crate::protocol::Plain;
use crate::shared::{Notice, Shared, lock};

/// How long a listener waits after a failure, and before it looks for a line again.
const RETRY: Duration = Duration::from_millis(100);

/// How long a client waits for a line where all are taken: another may just be leaving.
const PATIENCE: Duration = Duration::from_millis(300);

/// A listening socket and its clients.
pub(crate) struct Tcp {
    address: SocketAddr,
    clients: Arc<Mutex<Vec<TcpStream>>>,
}

impl Tcp {
    /// Listens at `address`, and serves every client in threads of its own.
    pub(crate) fn listen(shared: &Arc<Shared>, address: &[SocketAddr], wiring: Wiring) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let clients = Arc::new(Mutex::new(Vec::new()));
        let (shared, known) = (Arc::clone(shared), Arc::clone(&clients));
        std::thread::spawn(move || accept(&listener, &shared, &known, wiring));
        Ok(Self { address, clients })
    }

    /// Where it listens; the port is a real one even if 0 was asked for.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Wakes the listener, which sees that the server stops, and ends every client's connection.
    pub(crate) fn close(&self) {
        let _ = TcpStream::connect(self.address);
        for client in lock(&self.clients).drain(..) {
            let _ = client.shutdown(Shutdown::Both);
        }
    }
}

fn accept(
    listener: &TcpListener,
    shared: &Arc<Shared>,
    clients: &Arc<Mutex<Vec<TcpStream>>>,
    wiring: Wiring,
) {
    for stream in listener.incoming() {
        if shared.is_stopping() {
            return;
        }
        if let Err(error) = stream.and_then(|stream| welcome(stream, shared, clients, wiring)) {
            // One client's failure is no reason to turn the next away.
            shared.notify(Notice::ClientFailed(error.to_string()));
            // Too many open files, say, are still too many a microsecond later.
            std::thread::sleep(RETRY);
        }
    }
}

fn welcome(
    stream: TcpStream,
    shared: &Arc<Shared>,
    clients: &Arc<Mutex<Vec<TcpStream>>>,
    wiring: Wiring,
) -> io::Result<()> {
    // A reply is nine bytes, and the client waits for it.
    stream.set_nodelay(true)?;
    let peer = stream.peer_addr()?;
    let Some(connection) = line_for(&stream, shared, wiring)? else {
        shared.notify(Notice::Refused(peer.to_string()));
        return stream.shutdown(Shutdown::Both);
    };
    lock(clients).push(stream.try_clone()?);
    let clients = Arc::clone(clients);
    std::thread::spawn(move || {
        // A connection that breaks is a client that went.
        let _ = connection.serve(&stream);
        let _ = stream.shutdown(Shutdown::Both);
        lock(&clients).retain(|client| client.peer_addr().is_ok_and(|other| other != peer));
    });
    Ok(())
}

/// A line for a client, if there is one or one becomes free.
fn line_for(
    stream: &TcpStream,
    shared: &Arc<Shared>,
    wiring: Wiring,
) -> io::Result<Option<Connection<TcpStream, Plain>>> {
    let tries = PATIENCE.as_millis() / RETRY.as_millis();
    for _ in 0..tries {
        if let Some(connection) = Connection::open(shared, stream.try_clone()?, Plain::new(wiring)) {
            return Ok(Some(connection));
        }
        std::thread::sleep(RETRY);
    }
    Ok(Connection::open(shared, stream.try_clone()?, Plain::new(wiring)))
}
