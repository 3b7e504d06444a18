//! The one dispatcher: what a request does, or which status refuses it.
//!
//! Two statuses fit at once: the first that applies in the order command, type, motor or bank, lock, value.

mod coordinates;
mod globals;
mod ports;

use coordinates::coordinate_number;
use globals::restore_global_parameter;
use tmcl_tables::{Access, Command, Mode, MotorField, ParameterSpec, Status, TypeField};
use tmcl_wire::Request;

use crate::axis::{Axis, Motion};
use crate::firmware::Firmware;
use crate::jobs::Job;
use crate::port::PortId;
use crate::program_memory::Instruction;
use crate::storage::RecordKey;

/// The value that commands 137 and 255 want to see.
const CONFIRMATION: i32 = 1234;

/// The mask of command 138: motor 0.
pub(crate) const POSITION_REACHED_MASK: i32 = 1;

/// The motor byte of SCO and GCO that means the EEPROM.
const COORDINATES_IN_EEPROM: u8 = 255;

/// What a request led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Done; the reply carries this value.
    Done(i32),
    /// The storage has to do something before the reply with this value.
    Job(Job, i32),
    /// The storage has to do something, and there is no reply.
    SilentJob(Job),
    /// An instruction was taken into the program; the storage has to keep it before the reply with this value.
    Loaded(Job, i32),
    /// The special reply of command 134.
    Instruction(Instruction),
    /// The special reply of command 136.
    VersionString,
    /// The reply of command 138, and another when the target position is reached.
    AwaitPosition,
    /// The port is in ASCII mode after the reply with this value, if it can be.
    AsciiMode(i32),
    /// Nothing at all.
    Silence,
}

pub(crate) type Executed = Result<Outcome, Status>;

impl<A: Axis> Firmware<A> {
    /// Executes a request of a host at a port: direct mode.
    pub(crate) fn execute_request(&mut self, request: &Request, port: PortId) -> Executed {
        if let Some(stored) = self.store_instruction(request, port) {
            return stored;
        }
        let command = admit::<A>(request, Mode::Direct)?;
        match self.control_application(command, request, port) {
            Some(controlled) => controlled,
            None => self.perform(command, request),
        }
    }

    /// Executes an instruction of the stand-alone program. None of them runs or steps a program, so that nothing here ever
    /// calls itself and a stack has a bound.
    pub(crate) fn execute_instruction(&mut self, request: &Request) -> Executed {
        let command = admit::<A>(request, Mode::Program)?;
        self.perform(command, request)
    }

