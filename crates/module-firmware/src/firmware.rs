//! The module as a state machine: bytes, ticks, and work in the background.

use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_wire::{Event, Reply, Request};

use crate::axis::Axis;
use crate::calculator::Registers;
use crate::coordinates::Coordinates;
use crate::dispatch::{Outcome, POSITION_REACHED_MASK};
use crate::globals::Globals;
use crate::port::{Envelope, PORTS, Port, PortId};
use crate::storage::{RecordKey, Storage, StorageError, read_value, write_value};

/// A module.
#[derive(Clone, Debug)]
pub struct Firmware<A: Axis> {
    pub(crate) axis: A,
    pub(crate) globals: Globals,
    pub(crate) coordinates: Coordinates,
    pub(crate) registers: Registers,
    pub(crate) ticks: u64,
    ports: [Port; PORTS],
    pending: Option<Pending>,
}

/// A request whose reply waits for the storage.
#[derive(Clone, Copy, Debug)]
struct Pending {
    port: PortId,
    envelope: Envelope,
    reply: Reply,
    job: Job,
}

/// What the storage shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Job {
    /// Write a record.
    Write(RecordKey, i32),
    /// Read an axis parameter back, or its default where none is stored.
    RestoreAxisParameter(u8),
    /// Read a user variable back, or 0 where none is stored.
    RestoreVariable(u8),
    /// Write coordinates `next..=last`, one a call.
    StoreCoordinates { next: u8, last: u8 },
    /// Read coordinates `first..=last` back.
    RestoreCoordinates { first: u8, last: u8 },
    /// Spoil the magic number and start anew, which finds the spoiled number and takes the factory settings.
    FactoryReset,
    /// Start anew.
    Restart,
}

/// How far a job got in one call.
enum Progress {
    /// Call again with this.
    More(Job),
    /// Done.
    Done,
    /// Done, and everything starts anew.
    Restart,
}

impl<A: Axis> Firmware<A> {
    /// A module with these settings; [`Firmware::power_on`] reads them from storage.
    pub(crate) fn with(axis: A, globals: Globals, coordinates: Coordinates) -> Self {
        Self {
            axis,
            globals,
            coordinates,
            registers: Registers::default(),
            ticks: 0,
            ports: [const { Port::new() }; PORTS],
            pending: None,
        }
    }

    /// One control period of 50 µs: what the sensors say comes in, what the power stage shall do goes out.
    pub fn tick(&mut self, sensed: &A::Sensed) -> A::Drive {
        self.ticks = self.ticks.wrapping_add(1);
        let drive = self.axis.tick(sensed);
        self.report_position_reached();
        drive
    }

    /// Whether another control period with these sensors would change nothing but the time.
    #[must_use]
    pub fn is_idle(&self, sensed: &A::Sensed) -> bool {
        self.pending.is_none() && self.axis.is_idle(sensed)
    }

    /// Lets `ticks` control periods pass in which nothing changes ([`Firmware::is_idle`]).
    pub fn skip(&mut self, ticks: u64) {
        self.ticks = self.ticks.wrapping_add(ticks);
    }

    /// How long every port's line may be silent within a datagram before what came of it is dropped; 100 ms by default.
    ///
    /// Where time does not run as fast as the clients' does, 100 ms of theirs are another number of ticks.
    pub fn set_silence(&mut self, ticks: u64) {
        for port in &mut self.ports {
            port.silence_ticks = ticks;
        }
    }

    /// A byte arrives at a port. False when the port has no room for it now: a UART loses it, USB offers it again later.
    ///
    /// Bounded work: at most what the inbox holds is executed, seven requests.
    #[must_use]
    pub fn receive(&mut self, port: PortId, byte: u8) -> bool {
        let taken = self.port_mut(port).is_some_and(|port| port.push(byte));
        self.serve(port);
        taken
    }

    /// The next byte that leaves a port.
    pub fn transmit(&mut self, port: PortId) -> Option<u8> {
        self.port_mut(port)?.pop()
    }

    /// Whether bytes wait to leave a port.
    #[must_use]
    pub fn has_output(&self, port: PortId) -> bool {
        self.ports.get(port.index()).is_some_and(Port::has_output)
    }

    /// The client at a port went away: what it left half-said or unread is forgotten.
    pub fn disconnect(&mut self, port: PortId) {
        if let Some(port) = self.port_mut(port) {
            port.clear();
        }
        if let Some(pending) = self.pending.as_mut().filter(|pending| pending.port == port) {
            pending.envelope.answer = false;
        }
    }

    /// What takes long: at most one record is written, and then its reply sent. True while there is more to do.
    pub fn background<S: Storage>(&mut self, storage: &mut S) -> bool {
        if let Some(pending) = self.pending.take() {
            self.work(pending, storage);
        }
        if self.pending.is_none() {
            PortId::ALL.into_iter().for_each(|port| self.serve(port));
            // Events that found no room may find some now.
            self.report_position_reached();
        }
        self.pending.is_some()
    }

    /// Whether [`Firmware::background`] has something to do.
    #[must_use]
    pub fn has_background_work(&self) -> bool {
        self.pending.is_some()
    }

    /// The axis, for those who look on.
    #[must_use]
    pub fn axis(&self) -> &A {
        &self.axis
    }

    fn port_mut(&mut self, port: PortId) -> Option<&mut Port> {
        self.ports.get_mut(port.index())
    }

