//! The module as a state machine: bytes, ticks, and work in the background.

use tmcl_tables::{Command, GlobalParameter, Status};
use tmcl_vm::{Halt, NeverHalt, Vm};
use tmcl_wire::{Event, Reply, Request};

use crate::application::{Halted, ProgramJob, Refusal};
use crate::axis::Axis;
use crate::coordinates::Coordinates;
use crate::dispatch::{Origin, Outcome, POSITION_REACHED_MASK};
use crate::download::Download;
use crate::events::{Events, Sources};
use crate::globals::Globals;
use crate::jobs::{Job, Pending};
use crate::port::{Envelope, PORTS, Port, PortId};

/// A module.
#[derive(Clone, Debug)]
pub struct Firmware<A: Axis> {
    pub(crate) axis: A,
    pub(crate) globals: Globals,
    pub(crate) coordinates: Coordinates,
    pub(crate) vm: Vm,
    pub(crate) programs: A::Programs,
    pub(crate) download: Option<Download>,
    pub(crate) program_job: Option<ProgramJob>,
    pub(crate) refusal: Option<Refusal>,
    pub(crate) sources: Sources,
    pub(crate) instructions_per_tick: u16,
    /// How many of them are executed; not 0 only while a debugger halts among them.
    pub(crate) executed: u16,
    pub(crate) ticks: u64,
    pub(crate) ports: [Port; PORTS],
    pub(crate) pending: Option<Pending>,
    /// What the axis keeps by itself.
    pub(crate) upkeep: Option<Job>,
}

impl<A: Axis> Firmware<A> {
    /// A module with these settings; [`Firmware::power_on`] reads them from storage.
    pub(crate) fn with(axis: A, globals: Globals, coordinates: Coordinates) -> Self {
        Self {
            axis,
            globals,
            coordinates,
            vm: Vm::default(),
            programs: A::Programs::default(),
            download: None,
            program_job: None,
            refusal: None,
            sources: Sources::default(),
            instructions_per_tick: 1,
            executed: 0,
            ticks: 0,
            ports: [const { Port::new() }; PORTS],
            pending: None,
            upkeep: None,
        }
    }

    /// One control period of 50 µs: what the sensors say comes in, what the power stage shall do goes out.
    pub fn tick(&mut self, sensed: &A::Sensed) -> A::Drive {
        // Nothing halts here.
        let _ = self.run_program(&mut NeverHalt);
        self.drive(sensed)
    }

    /// [`Firmware::tick`] with a debugger that looks on.
    ///
    /// # Errors
    /// [`Halted`] when it wants to look before an instruction. No time has passed then; a call of [`Firmware::tick`] goes on
    /// as if nobody had looked.
    pub fn tick_unless(
        &mut self,
        sensed: &A::Sensed,
        halt: &mut impl Halt<Self>,
    ) -> Result<A::Drive, Halted> {
        self.run_program(halt)?;
        Ok(self.drive(sensed))
    }

    fn drive(&mut self, sensed: &A::Sensed) -> A::Drive {
        self.ticks = self.ticks.wrapping_add(1);
        let mut events = Events::default();
        let drive = self.axis.tick(sensed, &mut events);
        if events != Events::default() {
            self.take_note(events);
        }
        self.report_position_reached();
        drive
    }

    /// Whether another control period with these sensors would change nothing but the time, at least for
    /// [`Firmware::quiet_ticks`] of them.
    #[must_use]
    pub fn is_idle(&self, sensed: &A::Sensed) -> bool {
        self.pending.is_none() && self.program_rests() && self.axis.is_idle(sensed)
    }

    /// Lets `ticks` control periods pass in which nothing changes ([`Firmware::is_idle`]).
    pub fn skip(&mut self, ticks: u64) {
        self.ticks = self.ticks.wrapping_add(ticks);
        self.axis.skip(ticks);
        self.pass_timers();
    }

    /// How long every port's line may be silent within a datagram before what came of it is dropped; 100 ms by default.
    ///
    /// Where time does not run as fast as the clients' does, 100 ms of theirs are another number of ticks.
    pub fn set_silence(&mut self, ticks: u64) {
        for port in &mut self.ports {
            port.silence_ticks = ticks;
        }
    }

    /// How many instructions of a program a control period executes; 1 by default (decision: the manuals are silent).
    pub fn set_instructions_per_tick(&mut self, instructions: u16) {
        self.instructions_per_tick = instructions;
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
        self.end_download(port);
        if let Some(pending) = self.pending.as_mut().filter(|pending| pending.port == port) {
            pending.envelope.answer = false;
        }
    }

    /// The axis, for those who look on.
    #[must_use]
    pub fn axis(&self) -> &A {
        &self.axis
    }

    /// What GGP would read, for those who look on: no random number is drawn. None where GGP would read nothing.
    #[must_use]
    pub fn peek_global(&self, bank: u8, number: u8) -> Option<i32> {
        A::SPEC.global_parameter(bank, number).filter(|spec| spec.parameter.access.read)?;
        if bank == crate::globals::VARIABLE_BANK {
            return Some(self.globals.variable(number));
        }
        let parameter = GlobalParameter::from_address(bank, number)?;
        Some(self.globals.peek(parameter, self.ticks, self.program_status()))
    }

    fn port_mut(&mut self, port: PortId) -> Option<&mut Port> {
        self.ports.get_mut(port.index())
    }

    /// Executes what waits in a port's inbox, until a request has to wait for the storage.
    pub(crate) fn serve(&mut self, port: PortId) {
        while !self.has_background_work() {
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
        match self.execute(request, Origin::Host(port)) {
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
            Ok(Outcome::Instruction(instruction)) => {
                if let Some(port) = self.port_mut(port) {
                    port.instruction(envelope, instruction);
                }
            }
            Ok(Outcome::Silence) => {}
            Ok(Outcome::SilentJob(job)) => {
                let envelope = Envelope { answer: false, ..envelope };
                self.pending = Some(Pending { port, envelope, reply: reply(Status::Ok, 0), job });
            }
            Ok(Outcome::Job(job, value)) => {
                self.pending = Some(Pending { port, envelope, reply: reply(Status::Ok, value), job });
            }
            Ok(Outcome::Loaded(job, value)) => {
                self.pending = Some(Pending { port, envelope, reply: reply(Status::Loaded, value), job });
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

    pub(crate) fn answer(&mut self, port: PortId, envelope: Envelope, reply: Reply) {
        if let Some(port) = self.port_mut(port) {
            port.reply(envelope, reply);
        }
    }

    /// The second reply of command 138 (TMCM-1311 §5.7.37), one for each request, under the addresses that count by now.
    pub(crate) fn report_position_reached(&mut self) {
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
}

/// SGP 255, 0 is answered even while it suppresses every other reply, or nobody could see it end.
fn is_suppress_reply(request: &Request) -> bool {
    let (bank, number) = GlobalParameter::SuppressReply.address();
    request.command == Command::SetGlobalParameter.number() && request.kind == number && request.motor == bank
}
