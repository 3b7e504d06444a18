//! Closed loop: the encoder says where the rotor is, and the field follows the rotor (TMCM-1311 §8).
//!
//! The ramp generator works in µsteps of 1/256 full step, as in open loop, but from one place to another, not in the user's
//! coordinates: those are encoder steps, AP 209 and AP 1 are the same, and AP 0 is a distance from there. How far ramp and
//! field are ahead of the rotor is all that the loop keeps ([`Leads`]); the raw encoder counter, which nothing but the shaft
//! changes, turns the field.

mod current;
mod field;
mod hold;
mod readings;
mod start;
mod torque;

use motion_control::closed_loop::alignment::Alignment;
use motion_control::closed_loop::current_scale::CurrentScale;
use motion_control::closed_loop::detection::Detection;
use motion_control::closed_loop::leads::Leads;
use motion_control::closed_loop::scale::{EncoderScale, Odometer};
use motion_control::closed_loop::torque_ramp::TorqueRamp;
use motion_control::ramp::{Place, UNITS_PER_STEP};

use super::{AxisParameter, RampMode, Tmcm1311};

/// The ramp is never sent further than this at once, so that its 32-bit positions go the right way round.
const HORIZON: i64 = 1 << 30;

/// Who decides where the field stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Operation {
    /// The ramp alone.
    #[default]
    Open,
    /// The ramp, while the encoder's resolution is being found (AP 132).
    Detecting(Detection),
    /// The initialisation (AP 129 = 1, AP 133 = 0); on failure the field goes back to `from_phase`.
    Aligning { alignment: Alignment, scale: EncoderScale, from_phase: u16, from_count: i32 },
    /// The rotor (AP 133 = 1).
    Closed(ClosedLoop),
}

/// The state of the closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ClosedLoop {
    rotor: Odometer,
    /// Where the rotor stands in the electrical period, in µsteps.
    rotor_phase: u16,
    leads: Leads,
    current: CurrentScale,
    torque: TorqueRamp,
    /// Torque mode stands before a stop switch.
    torque_is_held: bool,
    /// Standstill mode (§8.5): the target is reached.
    holds: bool,
    /// What standstill mode took over from the move before it, in 1/20 µstep.
    carried: i64,
    /// It was pushed out of standstill mode, and is on its way back.
    recovers: bool,
    /// For how many control periods the motor has been within AP 134 of the target.
    in_window: u32,
}

impl ClosedLoop {
    /// A loop that begins with the rotor at the electrical angle 0.
    fn new(scale: EncoderScale, count: i32) -> Self {
        Self {
            rotor: Odometer::new(scale, count),
            rotor_phase: 0,
            leads: Leads::default(),
            current: CurrentScale::new(u8::MAX),
            torque: TorqueRamp::new(),
            torque_is_held: false,
            holds: false,
            carried: 0,
            recovers: false,
            in_window: 0,
        }
    }

    /// Forgets what ramp and field were ahead by.
    fn forget_leads(&mut self) {
        self.leads.forget_ramp();
        self.leads.forget_field();
    }

    /// How far the ramp is ahead of the rotor, in µsteps.
    pub(super) fn ramp_lead(&self) -> i64 {
        self.leads.ramp()
    }

    /// How far the ramp is ahead of the rotor, in µsteps, and would be, had it not given way to an overload.
    pub(super) fn shortfall(&self) -> i64 {
        self.leads.shortfall()
    }

    fn stop_holding(&mut self) {
        self.leads.forget_overload();
        self.holds = false;
        self.recovers = false;
        self.in_window = 0;
    }
}

impl Tmcm1311 {
    pub(super) fn closed(&self) -> Option<&ClosedLoop> {
        match &self.operation {
            Operation::Closed(closed) => Some(closed),
            _ => None,
        }
    }

    fn closed_mut(&mut self) -> Option<&mut ClosedLoop> {
        match &mut self.operation {
            Operation::Closed(closed) => Some(closed),
            _ => None,
        }
    }

    pub(super) fn is_open_loop(&self) -> bool {
        self.operation == Operation::Open
    }

    /// Takes note of how far the rotor turned since the last control period.
    pub(super) fn follow_rotor(&mut self) {
        let count = self.sensed.encoder_counts;
        if let Some(closed) = self.closed_mut() {
            let moved = closed.rotor.follow(count);
            closed.leads.rotor_moved(moved);
            closed.rotor_phase = turned(closed.rotor_phase, moved);
        }
    }

