//! Getting into the closed loop and out of it, and finding the encoder's resolution (TMCM-1311 §8.1, §8.3; AP 129, 132, 133).

use motion_control::closed_loop::alignment::{self, Alignment};
use motion_control::closed_loop::detection::{self, Detection, Motor};
use motion_control::closed_loop::scale::EncoderScale;
use motion_control::ramp::Goal;

use super::super::MICROSTEPS;
use super::{AxisParameter, ClosedLoop, Operation, RampMode, Tmcm1311};
use crate::axis::Refused;

/// µsteps in an electrical period.
const ELECTRICAL_PERIOD: i64 = 4 * MICROSTEPS as i64;

/// What AP 132 says (§6).
const DETECTION_NONE: i32 = 0;
const DETECTION_RUNS: i32 = 1;
const DETECTION_DONE: i32 = 2;
const DETECTION_FAILED: i32 = 3;

impl Tmcm1311 {
    /// SAP 129.
    pub(in super::super) fn switch_closed_loop(&mut self, on: bool) -> Result<(), Refused> {
        match self.operation {
            Operation::Detecting(_) => Err(Refused::NotAvailable),
            Operation::Open if on => self.begin_alignment(),
            Operation::Aligning { .. } if !on => {
                self.abort_alignment();
                Ok(())
            }
            Operation::Closed(_) if !on => self.open_loop(),
            _ => Ok(()),
        }
    }

    fn begin_alignment(&mut self) -> Result<(), Refused> {
        let scale = self.encoder_scale().filter(EncoderScale::is_fine_enough);
        let scale = scale.filter(|_| self.is_standing_still()).ok_or(Refused::InvalidValue)?;
        self.alignment_current = self.current_part();
        let alignment = Alignment::new(self.phase, self.alignment_current);
        self.settle_for_operation();
        self.operation = Operation::Aligning {
            alignment,
            scale,
            from_phase: self.phase,
            from_count: self.sensed.encoder_counts,
        };
        Ok(())
    }

    /// Neither ramp nor search nor pulses move the motor or are about to, and torque does not either.
    pub(in super::super) fn is_standing_still(&self) -> bool {
        let turns = self.mode == RampMode::Torque && self.measured_velocity_pps() != 0;
        self.ramp.is_at_rest(&self.limits()) && self.search.is_none() && !self.is_pulsed() && !turns
    }

    /// The current that flows now, in 1/256 of AP 6.
    fn current_part(&self) -> u8 {
        let chip = self.chip_settings();
        let largest = self.kept_value(AxisParameter::MaxCurrent) / 8 + 1;
        let part = (256 * (i32::from(chip.current_scale) + 1)).checked_div(largest).unwrap_or(1) - 1;
        if chip.off_time == 0 { 0 } else { u8::try_from(part).unwrap_or(u8::MAX) }
    }

    /// What was going on is over: the motor is to stay where it is.
    fn settle_for_operation(&mut self) {
        self.forget_deviation();
        self.end_standstill();
        self.mode = RampMode::Position;
        self.target_position = self.ramp.position();
        self.ramp.halt();
    }

    /// A control period of the initialisation.
    pub(in super::super) fn align_on(&mut self) {
        let count = self.sensed.encoder_counts;
        let Operation::Aligning { alignment, scale, .. } = &mut self.operation else { return };
        match alignment.tick(count, scale) {
            alignment::Order::Field { phase, current } => {
                self.phase = phase;
                self.alignment_current = current;
            }
            alignment::Order::Aligned => self.begin_loop(),
            alignment::Order::Failed => self.abort_alignment(),
        }
    }

    /// The rotor is at 0: the loop closes, with the counter in encoder steps.
    fn begin_loop(&mut self) {
        let Operation::Aligning { scale, from_phase, from_count, .. } = self.operation else { return };
        let count = self.sensed.encoder_counts;
        let turned = scale.microsteps(count.wrapping_sub(from_count).into());
        let position = i64::from(self.ramp.position()) * i64::from(self.microstep_size());
        let position = scale.counts(position + field_turned(from_phase, turned)) as i32; // wraps
        self.phase = 0;
        self.operation = Operation::Closed(ClosedLoop::new(scale, count));
        self.set_encoder_counter(position);
        self.target_position = position;
    }

    /// The field goes back to where it was, and the rotor with it.
    pub(in super::super) fn abort_alignment(&mut self) {
        if let Operation::Aligning { from_phase, .. } = self.operation {
            self.phase = from_phase;
            self.operation = Operation::Open;
            self.end_standstill();
        }
    }