    /// What a command does, whoever wants it done.
    fn perform(&mut self, command: Command, request: &Request) -> Executed {
        let &Request { kind, value, .. } = request;
        match command {
            Command::RotateRight => self.rotate(value, value),
            Command::RotateLeft => self.rotate(value.wrapping_neg(), value),
            Command::MotorStop => self.begin(Motion::Stop, value),
            Command::MoveToPosition => self.move_to_position(kind, value),
            Command::SetAxisParameter => self.set_axis_parameter(kind, value).map(|()| Outcome::Done(value)),
            Command::GetAxisParameter => self.get_axis_parameter(kind),
            Command::StoreAxisParameter => self.store_axis_parameter(kind, value),
            Command::RestoreAxisParameter => Ok(Outcome::Job(Job::RestoreAxisParameter(kind), value)),
            Command::SetGlobalParameter => self.set_global_parameter(request, value, value),
            Command::GetGlobalParameter => self.get_global_parameter(request),
            Command::StoreGlobalParameter => self.store_global_parameter(request),
            Command::RestoreGlobalParameter => restore_global_parameter::<A>(request),
            Command::SetOutput => self.set_output(request),
            Command::GetInput => self.get_input(request),
            Command::Calculate => {
                self.vm.registers.calculate(kind, value).ok_or(Status::WrongType)?;
                Ok(Outcome::Done(self.vm.registers.accumulator))
            }
            Command::CalculateX => {
                self.vm.registers.calculate_x(kind).ok_or(Status::WrongType)?;
                Ok(Outcome::Done(self.vm.registers.accumulator))
            }
            Command::SetCoordinate => self.set_coordinate(request),
            Command::GetCoordinate => self.get_coordinate(request),
            Command::CaptureCoordinate => self.write_coordinate(kind, self.axis.actual_position(), value),
            Command::AccumulatorToCoordinate => {
                let accumulator = self.vm.registers.accumulator;
                self.write_coordinate(kind, accumulator, accumulator)
            }
            Command::AccumulatorToAxisParameter => {
                let accumulator = self.vm.registers.accumulator;
                self.set_axis_parameter(kind, accumulator).map(|()| Outcome::Done(accumulator))
            }
            Command::AccumulatorToGlobalParameter => {
                let accumulator = self.vm.registers.accumulator;
                self.set_global_parameter(request, accumulator, accumulator)
            }
            Command::FirmwareVersion if kind == 0 => Ok(Outcome::VersionString),
            Command::FirmwareVersion => Ok(Outcome::Done(A::SPEC.version_number())),
            Command::FactoryReset => self.factory_reset(value),
            Command::RequestPositionReachedEvent if value == 0 => Ok(Outcome::AwaitPosition),
            Command::RequestPositionReachedEvent => Err(Status::InvalidValue),
            Command::SoftwareReset if value == CONFIRMATION => Ok(Outcome::Job(Job::Restart, value)),
            Command::SoftwareReset => Err(Status::InvalidValue),
            Command::ReferenceSearch => self.reference_search(kind, value),
            // Empty until a customer's firmware fills them.
            Command::UserFunction0
            | Command::UserFunction1
            | Command::UserFunction2
            | Command::UserFunction3
            | Command::UserFunction4
            | Command::UserFunction5
            | Command::UserFunction6
            | Command::UserFunction7 => Err(Status::InvalidCommand),
            Command::EnterAsciiMode => Ok(Outcome::AsciiMode(value)),
            // Only a host controls the application, and not here.
            Command::ApplicationStop
            | Command::ApplicationRun
            | Command::ApplicationStep
            | Command::ApplicationReset
            | Command::DownloadStart
            | Command::DownloadEnd
            | Command::ReadProgramMemory
            | Command::ApplicationStatus
            // Flow control is never available to a host, and in a program it is the interpreter's.
            | Command::Compare
            | Command::JumpConditional
            | Command::Jump
            | Command::CallSubroutine
            | Command::ReturnFromSubroutine
            | Command::EnableInterrupt
            | Command::DisableInterrupt
            | Command::Wait
            | Command::Stop
            | Command::ClearErrorFlags
            | Command::SetInterruptVector
            | Command::ReturnFromInterrupt => Err(Status::NotAvailable),
        }
    }

    /// ROR and ROL: the sign of the velocity is the command's, its range that of the target velocity.
    fn rotate(&mut self, velocity: i32, sent: i32) -> Executed {
        let target_velocity = axis_spec::<A>(2)?;
        if !target_velocity.allows_write(sent) {
            return Err(Status::InvalidValue);
        }
        self.begin(Motion::Rotate(velocity), sent)
    }

    fn move_to_position(&mut self, kind: u8, value: i32) -> Executed {
        match kind {
            0 => self.begin(Motion::MoveTo(value), value),
            1 => self.begin(Motion::MoveBy(value), value),
            _ => {
                let number = u8::try_from(value).map_err(|_| Status::InvalidValue)?;
                let position = self.coordinates.get(coordinate_number(number)?);
                self.begin(Motion::MoveTo(position), value)
            }
        }
    }

    /// RFS. Types beyond START and STOP are STATUS: the tables have no others.
    fn reference_search(&mut self, kind: u8, sent: i32) -> Executed {
        match kind {
            0 => self.axis.start_search()?,
            1 => self.axis.stop_search(),
            _ => return Ok(Outcome::Done(self.axis.search_state())),
        }
        Ok(Outcome::Done(sent))
    }

    fn begin(&mut self, motion: Motion, sent: i32) -> Executed {
        self.axis.motion(motion)?;
        Ok(Outcome::Done(sent))
    }