    /// A control period of the closed loop; takes note of whether it changed anything.
    pub(super) fn tick_closed_loop(&mut self) {
        let before = self.resting();
        self.close_loop();
        self.settled = before.is_some() && before == self.resting();
    }

    /// The state of a loop that may be at rest.
    fn resting(&self) -> Option<(ClosedLoop, Place)> {
        let rests = self.ramp.is_standing() && self.tachometer.is_at_rest();
        self.closed().copied().filter(|_| rests).map(|closed| (closed, self.ramp.place()))
    }

    /// A control period of the closed loop: ramp, then field, then current.
    fn close_loop(&mut self) {
        if self.switched_off || self.is_disabled() {
            self.follow_loose_rotor();
        } else if self.in_step_dir_mode() {
            self.drive_pulses();
        } else if self.search.is_none() && self.mode == RampMode::Torque {
            self.drive_torque();
        } else if !self.holds_position() {
            self.drive_field();
        }
        self.regulate_current();
        self.phase = self.field_phase();
    }

    /// A control period of the ramp, and of the field after it.
    fn drive_field(&mut self) {
        self.begin_return_anew();
        let (place, position) = (self.ramp.place(), self.ramp.position());
        self.drive_ramp();
        self.lead_field(self.ramp.position().wrapping_sub(position), self.ramp.units_since(place));
        self.watch_window();
    }

    /// A control period of step/direction mode: a pulse is a µstep, and the field follows it as it follows the ramp.
    fn drive_pulses(&mut self) {
        let pulses = self.take_pulses();
        if pulses != 0
            && let Some(closed) = self.closed_mut()
        {
            closed.stop_holding();
        }
        if !self.holds_position() {
            self.lead_field(pulses, i64::from(pulses) * UNITS_PER_STEP);
            self.target_position = self.ramp_position();
            self.watch_window();
        }
    }

    /// The ramp went on: the field follows it, in positioning with corrections, at a commanded velocity closely.
    fn lead_field(&mut self, steps: i32, units: i64) {
        let (limits, correction) = (self.lead_limits(), self.correction());
        let closely = self.search.is_none() && self.mode == RampMode::Velocity;
        let Some(closed) = self.closed_mut() else { return };
        closed.leads.ramp_moved(steps.into());
        if closely {
            closed.leads.follow_closely(limits);
        } else {
            closed.leads.follow(units, &correction, limits);
        }
    }

    /// The current is off, and the shaft may be turned by hand: ramp and target go along (§6, AP 212).
    fn follow_loose_rotor(&mut self) {
        self.ramp.halt();
        self.target_position = self.encoder_counter();
        self.stay_with_rotor();
    }

    /// µsteps that the ramp still has to go to the target.
    fn ramp_distance(&self, closed: &ClosedLoop) -> i64 {
        self.target_distance(closed) - closed.leads.ramp()
    }

    /// µsteps from the rotor to the target.
    fn target_distance(&self, closed: &ClosedLoop) -> i64 {
        closed.rotor.microsteps_to(self.target_position.wrapping_sub(self.encoder_counter()))
    }

    /// Where the ramp has to go for the target, in its own coordinates.
    pub(super) fn ramp_target(&self) -> i32 {
        match self.closed() {
            None => self.target_position,
            Some(closed) => {
                let distance = self.ramp_distance(closed).clamp(-HORIZON, HORIZON);
                self.ramp.position().wrapping_add(distance as i32)
            }
        }
    }

    /// Whatever ramp and rotor disagreed about is forgotten: the motor is to stay where it is.
    pub(super) fn stay_with_rotor(&mut self) {
        if let Some(closed) = self.closed_mut() {
            closed.forget_leads();
            closed.stop_holding();
        }
    }

    /// What a motion command ends: standstill, torque mode, what a deviation began.
    pub(super) fn begin_motion(&mut self) {
        self.leave_torque();
        if let Some(closed) = self.closed_mut() {
            closed.stop_holding();
        }
    }
}

/// An angle turned on by so many µsteps.
fn turned(phase: u16, microsteps: i64) -> u16 {
    let [.., high, low] = microsteps.to_be_bytes();
    phase.wrapping_add(u16::from_be_bytes([high, low]))
}
