//! The TMCM-1311: one axis for a two-phase stepper, TMC262 driver, incremental encoder.
//!
//! In open loop the field goes where the ramp generator says, or pulses from outside ([`step_dir`]); in closed loop
//! ([`closed_loop`]) it follows the rotor. Currents, stop switches, reference search, I²t and the stop on deviation serve both.

mod closed_loop;
mod deviation;
mod driver;
mod encoder;
mod exchange;
mod i2t;
mod motion;
mod parameters;
mod ports;
mod prepared;
mod pulse_meter;
mod search;
mod standstill;
mod step_dir;
mod switches;

use motion_control::closed_loop::tachometer::Tachometer;
use motion_control::homing::Search;
use motion_control::i2t::I2t;
use motion_control::ramp::Ramp;
pub use tmcl_tables::tmcm_1311::{AxisParameter, Port};
use tmcl_tables::{Interrupt, ModuleSpec, tmcm_1311 as tables};
use tmcl_vm::WaitEvent;

use crate::axis::{Axis, Motion, Refused};
use crate::events::Events;
use crate::program_memory::Programs;
use crate::values::Values;

use closed_loop::Operation;
pub use driver::{ChipSettings, CoolStep, DriverStatus};
pub use exchange::{Drive, Sensed};
use prepared::Prepared;
use standstill::Standstill;
use step_dir::StepDir;

/// Microsteps of 1/256 full step in a full step.
const MICROSTEPS: i32 = 256;

/// What the motor is doing (§6, AP 128). Torque mode needs the closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RampMode {
    Position,
    Velocity,
    Torque,
}

/// The axis.
#[derive(Clone, Debug)]
pub struct Tmcm1311 {
    /// Parameters that are what was written to them.
    kept: Values<{ AxisParameter::COUNT }>,
    prepared: Prepared,
    ramp: Ramp,
    mode: RampMode,
    target_position: i32,
    target_velocity: i32,
    /// The reference search that runs.
    search: Option<Search>,
    /// Who decides where the field stands.
    operation: Operation,
    /// What the last encoder detection came to (AP 132).
    detection_state: i32,
    /// The current of the initialisation of the closed loop, in 1/256 of AP 6.
    alignment_current: u8,
    /// In closed loop: whether the last control period changed nothing, and nothing was set since.
    settled: bool,
    /// Where the field stands, in 1/256 full steps; 1024 make an electrical period.
    phase: u16,
    tachometer: Tachometer,
    /// AP 209 less the raw encoder count.
    encoder_offset: i32,
    outputs: u8,
    /// Global parameter 79.
    reversed_switches: bool,
    /// A deviation switched the current off.
    switched_off: bool,
    standstill: Standstill,
    step_dir: StepDir,
    i2t: I2t,
    sensed: Sensed,
}

impl Default for Tmcm1311 {
    fn default() -> Self {
        let mut kept = Values::zero();
        for parameter in AxisParameter::ALL {
            kept.set(parameter.index(), parameter.spec().default_bits());
        }
        let i2t = I2t::new(i2t::window_ticks(&kept));
        Self {
            prepared: Prepared::new(&kept),
            kept,
            ramp: Ramp::default(),
            mode: RampMode::Position,
            target_position: 0,
            target_velocity: 0,
            search: None,
            operation: Operation::Open,
            detection_state: 0,
            alignment_current: 0,
            settled: false,
            phase: 0,
            tachometer: Tachometer::new(0),
            encoder_offset: 0,
            outputs: 0,
            reversed_switches: false,
            switched_off: false,
            standstill: Standstill::default(),
            step_dir: StepDir::default(),
            i2t,
            sensed: Sensed::default(),
        }
    }
}

impl Axis for Tmcm1311 {
    const SPEC: &'static ModuleSpec = &tables::SPEC;
    type Parameter = AxisParameter;
    type Port = Port;
    type Sensed = Sensed;
    type Drive = Drive;
    type Programs = Programs<{ tables::SPEC.program_memory as usize }>;

    fn is_idle(&self, sensed: &Sensed) -> bool {
        self.search.is_none()
            && self.sensed == *sensed
            && self.tachometer.is_at_rest()
            && self.is_settled()
            && self.pulses_rest()
            && self.quiet_ticks() > 0
    }

    fn quiet_ticks(&self) -> u64 {
        match self.closed() {
            None => self.quiet_standstill().min(self.quiet_i2t()),
            Some(_) => self.quiet_i2t(),
        }
    }

    fn skip(&mut self, ticks: u64) {
        if self.is_open_loop() {
            self.standstill.skip(ticks);
        }
        self.tachometer.skip(ticks);
        self.skip_i2t(ticks);
    }