    /// Executes what waits in a port's inbox, until a request has to wait for the storage.
    fn serve(&mut self, port: PortId) {
        while self.pending.is_none() {
            let address = self.globals.byte(GlobalParameter::SerialAddress);
            let secondary = self.globals.byte(GlobalParameter::SerialSecondaryAddress);
            let ticks = self.ticks;
            let event = self.port_mut(port).and_then(|port| port.next_event(ticks, address, secondary));
            match event {
                None => break,
                Some(Event::WrongChecksum) => {
                    let envelope = self.envelope(address, false);
                    self.answer(port, envelope, Reply::WRONG_CHECKSUM);
                }
                Some(Event::Request { address, request }) => self.serve_request(port, address, &request),
            }
        }
    }

    fn serve_request(&mut self, port: PortId, address: u8, request: &Request) {
        let envelope = self.envelope(address, is_suppress_reply(request));
        let reply = |status, value| Reply { status, command: request.command, value };
        match self.execute(request) {
            Err(status) => self.answer(port, envelope, reply(status, 0)),
            Ok(Outcome::Done(value)) => self.answer(port, envelope, reply(Status::Ok, value)),
            Ok(Outcome::VersionString) => {
                if let Some(port) = self.port_mut(port) {
                    port.version_string(envelope, A::SPEC.version_string);
                }
            }
            Ok(Outcome::AwaitPosition) => {
                self.answer(port, envelope, reply(Status::Ok, POSITION_REACHED_MASK));
                if let Some(port) = self.port_mut(port).filter(|_| envelope.answer) {
                    port.awaits_position = port.awaits_position.saturating_add(1);
                }
                self.report_position_reached();
            }
            Ok(Outcome::Silence) => {}
            Ok(Outcome::SilentJob(job)) => {
                let envelope = Envelope { answer: false, ..envelope };
                self.pending = Some(Pending { port, envelope, reply: reply(Status::Ok, 0), job });
            }
            Ok(Outcome::Job(job, value)) => {
                self.pending = Some(Pending { port, envelope, reply: reply(Status::Ok, value), job });
            }
        }
    }

    fn envelope(&self, address: u8, always: bool) -> Envelope {
        let module = self.globals.byte(GlobalParameter::SerialAddress);
        let suppressed = self.globals.setting(GlobalParameter::SuppressReply) != 0;
        Envelope {
            host: self.globals.byte(GlobalParameter::HostAddress),
            module,
            answer: address == module && (always || !suppressed),
        }
    }

    fn answer(&mut self, port: PortId, envelope: Envelope, reply: Reply) {
        if let Some(port) = self.port_mut(port) {
            port.reply(envelope, reply);
        }
    }

    /// The second reply of command 138 (TMCM-1311 §5.7.37), one for each request, under the addresses that count by now.
    fn report_position_reached(&mut self) {
        if self.ports.iter().all(|port| port.awaits_position == 0) || !self.axis.is_position_reached() {
            return;
        }
        let envelope = self.envelope(self.globals.byte(GlobalParameter::SerialAddress), false);
        let reply = Reply {
            status: Status::Delayed,
            command: Command::RequestPositionReachedEvent.number(),
            value: POSITION_REACHED_MASK,
        };
        for port in &mut self.ports {
            while port.awaits_position > 0 && port.has_room() {
                port.reply(envelope, reply);
                port.awaits_position -= 1;
            }
        }
    }

    fn work<S: Storage>(&mut self, pending: Pending, storage: &mut S) {
        let Pending { port, envelope, reply, job } = pending;
        match self.step(job, storage) {
            Ok(Progress::More(job)) => self.pending = Some(Pending { job, ..pending }),
            Ok(Progress::Done) => self.answer(port, envelope, reply),
            Ok(Progress::Restart) => {
                self.answer(port, envelope, reply);
                self.restart(storage);
            }
            Err(_) => {
                let refusal = Reply { status: Status::NotAvailable, value: 0, ..reply };
                self.answer(port, envelope, refusal);
            }
        }
    }

    fn step<S: Storage>(&mut self, job: Job, storage: &mut S) -> Result<Progress, StorageError> {
        match job {
            Job::Write(key, value) => write_value(storage, key, value)?,
            Job::RestoreAxisParameter(number) => self.restore_axis_parameter(number, storage),
            Job::RestoreVariable(number) => {
                let value = read_value(storage, RecordKey::Global(crate::globals::VARIABLE_BANK, number));
                self.globals.set_variable(number, value.unwrap_or(0));
            }
            Job::StoreCoordinates { next, last } => {
                write_value(storage, RecordKey::Coordinate(next), self.coordinates.get(next))?;
                if next < last {
                    return Ok(Progress::More(Job::StoreCoordinates { next: next + 1, last }));
                }
            }
            Job::RestoreCoordinates { first, last } => {
                for number in first..=last {
                    let value = read_value(storage, RecordKey::Coordinate(number));
                    self.coordinates.set(number, value.unwrap_or(0));
                }
            }
            Job::FactoryReset => {
                let (bank, number) = GlobalParameter::EepromMagic.address();
                write_value(storage, RecordKey::Global(bank, number), 0)?;
                return Ok(Progress::Restart);
            }
            Job::Restart => return Ok(Progress::Restart),
        }
        Ok(Progress::Done)
    }

    /// As after power-on, but for replies that are still on their way out.
    fn restart<S: Storage>(&mut self, storage: &mut S) {
        let mut ports = self.ports.clone();
        ports.iter_mut().for_each(Port::restart);
        *self = Self { ports, ..Self::power_on(storage) };
    }
}

/// SGP 255, 0 is answered even while it suppresses every other reply, or nobody could see it end.
fn is_suppress_reply(request: &Request) -> bool {
    let (bank, number) = GlobalParameter::SuppressReply.address();
    request.command == Command::SetGlobalParameter.number() && request.kind == number && request.motor == bank
}
