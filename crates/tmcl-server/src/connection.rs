//! A client on a port, whatever carries its bytes.

use std::io::{self, Read, Write};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

use virtual_bench::PortId;

use crate::shared::{Shared, lock};

/// Bytes read at once: some dozens of datagrams.
const READ_SIZE: usize = 512;

/// A connected client, which gives its port back when it is dropped.
pub(crate) struct Connection<W> {
    shared: Arc<Shared>,
    port: PortId,
    /// Replies keep their order: whoever drains the module's port holds this until they are written.
    writer: Arc<Mutex<W>>,
}

impl<W: Write + Send + 'static> Connection<W> {
    /// Takes a port of the module for a client and starts the thread that writes what the module says unasked; `None`
    /// when all ports are taken.
    pub(crate) fn open(shared: &Arc<Shared>, writer: W) -> Option<Self> {
        let (wake, woken) = channel();
        let port = shared.connect(wake)?;
        let connection = Self { shared: Arc::clone(shared), port, writer: Arc::new(Mutex::new(writer)) };
        connection.start_writer(woken);
        Some(connection)
    }

    /// Serves the client until it goes.
    pub(crate) fn serve(self, mut reader: impl Read) -> io::Result<()> {
        self.answer_until_end(&mut reader)
    }

    fn answer_until_end(&self, reader: &mut impl Read) -> io::Result<()> {
        let mut buffer = [0; READ_SIZE];
        let mut replies = Vec::new();
        loop {
            let length = match reader.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(length) => length,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            if self.shared.is_stopping() {
                return Ok(());
            }
            let mut writer = lock(&self.writer);
            replies.clear();
            self.shared.exchange(self.port, &buffer[..length], &mut replies);
            writer.write_all(&replies)?;
        }
    }

    /// Ends when the port is given back, which drops the sender.
    fn start_writer(&self, woken: Receiver<()>) {
        let (shared, port, writer) = (Arc::clone(&self.shared), self.port, Arc::clone(&self.writer));
        std::thread::spawn(move || {
            for () in woken {
                let mut writer = lock(&writer);
                let mut bytes = Vec::new();
                shared.drain(port, &mut bytes);
                if writer.write_all(&bytes).is_err() {
                    return; // the reading thread notices too, and gives the port back
                }
            }
        });
    }
}

impl<W> Drop for Connection<W> {
    fn drop(&mut self) {
        self.shared.disconnect(self.port);
    }
}
