//! How a motion begins, and what the ramp generator does with it in a control period (TMCM-1311 §5.7.1 to §5.7.4, §8.4).

use motion_control::ramp::{Goal, Limits};

use super::{AxisParameter, Drive, MICROSTEPS, Operation, RampMode, Tmcm1311};

impl Tmcm1311 {
    /// Velocity mode: speeds up or slows down to `velocity_pps` (§5.7.1).
    pub(super) fn turn(&mut self, velocity_pps: i32) {
        self.search = None;
        self.forget_deviation();
        self.end_standstill();
        self.begin_motion();
        self.mode = RampMode::Velocity;
        self.target_velocity = velocity_pps;
        self.ramp.set_goal(Goal::Velocity(velocity_pps));
    }

    /// Position mode: to `position` (§5.7.4). A motor that is there already stays.
    pub(super) fn move_to(&mut self, position: i32) {
        self.search = None;
        self.forget_deviation();
        self.end_standstill();
        if !(self.is_holding() && self.target_position == position) {
            self.begin_motion();
        }
        self.mode = RampMode::Position;
        self.target_position = position;
        self.ramp.set_goal(Goal::Position(self.ramp_target()));
    }

    /// What MVP REL counts from (§6, AP 127).
    pub(super) fn relative_origin(&self) -> i32 {
        match self.kept_value(AxisParameter::RelativePositioningOption) {
            0 => self.target_position,
            2 if self.closed().is_some() => self.encoder_counter(),
            2 => self.encoder_position(),
            _ => self.ramp_position(),
        }
    }

    /// A control period of open loop.
    pub(super) fn tick_open_loop(&mut self) -> Drive {
        self.freewheel_in_time();
        let before = self.ramp.position();
        if self.in_step_dir_mode() {
            self.follow_pulses();
        } else {
            self.drive_ramp();
        }
        let rested = self.rested(self.ramp.position() != before);
        let drive = self.drive();
        if rested {
            self.standstill.skip(1);
        }
        drive
    }

    /// Whether another control period with the same sensors would command the same.
    pub(super) fn is_settled(&self) -> bool {
        match self.operation {
            Operation::Open => {
                self.ramp.goal() == self.allowed_goal() && self.ramp.is_settled(&self.limits())
            }
            Operation::Detecting(_) | Operation::Aligning { .. } => false,
            Operation::Closed(_) => self.settled,
        }
    }

    /// A control period of the ramp, and of what drives it.
    pub(super) fn drive_ramp(&mut self) {
        if let Some(search) = self.search {
            self.search_on(search);
        } else {
            self.heed_switches();
            self.follow_ramp(&self.limits());
        }
    }

    /// Lets the ramp go on, and in open loop the field with it.
    pub(super) fn follow_ramp(&mut self, limits: &Limits) {
        let before = self.ramp.position();
        self.ramp.tick(limits);
        if self.closed().is_none() {
            self.step(self.ramp.position().wrapping_sub(before));
        }
    }

    pub(super) fn limits(&self) -> Limits {
        Limits {
            max_velocity_pps: self.kept_value(AxisParameter::MaxVelocity),
            acceleration_pps2: self.kept_value(AxisParameter::MaxAcceleration),
            start_stop_velocity_pps: self.kept_value(AxisParameter::StartStopVelocity),
        }
    }

    /// 1/256 full steps in a microstep (§6, AP 140); 1 in closed loop.
    pub(super) fn microstep_size(&self) -> i32 {
        if self.closed().is_some() {
            return 1;
        }
        MICROSTEPS >> self.kept_value(AxisParameter::MicrostepResolution).clamp(0, 8)
    }

    /// Turns the field on by what the ramp moved.
    pub(super) fn step(&mut self, microsteps: i32) {
        let turned = microsteps.wrapping_mul(self.microstep_size());
        let [_, _, high, low] = turned.to_be_bytes();
        self.phase = self.phase.wrapping_add(u16::from_be_bytes([high, low]));
    }

    pub(super) fn drive(&self) -> Drive {
        Drive { coils: self.coil_currents(), chip: self.chip_settings(), outputs: self.outputs }
    }
}