    /// Back to open loop: the field stands where the rotor does, the counter is µsteps again.
    fn open_loop(&mut self) -> Result<(), Refused> {
        if !self.is_standing_still() {
            return Err(Refused::InvalidValue);
        }
        let microsteps =
            self.encoder_scale().map_or(0, |scale| scale.microsteps(self.encoder_counter().into()));
        self.leave_torque();
        self.stay_with_rotor();
        self.phase = self.field_phase();
        self.operation = Operation::Open;
        let position = (microsteps / i64::from(self.microstep_size())) as i32; // wraps
        self.ramp.halt();
        self.ramp.redefine_position(position);
        self.settle_for_operation();
        Ok(())
    }

    /// SAP 132: 1 begins a detection, 0 aborts it.
    pub(in super::super) fn switch_detection(&mut self, on: bool) -> Result<(), Refused> {
        match self.operation {
            Operation::Detecting(_) if on => Ok(()),
            Operation::Detecting(_) => {
                self.abort_detection();
                Ok(())
            }
            Operation::Open if on => self.begin_detection(),
            Operation::Open => {
                self.detection_state = DETECTION_NONE;
                Ok(())
            }
            Operation::Aligning { .. } | Operation::Closed(_) => Err(Refused::NotAvailable),
        }
    }

    fn begin_detection(&mut self) -> Result<(), Refused> {
        let full_steps = self.kept_value(AxisParameter::MotorFullSteps);
        if full_steps == 0 || !self.is_standing_still() {
            return Err(Refused::InvalidValue);
        }
        self.settle_for_operation();
        let motor = Motor { full_steps, steps_per_full_step: MICROSTEPS / self.microstep_size() };
        self.operation = Operation::Detecting(Detection::new(motor, self.ramp.position()));
        self.detection_state = DETECTION_RUNS;
        Ok(())
    }

    /// A control period of a detection. A stop switch in its way makes it fail.
    pub(in super::super) fn detect_on(&mut self) {
        let seen = detection::Seen {
            count: self.sensed.encoder_counts,
            position: self.ramp.position(),
            standing: self.ramp.is_standing(),
        };
        let blocked = self.is_blocked(1);
        let Operation::Detecting(detection) = &mut self.operation else { return };
        match detection.tick(&seen) {
            _ if blocked => self.end_detection(DETECTION_FAILED),
            detection::Order::Drive(goal, limits) => {
                self.ramp.set_goal(goal);
                self.follow_ramp(&limits);
            }
            detection::Order::Found(resolution) => self.accept_resolution(resolution),
            detection::Order::Failed => self.end_detection(DETECTION_FAILED),
        }
    }

    /// Here is zero, for ramp and encoder.
    fn accept_resolution(&mut self, resolution: i32) {
        self.kept.set(AxisParameter::EncoderResolution.index(), resolution);
        self.ramp.redefine_position(0);
        self.set_encoder_counter(0);
        self.end_detection(DETECTION_DONE);
    }

    /// Stops where it is, and says so.
    pub(in super::super) fn end_detection(&mut self, state: i32) {
        if matches!(self.operation, Operation::Detecting(_)) {
            self.operation = Operation::Open;
            self.detection_state = state;
            self.ramp.halt();
            self.target_position = self.ramp.position();
            self.ramp.set_goal(Goal::Position(self.target_position));
        }
    }

    /// Slows down to a stop.
    fn abort_detection(&mut self) {
        if matches!(self.operation, Operation::Detecting(_)) {
            self.operation = Operation::Open;
            self.detection_state = DETECTION_NONE;
            self.turn(0);
        }
    }

    /// MST ends what keeps the motor from obeying other commands.
    pub(in super::super) fn abort_operation(&mut self) {
        self.abort_detection();
        self.abort_alignment();
    }

    /// Motion commands have to wait for the end of a detection or an initialisation.
    pub(in super::super) fn require_obedience(&self) -> Result<(), Refused> {
        match self.operation {
            Operation::Open | Operation::Closed(_) => Ok(()),
            Operation::Detecting(_) | Operation::Aligning { .. } => Err(Refused::NotAvailable),
        }
    }
}

/// How far the field turned from `phase` to 0, the way round that is nearest to what the encoder saw, in µsteps.
fn field_turned(phase: u16, seen: i64) -> i64 {
    let phase = i64::from(phase) % ELECTRICAL_PERIOD;
    let periods = (seen + phase + ELECTRICAL_PERIOD / 2).div_euclid(ELECTRICAL_PERIOD);
    periods * ELECTRICAL_PERIOD - phase
}
