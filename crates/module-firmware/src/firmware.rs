//! The module as a state machine: bytes, ticks, and work in the background.

use tmcl_tables::GlobalParameter;
use tmcl_vm::{Halt, NeverHalt, Vm};
use tmcl_wire::can;

use crate::application::{Halted, ProgramJob, Refusal};
use crate::axis::Axis;
use crate::coordinates::Coordinates;
use crate::download::Download;
use crate::events::{Events, Sources};
use crate::globals::Globals;
use crate::heartbeat::Heartbeat;
use crate::jobs::{Job, Pending};
use crate::line::{Line, Rates};
use crate::port::{PORTS, Port, PortId};

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
    /// Whether ports begin in ASCII mode: bit 0 of global parameter 67 as it was at power-on.
    pub(crate) starts_in_ascii: bool,
    pub(crate) rates: Rates,
    pub(crate) heartbeat: Heartbeat,
    pub(crate) pending: Option<Pending>,
    /// What the axis keeps by itself.
    pub(crate) upkeep: Option<Job>,
}

impl<A: Axis> Firmware<A> {
    /// A module with the factory settings; [`Firmware::power_on`] reads what is stored over them.
    pub(crate) fn as_made() -> Self {
        let globals = Globals::new(A::SPEC);
        let rates = Rates::of(&globals);
        Self {
            axis: A::default(),
            globals,
            coordinates: Coordinates::new(),
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
            starts_in_ascii: false,
            rates,
            heartbeat: Heartbeat::OFF,
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
        self.check_heartbeat();
        let mut events = Events::default();
        let drive = self.axis.tick(sensed, &mut events);
        if events != Events::default() {
            self.take_note(events);
        }
        self.report_position_reached();
        self.settle_rates();
        drive
    }

    /// Whether another control period with these sensors would change nothing but the time, at least for
    /// [`Firmware::quiet_ticks`] of them.
    #[must_use]
    pub fn is_idle(&self, sensed: &A::Sensed) -> bool {
        self.pending.is_none()
            && self.program_rests()
            && self.line_quiet_ticks() > 0
            && self.axis.is_idle(sensed)
    }

    /// Control periods until the program, the axis or a line goes on by itself, while [`Firmware::is_idle`]: a reply may leave
    /// at the end of the one after them, when its pause is over.
    #[must_use]
    pub fn quiet_ticks(&self) -> u64 {
        self.program_quiet_ticks().min(self.axis.quiet_ticks()).min(self.line_quiet_ticks())
    }

    /// Lets `ticks` control periods pass in which nothing changes ([`Firmware::is_idle`]).
    pub fn skip(&mut self, ticks: u64) {
        self.ticks = self.ticks.wrapping_add(ticks);
        self.axis.skip(ticks);
        self.pass_timers();
    }

    /// How many instructions of a program a control period executes; 1 by default (decision: the manuals are silent).
    pub fn set_instructions_per_tick(&mut self, instructions: u16) {
        self.instructions_per_tick = instructions;
    }

    /// A byte arrives at a port. False when the port has no room for it now: a UART loses it, USB offers it again later. A
    /// line that is not listened to (global parameter 88), or carries frames, takes everything and heeds nothing.
    ///
    /// Bounded work: at most what the inbox holds is executed, seven datagrams or as many lines as it has ends of lines.
    #[must_use]
    pub fn receive(&mut self, port: PortId, byte: u8) -> bool {
        if !self.hears(port, |line| line != Line::Can) {
            return true;
        }
        let taken = self.port_mut(port).is_some_and(|port| port.push(byte));
        self.serve(port);
        taken
    }

    /// A frame arrives at a port. False when the port has no room for it now. A line that is not listened to, or carries
    /// bytes, takes everything and heeds nothing.
    ///
    /// Bounded work: at most what the inbox holds is executed, six requests.
    #[must_use]
    pub fn receive_frame(&mut self, port: PortId, frame: &can::Frame) -> bool {
        if !self.hears(port, |line| line == Line::Can) {
            return true;
        }
        let taken = self.port_mut(port).is_some_and(|port| port.push_frame(frame));
        self.serve(port);
        taken
    }

    /// The next byte that leaves a port; none during the pause of global parameter 75.
    pub fn transmit(&mut self, port: PortId) -> Option<u8> {
        let ticks = self.ticks;
        let byte = self.port_mut(port)?.pop(ticks);
        self.settle_rates();
        byte
    }

    /// The next frame that leaves a port.
    pub fn transmit_frame(&mut self, port: PortId) -> Option<can::Frame> {
        let frame = self.port_mut(port)?.pop_frame();
        self.settle_rates();
        frame
    }

    /// Whether bytes may leave a port now.
    #[must_use]
    pub fn has_output(&self, port: PortId) -> bool {
        self.ports.get(port.index()).is_some_and(|port| port.has_output(self.ticks))
    }

    /// Whether frames may leave a port now.
    #[must_use]
    pub fn has_frame(&self, port: PortId) -> bool {
        self.ports.get(port.index()).is_some_and(Port::has_frame)
    }

    /// The client at a port went away: what it left half-said or unread is forgotten, and the port is in the mode it was in at
    /// power-on, binary or ASCII (decision).
    pub fn disconnect(&mut self, port: PortId) {
        if let Some(port) = self.port_mut(port) {
            port.clear();
        }
        self.start_port(port);
        self.end_download(port);
        if let Some(pending) = self.pending.as_mut().filter(|pending| pending.port == port) {
            pending.envelope.answer = false;
        }
        self.settle_rates();
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

    /// Whether somebody listens at a port, which has a line of some kind.
    fn hears(&self, port: PortId, kind: impl Fn(Line) -> bool) -> bool {
        self.ports.get(port.index()).is_some_and(|port| kind(port.line) && self.listens_to(port.line))
    }

    pub(crate) fn port_mut(&mut self, port: PortId) -> Option<&mut Port> {
        self.ports.get_mut(port.index())
    }
}
