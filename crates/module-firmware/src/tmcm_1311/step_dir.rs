//! Step/direction mode: pulses from outside move the motor, and the ramp generator does not drive (TMCM-1311 §6, AP 254).
//!
//! The manual says what each mode does with the current, and nothing else. Decisions:
//! - a pulse moves AP 1 and the field by a microstep of AP 140, in closed loop of 1/256 full step, and AP 0 along: what was
//!   ordered is what was pulsed;
//! - pulses that must not move the motor are lost: towards an active stop switch, with the driver stage off, and after a stop
//!   (MST, AP 181, AP 212) until AP 254 is written again;
//! - writing AP 254 is what a motion command is otherwise: it ends a stop, brings the current back and begins the delays anew.
//!   The first time it needs a motor at rest;
//! - what the ramp would have to drive (ROR, MVP, SAP 0, 2 and 128, RFS START) is not available.

use super::pulse_meter::PulseMeter;
use super::{AxisParameter, RampMode, Tmcm1311};
use crate::axis::{Motion, Refused};

/// What AP 254 does with the current in open loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Current {
    /// AP 7 and 204 after a rest, as without step/direction mode.
    Automatic,
    /// AP 6 while ENABLE is active, AP 7 while it is not, pulses or not.
    ByEnable,
    /// AP 6.
    Run,
}

/// The state of the step/direction mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct StepDir {
    /// Pulses that moved the motor.
    meter: PulseMeter,
    /// A stop holds.
    stopped: bool,
}

impl StepDir {
    /// Pulses are lost from now on.
    pub(super) fn stop(&mut self) {
        *self = Self { stopped: true, ..Self::default() };
    }
}

impl Tmcm1311 {
    /// Whether AP 254 is anything but 0: pulses move the motor, and the ramp does not.
    pub(super) fn in_step_dir_mode(&self) -> bool {
        self.kept_value(AxisParameter::StepDirMode) != 0
    }

    /// Writes AP 254.
    ///
    /// # Errors
    /// [`Refused::NotAvailable`] while the encoder is being found or the closed loop initialised; [`Refused::InvalidValue`] where
    /// it would take a motor from the ramp that has not come to rest.
    pub(super) fn set_step_dir_mode(&mut self, mode: i32) -> Result<(), Refused> {
        if mode == 0 && !self.in_step_dir_mode() {
            return Ok(());
        }
        self.require_obedience()?;
        if !self.in_step_dir_mode() && !self.is_standing_still() {
            return Err(Refused::InvalidValue);
        }
        self.begin_motion();
        self.kept.set(AxisParameter::StepDirMode.index(), mode);
        self.mode = RampMode::Position;
        self.target_velocity = 0;
        self.stop_at_once();
        self.step_dir = StepDir::default();
        self.forget_deviation();
        self.end_standstill();
        Ok(())
    }

    /// What only the ramp could do.
    ///
    /// # Errors
    /// [`Refused::NotAvailable`] in step/direction mode.
    pub(super) fn need_ramp(&self) -> Result<(), Refused> {
        if self.in_step_dir_mode() { Err(Refused::NotAvailable) } else { Ok(()) }
    }

    /// A motion command in step/direction mode: a stop makes the motor deaf to pulses, all others need the ramp.
    ///
    /// # Errors
    /// [`Refused::NotAvailable`] for all others.
    pub(super) fn motion_among_pulses(&mut self, motion: Motion) -> Result<(), Refused> {
        if motion != Motion::Stop {
            return Err(Refused::NotAvailable);
        }
        self.stop_at_once();
        Ok(())
    }

    /// The microsteps, signed, that the pulses since the last control period shall move the motor by: 0 where they are lost.
    pub(super) fn accepted_pulses(&self) -> i32 {
        let pulses = self.sensed.steps;
        let is_free = self.in_step_dir_mode() && !self.step_dir.stopped && !self.is_disabled();
        if is_free && !self.is_blocked(pulses) { pulses } else { 0 }
    }

    /// The pulses of a control period, counted into AP 3.
    pub(super) fn take_pulses(&mut self) -> i32 {
        let pulses = self.accepted_pulses();
        self.step_dir.meter.tick(pulses);
        pulses
    }

    /// A control period in step/direction mode in open loop.
    pub(super) fn follow_pulses(&mut self) {
        let microsteps = self.take_pulses();
        if microsteps != 0 {
            self.ramp.redefine_position(self.ramp.position().wrapping_add(microsteps));
            self.target_position = self.ramp.position();
            self.step(microsteps);
        }
    }

    /// AP 3: the ramp's velocity, or how fast the pulses come that move the motor.
    pub(super) fn actual_velocity_pps(&self) -> i32 {
        if self.in_step_dir_mode() { self.step_dir.meter.rate_pps() } else { self.ramp.velocity_pps() }
    }

    /// Whether a pulse moved the motor in the last 100 ms.
    pub(super) fn is_pulsed(&self) -> bool {
        self.step_dir.meter.is_running()
    }

    /// Whether no pulse needs attention, nor any that came before.
    pub(super) fn pulses_rest(&self) -> bool {
        !self.in_step_dir_mode() || (self.sensed.steps == 0 && !self.is_pulsed())
    }

    /// Whether ENABLE switches the driver stage off: modes 4 and 5, and in closed loop mode 1.
    pub(super) fn is_disabled(&self) -> bool {
        let obeys = match self.kept_value(AxisParameter::StepDirMode) {
            4 | 5 => true,
            1 => self.closed().is_some(),
            _ => false,
        };
        obeys && !self.sensed.enabled
    }

    /// Whether AP 7 and AP 204 follow from how long the motor has been standing.
    pub(super) fn rest_sets_current(&self) -> bool {
        self.step_dir_current() == Current::Automatic
    }

    /// Whether AP 7 flows for another reason.
    pub(super) fn enable_selects_standby(&self) -> bool {
        self.step_dir_current() == Current::ByEnable && !self.sensed.enabled
    }

    fn step_dir_current(&self) -> Current {
        match self.kept_value(AxisParameter::StepDirMode) {
            1 => Current::ByEnable,
            3 | 5 => Current::Run,
            _ => Current::Automatic,
        }
    }
}
