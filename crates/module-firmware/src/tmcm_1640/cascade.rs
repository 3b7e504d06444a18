//! The cascade: position makes velocity, velocity makes current (§7.1, §7.3 to §7.5).

use motion_control::foc::pi::Gains;
use motion_control::foc::positioning;

use super::{AxisParameter, Regulation, RegulationMode, Tmcm1640};
use crate::TICKS_PER_MS;

/// The unit of AP 238: this acceleration takes AP 238 mA.
const INERTIA_RPM_PER_S: i64 = 1000;

impl Default for Regulation {
    fn default() -> Self {
        Self {
            ramp: Default::default(),
            velocity: Default::default(),
            current_q: Default::default(),
            current_d: Default::default(),
            target_current_ma: 0,
            voltage: [0; 2],
            position_error: 0,
            position_reached: true,
        }
    }
}

impl Tmcm1640 {
    /// AP 133 in ms, at least 1.
    pub(super) fn velocity_interval_ms(&self) -> u32 {
        self.kept_value(AxisParameter::PidLoopDelay).cast_unsigned().max(1)
    }

    /// Position and velocity regulators, when they are due.
    pub(super) fn regulate_motion(&mut self) {
        if self.velocity_due > 0 {
            self.velocity_due -= 1;
            return;
        }
        let interval_ms = self.velocity_interval_ms();
        self.velocity_due = interval_ms.saturating_mul(TICKS_PER_MS as u32) - 1;
        let velocity_rpm = self.velocity_rpm();
        self.judge_position(velocity_rpm);
        let blocked = self.is_stopped_by_switch(velocity_rpm);
        if self.mode == RegulationMode::Torque && !blocked {
            let largest_ma = self.max_current_ma();
            let wanted_ma = self.kept_value(AxisParameter::TargetCurrent);
            self.regulation.target_current_ma = wanted_ma.clamp(-largest_ma, largest_ma);
            self.regulation.ramp.set(velocity_rpm);
            return;
        }
        let before_rpm = self.regulation.ramp.rpm();
        if blocked {
            self.regulation.ramp.set(0);
        } else {
            self.drive_ramp(interval_ms);
        }
        self.regulate_velocity(velocity_rpm, before_rpm, interval_ms);
    }

    /// The velocity that is wanted, by the ramp generator where AP 146 says so.
    fn drive_ramp(&mut self, interval_ms: u32) {
        let ramped = self.kept_value(AxisParameter::EnableRamp) != 0;
        let largest_rpm = self.kept_value(AxisParameter::MaxVelocity).saturating_abs();
        let acceleration = self.kept_value(AxisParameter::MaxAcceleration);
        let (wanted_rpm, brakes_at_once) = match self.mode {
            RegulationMode::Position => (self.positioning_rpm(ramped), true),
            RegulationMode::Velocity | RegulationMode::Torque => {
                (self.target_velocity.min(largest_rpm).max(-largest_rpm), false)
            }
        };
        let ramp = &mut self.regulation.ramp;
        match (ramped, brakes_at_once) {
            (false, _) => ramp.set(wanted_rpm),
            (true, true) => ramp.follow(wanted_rpm, acceleration, interval_ms),
            (true, false) => ramp.tick(wanted_rpm, acceleration, interval_ms),
        }
    }

    /// The velocity that leads to the target and can still be braked in time (§7.5; decision).
    fn positioning_rpm(&self, ramp: bool) -> i32 {
        let settings = positioning::Settings {
            max_velocity_rpm: self.kept_value(AxisParameter::MaxVelocity),
            acceleration_rpm_per_s: self.kept_value(AxisParameter::MaxAcceleration),
            p: self.kept_value(AxisParameter::PositionP),
            counts_per_turn: u32::try_from(self.counts_per_turn()).unwrap_or(u32::MAX),
            ramp,
        };
        positioning::velocity_rpm(self.target_position.wrapping_sub(self.position), &settings)
    }

    fn regulate_velocity(&mut self, velocity_rpm: i32, before_rpm: i32, interval_ms: u32) {
        let gains = Gains {
            p: self.kept_value(AxisParameter::VelocityP),
            i: self.kept_value(AxisParameter::VelocityI),
        };
        let largest_ma = self.max_current_ma();
        let ramp_rpm = self.regulation.ramp.rpm();
        let error = ramp_rpm.saturating_sub(velocity_rpm);
        let regulated_ma = self.regulation.velocity.tick(error, gains, largest_ma);
        let gained_rpm_per_s = i64::from(ramp_rpm.saturating_sub(before_rpm)) * 1000 / i64::from(interval_ms);
        let inertia = i64::from(self.kept_value(AxisParameter::MassInertiaConstant));
        let inertia_ma = inertia.saturating_mul(gained_rpm_per_s) / INERTIA_RPM_PER_S;
        let wanted_ma = i64::from(regulated_ma).saturating_add(inertia_ma);
        let wanted_ma = wanted_ma.clamp(-i64::from(largest_ma), i64::from(largest_ma));
        self.regulation.target_current_ma = i32::try_from(wanted_ma).unwrap_or(0);
    }

    /// AP 226, and flag 14: near the target, and slow (§7.5, figure 7.5).
    pub(super) fn judge_position(&mut self, velocity_rpm: i32) {
        let error = self.target_position.wrapping_sub(self.position);
        self.regulation.position_error = error;
        if self.mode == RegulationMode::Position {
            let within = |value: i32, parameter| {
                value.unsigned_abs() <= self.kept_value(parameter).max(0).unsigned_abs()
            };
            self.regulation.position_reached = within(error, AxisParameter::TargetReachedDistance)
                && within(velocity_rpm, AxisParameter::TargetReachedVelocity);
        }
    }

    /// AP 6, as far as currents can be.
    pub(super) fn max_current_ma(&self) -> i32 {
        i32::try_from(self.kept_value(AxisParameter::MaxCurrent).cast_unsigned()).unwrap_or(i32::MAX)
    }

    pub(super) fn limit_target_current(&mut self) {
        let largest_ma = self.max_current_ma();
        self.regulation.target_current_ma = self.regulation.target_current_ma.clamp(-largest_ma, largest_ma);
    }

    /// Forgets what the regulators added up, and where the ramp was: the next control period begins from how the motor turns.
    pub(super) fn reset_regulation(&mut self) {
        let position_reached = self.regulation.position_reached;
        self.regulation = Regulation { position_reached, ..Regulation::default() };
        let velocity_rpm = self.velocity_rpm();
        self.regulation.ramp.set(velocity_rpm);
    }
}