    fn tick(&mut self, sensed: &Sensed, events: &mut Events) -> Drive {
        self.sensed = *sensed;
        self.tachometer.tick(sensed.encoder_counts);
        self.watch_i2t();
        self.clear_encoder_on_null();
        self.follow_rotor();
        events.stall_stop = self.stop_on_stall();
        events.deviation_stop = self.stop_on_deviation();
        match self.operation {
            Operation::Open => self.tick_open_loop(),
            Operation::Detecting(_) => {
                self.detect_on();
                self.drive()
            }
            Operation::Aligning { .. } => {
                self.align_on();
                self.drive()
            }
            Operation::Closed(_) => {
                self.tick_closed_loop();
                self.drive()
            }
        }
    }

    fn get(&self, parameter: AxisParameter) -> i32 {
        self.parameter(parameter)
    }

    fn set(&mut self, parameter: AxisParameter, value: i32) -> Result<(), Refused> {
        self.settled = false;
        self.set_parameter(parameter, value)?;
        self.prepared = Prepared::new(&self.kept);
        Ok(())
    }

    fn motion(&mut self, motion: Motion) -> Result<(), Refused> {
        self.settled = false;
        match motion {
            Motion::Stop => self.abort_operation(),
            _ => self.require_obedience()?,
        }
        if self.in_step_dir_mode() {
            return self.motion_among_pulses(motion);
        }
        match motion {
            Motion::Rotate(velocity_pps) => self.turn(velocity_pps),
            Motion::Stop => self.turn(0),
            Motion::MoveTo(position) => self.move_to(position),
            Motion::MoveBy(offset) => self.move_to(self.relative_origin().wrapping_add(offset)),
        }
        Ok(())
    }

    fn start_search(&mut self) -> Result<(), Refused> {
        self.settled = false;
        self.require_obedience()?;
        self.need_ramp()?;
        self.begin_search()
    }

    fn stop_search(&mut self) {
        if self.search.is_some() {
            self.turn(0);
        }
    }

    fn search_state(&self) -> i32 {
        self.search.map_or(0, |search| search.state())
    }

    fn actual_position(&self) -> i32 {
        match self.closed() {
            None => self.ramp.position(),
            Some(_) => self.encoder_counter(),
        }
    }

    /// In open loop the flag means that the ramp stands exactly on the target (§6, AP 8), in closed loop that standstill mode
    /// is on (§8.5). A search that runs has none yet.
    fn is_position_reached(&self) -> bool {
        if self.closed().is_some() {
            return self.is_holding();
        }
        // A motor that a stop switch keeps from turning has reached nothing, even on the last target.
        let wants_to_turn = self.mode == RampMode::Velocity && self.target_velocity != 0;
        let stands = self.ramp.is_standing() && self.ramp.position() == self.target_position;
        let idle = self.search.is_none() && self.is_open_loop() && !self.is_pulsed();
        stands && !wants_to_turn && idle
    }

    fn has_happened(&self, event: WaitEvent) -> bool {
        match event {
            WaitEvent::PositionReached => self.is_position_reached(),
            WaitEvent::ReferenceSwitch => self.is_home_switch_active(),
            WaitEvent::LimitSwitch => self.is_left_switch_active() || self.is_right_switch_active(),
            WaitEvent::ReferenceSearch => self.search.is_none(),
        }
    }

    fn level(&self, interrupt: Interrupt) -> bool {
        use Interrupt as I;
        match interrupt {
            I::PositionReached => self.is_position_reached(),
            I::StopLeft => self.is_left_switch_active(),
            I::StopRight => self.is_right_switch_active(),
            I::Input0 => self.port_level(Port::In0) != 0,
            I::Input1 => self.port_level(Port::In1) != 0,
            I::Input2 => self.port_level(Port::In2) != 0,
            I::Input3 => self.port_level(Port::In3) != 0,
            I::Input4 => self.port_level(Port::In4) != 0,
            I::Input5 => self.port_level(Port::In5) != 0,
            I::Input6 => self.port_level(Port::In6) != 0,
            I::Input7 => self.port_level(Port::In7) != 0,
            // Timers are the firmware's, stops of the motor are events.
            I::Timer0 | I::Timer1 | I::Timer2 | I::Stallguard2 | I::Deviation => false,
        }
    }

    fn set_end_switch_polarity(&mut self, reversed: bool) {
        self.settled = false;
        self.reversed_switches = reversed;
    }

    fn port(bank: u8, number: u8) -> Option<Port> {
        Port::from_address(bank, number)
    }

    fn read_port(&self, port: Port) -> i32 {
        self.port_level(port)
    }

    fn write_port(&mut self, port: Port, high: bool) {
        self.set_port(port, high);
    }
}

impl Tmcm1311 {
    fn kept_value(&self, parameter: AxisParameter) -> i32 {
        self.kept.get(parameter.index())
    }
}
