//! The server: a bench, its pacer, and its listeners.

use std::io;
use std::net::{SocketAddr, ToSocketAddrs};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use virtual_bench::{Bench, Wiring};

use crate::pacer::Advance;
#[cfg(unix)]
use crate::protocol::Plain;
use crate::shared::{Notice, Shared};
use crate::state::{State, StateError, Wear};
use crate::tcp::Tcp;

/// How often virtual time is brought up to date when nobody asks.
const PACE: Duration = Duration::from_millis(1);

/// How long a client may pause within a datagram before what came of it is dropped.
const LINE_SILENCE: Duration = Duration::from_millis(100);

/// Why a server does not listen where it was told to.
#[derive(Debug, thiserror::Error)]
pub enum ListenError {
    /// The host's name means nothing.
    #[error("cannot resolve {0}: {1}")]
    Resolve(String, #[source] io::Error),
    /// The address is taken, or not ours.
    #[error("cannot listen on {0}: {1}")]
    Bind(String, #[source] io::Error),
}

/// How a bench is served.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How fast virtual time runs, 1 being real time.
    pub speed: f64,
    /// What TCP clients and plain pseudo terminals are connected to.
    pub serial: Wiring,
    /// The baud rate of a line follows what the program at its pseudo terminal has set.
    pub follows_terminal: bool,
}

impl Default for Settings {
    /// In real time; the first module's ports, as if by USB.
    fn default() -> Self {
        Self { speed: 1.0, serial: Wiring::Usb, follows_terminal: false }
    }
}

/// A bench on ports. It stops when dropped, and takes its links with it.
pub struct Server {
    shared: Arc<Shared>,
    settings: Settings,
    pacer: Option<JoinHandle<()>>,
    tcp: Vec<Tcp>,
    #[cfg(unix)]
    ptys: Vec<crate::pty::Pty>,
}

impl Server {
    /// Starts pacing `bench` at `speed` times the wall clock. `notify` hears what a user may want to know; it is called
    /// from the server's threads.
    #[must_use]
    pub fn start(bench: Bench, speed: f64, notify: impl Fn(Notice) + Send + Sync + 'static) -> Self {
        let settings = Settings { speed, ..Settings::default() };
        Self::start_with(bench, settings, Box::new(Bench::advance_to), notify)
    }

    /// The same with settings, and with `advance` running the bench on: somebody who takes samples on the way. It is called
    /// with the bench locked, and clients wait for it.
    #[must_use]
    pub fn start_with(
        bench: Bench,
        settings: Settings,
        advance: Advance,
        notify: impl Fn(Notice) + Send + Sync + 'static,
    ) -> Self {
        let speed = settings.speed;
        // A client that pauses within a datagram does so by the wall clock.
        let silence_ns = (LINE_SILENCE.as_nanos() as f64 * speed) as u64;
        let shared = Arc::new(Shared::new(bench, speed, silence_ns, advance, Box::new(notify)));
        let paced = Arc::clone(&shared);
        let pacer = std::thread::spawn(move || {
            while !paced.is_stopping() {
                std::thread::sleep(PACE);
                paced.pace();
            }
        });
        Self {
            shared,
            settings,
            pacer: Some(pacer),
            tcp: Vec::new(),
            #[cfg(unix)]
            ptys: Vec::new(),
        }
    }

    /// From now on the modules' EEPROMs are kept there; the bench was made with what [`State::open`] gave.
    pub fn keep(&mut self, state: State) {
        self.shared.keep(state);
    }

    /// Stops, if it has not yet, with everything stored on the disk; and says how worn the EEPROMs are that are kept.
    ///
    /// # Errors
    /// [`StateError`] when something stored could not be written.
    pub fn finish(&mut self) -> Result<Vec<Wear>, StateError> {
        self.stop();
        self.shared.finish_state()
    }

    /// Listens at `address`, `host:port`; port 0 picks a free one. Returns where it really listens.
    ///
    /// # Errors
    /// [`ListenError`] when the address cannot be resolved or bound.
    pub fn listen_tcp(&mut self, address: &str) -> Result<SocketAddr, ListenError> {
        let addresses: Vec<_> = address
            .to_socket_addrs()
            .map_err(|error| ListenError::Resolve(address.to_owned(), error))?
            .collect();
        let tcp = Tcp::listen(&self.shared, &addresses, self.settings.serial)
            .map_err(|error| ListenError::Bind(address.to_owned(), error))?;
        let address = tcp.address();
        self.tcp.push(tcp);
        Ok(address)
    }

    /// Opens a pseudo terminal and links `path` to it.
    ///
    /// # Errors
    /// [`crate::PtyError`] when the path is taken or there is no terminal or port to be had.
    #[cfg(unix)]
    pub fn listen_pty(&mut self, path: &std::path::Path) -> Result<(), crate::PtyError> {
        let Settings { serial, follows_terminal, .. } = self.settings;
        let protocol = |controller: &std::fs::File| {
            Ok(match follows_terminal {
                false => Plain::new(serial),
                true => Plain::following(serial, crate::pty::baud_source(controller)?),
            })
        };
        self.serve_pty(path, protocol)
    }

    /// Opens a pseudo terminal that is a serial CAN adapter (slcan) on a CAN bus, and links `path` to it.
    ///
    /// # Errors
    /// [`crate::PtyError`], as with any pseudo terminal.
    #[cfg(unix)]
    pub fn listen_slcan(&mut self, path: &std::path::Path) -> Result<(), crate::PtyError> {
        self.serve_pty(path, |_| Ok(crate::slcan::Adapter::new()))
    }

    /// Lets the modules take part in the CAN bus at an interface of the system, such as `can0`.
    ///
    /// # Errors
    /// [`crate::CanError`] when the bus cannot be joined, or all lines are taken.
    pub fn join_can(&mut self, interface: &str) -> Result<(), crate::CanError> {
        crate::can_bus::join(&self.shared, interface)
    }
}

impl Server {
    /// Serves whoever opens a pseudo terminal. `protocol` gets our side of it.
    #[cfg(unix)]
    fn serve_pty<P: crate::protocol::Protocol>(
        &mut self,
        path: &std::path::Path,
        protocol: impl FnOnce(&std::fs::File) -> io::Result<P>,
    ) -> Result<(), crate::PtyError> {
        let (pty, reader) = crate::Pty::open(path)?;
        let protocol = protocol(&reader)?;
        let connection = crate::connection::Connection::open(&self.shared, reader.try_clone()?, protocol);
        let connection = connection.ok_or(crate::PtyError::NoPort)?;
        std::thread::spawn(move || {
            // The terminal is held open on our side, so this ends when the server does.
            let _ = connection.serve(reader);
        });
        self.ptys.push(pty);
        Ok(())
    }

    fn stop(&mut self) {
        let Some(pacer) = self.pacer.take() else { return };
        self.shared.stop();
        self.tcp.iter().for_each(Tcp::close);
        #[cfg(unix)]
        self.ptys.clear();
        // A pacer that panicked has said so already.
        let _ = pacer.join();
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
    }
}
