//! What the server's threads share.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use virtual_bench::{Bench, ModuleId, PORTS, PortId};

use crate::pacer::{Advance, CaughtUp, Paced};
use crate::state::{State, StateError, Wear};

/// Something a user may want to hear about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// The machine is too slow for the speed asked for; this much wall-clock time was given up.
    Slipped(Duration),
    /// A client came while all of the module's ports were in use, and was sent away.
    Refused(String),
    /// A client came and could not be served; the next one may be.
    ClientFailed(String),
    /// What a module stored could not be written to its file. It is tried again.
    NotKept(String),
}

/// The module that all clients talk to.
pub(crate) const MODULE: ModuleId = ModuleId(0);

/// The bench behind its mutex, and who is connected.
pub(crate) struct Shared {
    paced: Mutex<Paced>,
    /// Each port's client, told when the module has something to say unasked.
    clients: Mutex<[Option<Sender<()>>; PORTS]>,
    stopping: AtomicBool,
    notify: Box<dyn Fn(Notice) + Send + Sync>,
}

impl Shared {
    pub(crate) fn new(
        bench: Bench,
        speed: f64,
        advance: Advance,
        notify: Box<dyn Fn(Notice) + Send + Sync>,
    ) -> Self {
        Self {
            paced: Mutex::new(Paced::new(bench, speed, advance, Instant::now())),
            clients: Mutex::new([const { None }; PORTS]),
            stopping: AtomicBool::new(false),
            notify,
        }
    }

    pub(crate) fn notify(&self, notice: Notice) {
        (self.notify)(notice);
    }

    pub(crate) fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::Acquire)
    }

    pub(crate) fn stop(&self) {
        self.stopping.store(true, Ordering::Release);
    }

    /// Takes a port for a client; `None` when all are taken.
    pub(crate) fn connect(&self, wake: Sender<()>) -> Option<PortId> {
        let mut clients = lock(&self.clients);
        let port = PortId::ALL.into_iter().find(|port| clients[port.index()].is_none())?;
        clients[port.index()] = Some(wake);
        Some(port)
    }

    /// Gives a port back.
    pub(crate) fn disconnect(&self, port: PortId) {
        lock(&self.paced).bench.disconnect(MODULE, port);
        lock(&self.clients)[port.index()] = None;
    }

    /// Bytes arrive from a client now; what the module answers is appended to `out`.
    pub(crate) fn exchange(&self, port: PortId, bytes: &[u8], out: &mut Vec<u8>) {
        let mut paced = lock(&self.paced);
        // The command meets the module as it is now, not as it was at the pacer's last tick.
        paced.catch_up(Instant::now());
        out.extend(paced.bench.exchange(MODULE, port, bytes));
        self.save(&mut paced);
    }

    /// What the module says unasked.
    pub(crate) fn drain(&self, port: PortId, out: &mut Vec<u8>) {
        let mut paced = lock(&self.paced);
        paced.bench.transmit(MODULE, port, out);
        self.save(&mut paced);
    }

    /// From now on the EEPROMs are kept there.
    pub(crate) fn keep(&self, state: State) {
        let mut paced = lock(&self.paced);
        paced.state = Some(state);
        self.save(&mut paced);
    }

    /// Files know what was stored before anybody is told that it was.
    fn save(&self, paced: &mut Paced) {
        if let Err(error) = paced.save() {
            self.notify(Notice::NotKept(error.to_string()));
        }
    }

    /// Everything stored is on the disk; and how worn the EEPROMs are.
    pub(crate) fn finish_state(&self) -> Result<Vec<Wear>, StateError> {
        let Paced { bench, state, .. } = &mut *lock(&self.paced);
        let Some(state) = state else { return Ok(Vec::new()) };
        state.finish(bench)?;
        Ok(state.wear(bench))
    }

    /// Brings virtual time up to now, and wakes the clients the module has something to say to.
    pub(crate) fn pace(&self) {
        loop {
            let mut paced = lock(&self.paced);
            let caught_up = paced.catch_up(Instant::now());
            self.save(&mut paced);
            let speaking = PortId::ALL.map(|port| paced.bench.has_output(MODULE, port));
            drop(paced);
            self.wake(speaking);
            match caught_up {
                CaughtUp::Yes => return,
                CaughtUp::NotYet if self.is_stopping() => return,
                CaughtUp::NotYet => std::thread::yield_now(),
                CaughtUp::Slipped(by) => return self.notify(Notice::Slipped(by)),
            }
        }
    }

    fn wake(&self, speaking: [bool; PORTS]) {
        if speaking == [false; PORTS] {
            return;
        }
        let clients = lock(&self.clients);
        for (client, _) in clients.iter().zip(speaking).filter(|(_, speaks)| *speaks) {
            if let Some(client) = client {
                // A client that has just gone hears nothing any more.
                let _ = client.send(());
            }
        }
    }
}

/// A thread that panicked left plain data behind, which is as good as any.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