    fn set_axis_parameter(&mut self, number: u8, value: i32) -> Result<(), Status> {
        let (parameter, spec) = axis_parameter::<A>(number)?;
        in_range(spec, value)?;
        Ok(self.axis.set(parameter, value)?)
    }

    fn get_axis_parameter(&self, number: u8) -> Executed {
        let (parameter, _) = axis_parameter::<A>(number)?;
        Ok(Outcome::Done(self.axis.get(parameter)))
    }

    /// STAP stores the value in use; the one that comes along has no effect (TMCM-1311 §5.7.7).
    fn store_axis_parameter(&self, number: u8, sent: i32) -> Executed {
        let (parameter, _) = axis_parameter::<A>(number)?;
        self.unlocked()?;
        Ok(Outcome::Job(Job::Write(RecordKey::Axis(number), self.axis.get(parameter)), sent))
    }

    /// 137: no reply; nothing happens while the EEPROM is locked.
    fn factory_reset(&self, value: i32) -> Executed {
        match value {
            CONFIRMATION if self.globals.is_locked() => Ok(Outcome::Silence),
            CONFIRMATION => Ok(Outcome::SilentJob(Job::FactoryReset)),
            _ => Err(Status::InvalidValue),
        }
    }

    fn unlocked(&self) -> Result<(), Status> {
        if self.globals.is_locked() { Err(Status::EepromLocked) } else { Ok(()) }
    }
}

/// Whether the module has the command in this mode, its named type exists, and its motor is motor 0.
fn admit<A: Axis>(request: &Request, mode: Mode) -> Result<Command, Status> {
    let entry = A::SPEC.command(request.command).ok_or(Status::InvalidCommand)?;
    if !entry.modes.allow(mode) {
        return Err(Status::NotAvailable);
    }
    if entry.spec.type_field == TypeField::Named && !entry.types.contains(&request.kind) {
        return Err(Status::WrongType);
    }
    // A parameter that is unknown or not accessible this way is a wrong type, and that comes before a wrong motor.
    if entry.spec.type_field == TypeField::AxisParameter {
        check_access(entry.spec.command, axis_spec::<A>(request.kind)?.access)?;
    }
    match entry.spec.motor_field {
        MotorField::Motor if request.motor != 0 => Err(Status::InvalidValue),
        MotorField::CoordinateStore if ![0, COORDINATES_IN_EEPROM].contains(&request.motor) => {
            Err(Status::InvalidValue)
        }
        MotorField::Unused | MotorField::Motor | MotorField::Bank | MotorField::CoordinateStore => {
            Ok(entry.spec.command)
        }
    }
}

/// Whether the letters R, W and E let an axis parameter be used like this.
fn check_access(command: Command, access: Access) -> Result<(), Status> {
    let allowed = match command {
        Command::GetAxisParameter => access.read,
        Command::StoreAxisParameter | Command::RestoreAxisParameter => access.store,
        _ => access.write,
    };
    if allowed { Ok(()) } else { Err(Status::WrongType) }
}

fn axis_spec<A: Axis>(number: u8) -> Result<&'static ParameterSpec, Status> {
    A::SPEC.axis_parameter(number).ok_or(Status::WrongType)
}

fn axis_parameter<A: Axis>(number: u8) -> Result<(A::Parameter, &'static ParameterSpec), Status> {
    let parameter = A::Parameter::try_from(number).map_err(|_| Status::WrongType)?;
    Ok((parameter, axis_spec::<A>(number)?))
}

fn readable(spec: &ParameterSpec) -> Result<(), Status> {
    if spec.access.read { Ok(()) } else { Err(Status::WrongType) }
}

fn storable(spec: &ParameterSpec) -> Result<(), Status> {
    if spec.access.store { Ok(()) } else { Err(Status::WrongType) }
}

fn in_range(spec: &ParameterSpec, value: i32) -> Result<(), Status> {
    if spec.allows_write(value) { Ok(()) } else { Err(Status::InvalidValue) }
}
