//! A client on a line, whatever carries its bytes.

use std::io::{self, Read, Write};
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use virtual_bench::PortId;

use crate::protocol::Protocol;
use crate::shared::{Shared, lock};

/// Bytes read at once: some dozens of datagrams.
const READ_SIZE: usize = 512;

/// How long a client waits before bytes that found no room on the line are offered again.
const RETRY: Duration = Duration::from_millis(1);

/// A connected client, which gives its line back when it is dropped.
pub(crate) struct Connection<W, P> {
    shared: Arc<Shared>,
    line: PortId,
    /// Replies keep their order: whoever drains the line holds this until they are written.
    client: Arc<Mutex<Client<W, P>>>,
}

/// Where replies go, and how they are put.
struct Client<W, P> {
    writer: W,
    protocol: P,
}

impl<W: Write + Send + 'static, P: Protocol> Connection<W, P> {
    /// Takes a line for a client and starts the thread that writes what comes along it unasked; `None` when all lines are
    /// taken.
    pub(crate) fn open(shared: &Arc<Shared>, writer: W, protocol: P) -> Option<Self> {
        // One that is still to be heeded is as good as several.
        let (wake, woken) = sync_channel(1);
        let line = shared.connect(wake, protocol.wiring())?;
        let client = Arc::new(Mutex::new(Client { writer, protocol }));
        let connection = Self { shared: Arc::clone(shared), line, client };
        connection.start_writer(woken);
        Some(connection)
    }

    /// Serves the client until it goes.
    pub(crate) fn serve(self, mut reader: impl Read) -> io::Result<()> {
        self.answer_until_end(&mut reader)
    }

    fn answer_until_end(&self, reader: &mut impl Read) -> io::Result<()> {
        let mut buffer = [0; READ_SIZE];
        loop {
            let length = match reader.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(length) => length,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            if !self.answer(&buffer[..length])? {
                return Ok(());
            }
        }
    }

    /// False when the server stops.
    fn answer(&self, mut bytes: &[u8]) -> io::Result<bool> {
        let mut replies = Vec::new();
        loop {
            if self.shared.is_stopping() {
                return Ok(false);
            }
            let mut client = lock(&self.client);
            replies.clear();
            let protocol = &mut client.protocol;
            let taken = self.shared.exchange(|bench| protocol.hear(bytes, bench, self.line, &mut replies));
            client.writer.write_all(&replies)?;
            drop(client);
            bytes = bytes.get(taken..).unwrap_or_default();
            if bytes.is_empty() {
                return Ok(true);
            }
            std::thread::sleep(RETRY);
        }
    }

    /// Ends when the line is given back, which drops the sender.
    fn start_writer(&self, woken: Receiver<()>) {
        let (shared, line, client) = (Arc::clone(&self.shared), self.line, Arc::clone(&self.client));
        std::thread::spawn(move || {
            for () in woken {
                let mut client = lock(&client);
                let mut bytes = Vec::new();
                shared.drain(|bench| client.protocol.tell(bench, line, &mut bytes));
                if client.writer.write_all(&bytes).is_err() {
                    return; // the reading thread notices too, and gives the line back
                }
            }
        });
    }
}

impl<W, P> Drop for Connection<W, P> {
    fn drop(&mut self) {
        self.shared.disconnect(self.line);
    }
}
