//! What the server's threads share.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use virtual_bench::{Bench, PORTS, PortId, Wiring};

use crate::pacer::{Advance, CaughtUp, Paced};
use crate::state::{State, StateError, Wear};

/// Something a user may want to hear about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// The machine is too slow for the speed asked for; this much wall-clock time was given up.
    Slipped(Duration),
    /// A client came while all lines were in use, and was sent away.
    Refused(String),
    /// A client came and could not be served; the next one may be.
    ClientFailed(String),
    /// What a module stored could not be written to its file. It is tried again.
    NotKept(String),
    /// What the modules say does not get out to a CAN bus, and is lost until there is room again.
    NotSent(String),
}

/// The bench behind its mutex, and who is connected.
pub(crate) struct Shared {
    paced: Mutex<Paced>,
    /// Each line's client, told when there is something to read unasked.
    clients: Mutex<[Option<SyncSender<()>>; PORTS]>,
    /// How long a line without a rate may be silent within a datagram, in virtual time.
    silence_ns: u64,
    stopping: AtomicBool,
    notify: Box<dyn Fn(Notice) + Send + Sync>,
}

impl Shared {
    pub(crate) fn new(
        bench: Bench,
        speed: f64,
        silence_ns: u64,
        advance: Advance,
        notify: Box<dyn Fn(Notice) + Send + Sync>,
    ) -> Self {
        Self {
            paced: Mutex::new(Paced::new(bench, speed, advance, Instant::now())),
            clients: Mutex::new([const { None }; PORTS]),
            silence_ns,
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

    /// Takes a line for a client and wires it; `None` when all are taken.
    pub(crate) fn connect(&self, wake: SyncSender<()>, wiring: Wiring) -> Option<PortId> {
        let mut clients = lock(&self.clients);
        let line = PortId::ALL.into_iter().find(|line| clients[line.index()].is_none())?;
        clients[line.index()] = Some(wake);
        let bench = &mut lock(&self.paced).bench;
        // Where bytes take their time, the rate says how long silence may last; where they do not, the client's clock does.
        // Frames need neither.
        if matches!(wiring, Wiring::Usb | Wiring::Rs485 { baud: None }) {
            bench.set_silence_ns(self.silence_ns);
        }
        bench.wire(line, wiring);
        Some(line)
    }

    /// Gives a line back.
    pub(crate) fn disconnect(&self, line: PortId) {
        lock(&self.paced).bench.hang_up(line);
        lock(&self.clients)[line.index()] = None;
    }

    /// Something is done to the bench as it is now.
    pub(crate) fn exchange<T>(&self, with: impl FnOnce(&mut Bench) -> T) -> T {
        let mut paced = lock(&self.paced);
        // A command meets the module as it is now, not as it was at the pacer's last tick.
        paced.catch_up(Instant::now());
        let done = with(&mut paced.bench);
        self.save(&mut paced);
        done
    }

    /// What there is to read unasked is taken.
    pub(crate) fn drain(&self, take: impl FnOnce(&mut Bench)) {
        let mut paced = lock(&self.paced);
        take(&mut paced.bench);
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

    /// Brings virtual time up to now, and wakes the clients that have something to read.
    pub(crate) fn pace(&self) {
        loop {
            let mut paced = lock(&self.paced);
            let caught_up = paced.catch_up(Instant::now());
            self.save(&mut paced);
            let speaking = PortId::ALL.map(|line| paced.bench.has_answer(line));
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
                // A client that has just gone hears nothing any more, and one that is being woken needs no second call.
                let _ = client.try_send(());
            }
        }
    }
}

/// A thread that panicked left plain data behind, which is as good as any.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
