//! The reference search: its settings, and how the ramp follows it (TMCM-1311 §5.7.13, §9; AP 193 to 196).

use motion_control::homing::{Mode, Order, Pace, Search, Seen, Switches};
use motion_control::ramp::{Goal, Limits};

use super::{AxisParameter, RampMode, Tmcm1311};
use crate::axis::Refused;

impl Tmcm1311 {
    /// RFS START: with the mode that AP 193 has now, from the velocity that the motor has now.
    pub(super) fn begin_search(&mut self) -> Result<(), Refused> {
        let number = self.kept_value(AxisParameter::ReferenceSearchMode);
        let mode = Mode::from_number(number).ok_or(Refused::InvalidValue)?;
        self.forget_deviation();
        self.end_standstill();
        self.begin_motion();
        self.mode = RampMode::Position;
        self.search = Some(Search::new(mode));
        Ok(())
    }

    /// A control period of a search.
    pub(super) fn search_on(&mut self, mut search: Search) {
        let seen = Seen {
            switches: Switches {
                left: self.is_left_switch_active(),
                right: self.is_right_switch_active(),
                home: self.is_home_switch_active(),
            },
            position: self.ramp.position(),
            measured: self.ramp.position().wrapping_sub(self.ramp_lead()),
            standing: self.ramp.is_standing(),
        };
        let order = search.tick(&seen, &self.search_pace());
        self.search = Some(search);
        match order {
            Order::Drive { goal, max_velocity_pps } => {
                self.ramp.set_goal(goal);
                self.follow_ramp(&Limits { max_velocity_pps, ..self.limits() });
            }
            Order::Halt => {
                self.ramp.halt();
                self.ramp.set_goal(Goal::Velocity(0));
            }
            Order::Blocked => {
                self.turn(0);
                if !self.stops_softly() {
                    self.ramp.halt();
                }
            }
            Order::Finished { distance } => self.finish_search(distance),
        }
    }

    /// How far the ramp is ahead of the rotor, in µsteps; 0 in open loop, where that is not known.
    fn ramp_lead(&self) -> i32 {
        self.closed().map_or(0, |closed| closed.ramp_lead() as i32) // wraps, as every position does
    }

    /// The place where the ramp stands is the new zero.
    fn finish_search(&mut self, distance: Option<i32>) {
        self.search = None;
        self.target_position = 0;
        match self.closed() {
            // The encoder is as far from the new zero as the rotor is from the ramp.
            Some(_) => self.set_encoder_counter(self.position_error().wrapping_neg()),
            None => self.ramp.redefine_position(0),
        }
        self.ramp.set_goal(Goal::Position(self.ramp_target()));
        if let Some(distance) = distance {
            let distance = self.in_user_steps(distance.saturating_abs());
            self.kept.set(AxisParameter::EndSwitchDistance.index(), distance);
        }
    }

    /// A way of the ramp in the unit of AP 0 and AP 1: in closed loop encoder steps.
    fn in_user_steps(&self, steps: i32) -> i32 {
        let counts = self.closed().and_then(|_| self.encoder_scale()).map(|scale| scale.counts(steps.into()));
        counts.map_or(steps, |counts| i32::try_from(counts).unwrap_or(i32::MAX))
    }

    /// |AP 194| and |AP 195|; where they are 0, AP 4 and a quarter of it, if that is anything at all.
    pub(super) fn search_pace(&self) -> Pace {
        let max_velocity_pps = self.kept_value(AxisParameter::MaxVelocity);
        let speed = |parameter, otherwise| match self.kept_value(parameter) {
            0 => otherwise,
            velocity_pps => velocity_pps.saturating_abs(),
        };
        let quarter_pps = (max_velocity_pps / 4).max(max_velocity_pps.min(1));
        Pace {
            search_pps: speed(AxisParameter::ReferenceSearchVelocity, max_velocity_pps),
            switch_pps: speed(AxisParameter::ReferenceSwitchVelocity, quarter_pps),
            soft_stop: self.stops_softly(),
        }
    }
}
