//! All that differs between modules: their parameters, ports and motion. No bytes, no storage.

use tmcl_tables::{Interrupt, ModuleSpec, Status};
use tmcl_vm::WaitEvent;

use crate::events::Events;
use crate::program_memory::ProgramMemory;

/// What a motion command asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// ROR and ROL: turn at a velocity, positive to the right.
    Rotate(i32),
    /// MST: slow down to a stop.
    Stop,
    /// MVP ABS and COORD: to a position.
    MoveTo(i32),
    /// MVP REL: by an offset from where the module's settings say.
    MoveBy(i32),
}

/// Why an axis does not do what it was told, although the number and the value are right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// The axis cannot do this in its present state.
    #[error("not available in the present state")]
    NotAvailable,
    /// The value does not fit the other settings.
    #[error("the value does not fit the other settings")]
    InvalidValue,
}

impl From<Refused> for Status {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::NotAvailable => Self::NotAvailable,
            Refused::InvalidValue => Self::InvalidValue,
        }
    }
}

/// One module's axis with its inputs and outputs.
///
/// The dispatcher has checked number, access and range before it calls; an axis answers for the meaning only.
pub trait Axis: Clone + Default {
    /// The module's tables.
    const SPEC: &'static ModuleSpec;
    /// Its axis parameters, a generated enum, so that every match is exhaustive.
    type Parameter: Copy + TryFrom<u8>;
    /// Its inputs and outputs, likewise.
    type Port: Copy;
    /// What its sensors say, once a control period.
    type Sensed;
    /// What its power stage and outputs shall do.
    type Drive: Copy + Default;

    /// The memory of its stand-alone program.
    type Programs: ProgramMemory + core::fmt::Debug;

    /// One control period of 50 µs. Constant work. What happened that the parameters do not show goes to `events`.
    fn tick(&mut self, sensed: &Self::Sensed, events: &mut Events) -> Self::Drive;
    /// Whether another control period with these sensors would change nothing that can be read and command the same, at
    /// least for [`Axis::quiet_ticks`] of them.
    fn is_idle(&self, sensed: &Self::Sensed) -> bool;
    /// Control periods with the sensors of the last one until something changes by itself, while [`Axis::is_idle`].
    fn quiet_ticks(&self) -> u64;
    /// Lets so many control periods pass, at most [`Axis::quiet_ticks`], while [`Axis::is_idle`]: what counts them ends up as
    /// if each had been gone through.
    fn skip(&mut self, ticks: u64);
    /// The value of a parameter.
    fn get(&self, parameter: Self::Parameter) -> i32;
    /// Changes a parameter.
    ///
    /// # Errors
    /// [`Refused`] when the value is in range but cannot take effect now; then nothing has changed.
    fn set(&mut self, parameter: Self::Parameter, value: i32) -> Result<(), Refused>;
    /// Puts a parameter back to what is stored, or to its default where nothing is (RSAP). A value that cannot take effect now
    /// leaves the one that stands, which is what the user had.
    fn restore(&mut self, parameter: Self::Parameter, stored: Option<i32>, default: i32) {
        let _ = self.set(parameter, stored.unwrap_or(default));
    }
    /// The same at power-on, where every parameter that can be stored is put back, by number.
    fn restore_at_power_on(&mut self, parameter: Self::Parameter, stored: Option<i32>, default: i32) {
        self.restore(parameter, stored, default);
    }
    /// Begins a motion.
    ///
    /// # Errors
    /// [`Refused`] when the axis cannot move now.
    fn motion(&mut self, motion: Motion) -> Result<(), Refused>;
    /// Begins a reference search (RFS START); one that runs begins anew.
    ///
    /// # Errors
    /// [`Refused`] when the axis cannot search now.
    fn start_search(&mut self) -> Result<(), Refused>;
    /// Aborts a reference search, which slows down to a stop (RFS STOP); does nothing when none runs.
    fn stop_search(&mut self);
    /// Where a reference search has got to (RFS STATUS); 0 when none runs.
    fn search_state(&self) -> i32;
    /// Where the axis is, for CCO.
    fn actual_position(&self) -> i32;
    /// Whether the target position is reached, for command 138.
    fn is_position_reached(&self) -> bool;
    /// Whether what a WAIT waits for is the case.
    fn has_happened(&self, event: WaitEvent) -> bool;
    /// The level whose edges raise an interrupt; false for those that have none.
    fn level(&self, interrupt: Interrupt) -> bool;
    /// Global parameter 79: whether the polarity of the end switches is reversed.
    fn set_end_switch_polarity(&mut self, reversed: bool);
    /// The port with this bank and number.
    fn port(bank: u8, number: u8) -> Option<Self::Port>;
    /// The state or reading of a port.
    fn read_port(&self, port: Self::Port) -> i32;
    /// Switches an output; does nothing to inputs.
    fn write_port(&mut self, port: Self::Port, high: bool);
}
