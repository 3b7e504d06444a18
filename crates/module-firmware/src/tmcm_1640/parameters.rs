//! What reading and writing each axis parameter means (TMCM-1640 §5).

use super::{AxisParameter, RegulationMode, Tmcm1640, protection};
use crate::axis::Refused;

impl Tmcm1640 {
    pub(super) fn parameter(&self, parameter: AxisParameter) -> i32 {
        use AxisParameter as P;
        match parameter {
            P::TargetPosition => self.target_position,
            P::ActualPosition => self.position,
            P::TargetVelocity => self.target_velocity,
            P::ActualVelocity => self.velocity_rpm(),
            P::PositionReached => i32::from(self.regulation.position_reached),
            P::RampVelocity => self.regulation.ramp.rpm(),
            P::I2tSum => self.i2t_sum(),
            P::MotorCurrent => self.motor_current_ma(),
            P::SupplyVoltage => i32::from(self.sensed.supply_voltage_dv),
            P::DriverTemperature => i32::from(self.sensed.driver_temperature_adc),
            P::TargetCurrent if self.mode != RegulationMode::Torque => self.regulation.target_current_ma,
            P::StatusFlags => self.status_flags(),
            P::CurrentPidError => self.regulation.current_q.error(),
            P::CurrentPidErrorSum => self.regulation.current_q.error_sum(),
            P::EncoderCounter => self.encoder.counter(),
            P::ActualHallAngle => signed(self.hall_angle()),
            P::ActualEncoderAngle => signed(self.encoder_angle()),
            P::ActualControlledAngle => signed(self.controlled_angle()),
            P::PositionPidError => self.regulation.position_error,
            P::VelocityPidError => self.regulation.velocity.error(),
            P::VelocityPidErrorSum => self.regulation.velocity.error_sum(),
            P::MaxVelocity
            | P::MaxCurrent
            | P::TargetReachedVelocity
            | P::MotorHaltedVelocity
            | P::TargetReachedDistance
            | P::MaxAcceleration
            | P::ThermalWindingTimeConstant
            | P::I2tLimit
            | P::I2tExceedCounter
            | P::ClearI2tFlag
            | P::MinuteCounter
            | P::ReinitCommutation
            | P::PidLoopDelay
            | P::CurrentLoopDelay
            | P::EnableRamp
            | P::TargetCurrent
            | P::CommutationMode
            | P::ClearOnNull
            | P::ClearOnSwitch
            | P::ClearOnce
            | P::StopSwitchEnable
            | P::EncoderCommutationOffset
            | P::StopSwitchPolarity
            | P::CurrentP
            | P::CurrentI
            | P::StartCurrent
            | P::PositionP
            | P::VelocityP
            | P::VelocityI
            | P::MassInertiaConstant
            | P::BemfConstant
            | P::MotorCoilResistance
            | P::InitVelocity
            | P::InitSineDelay
            | P::OvervoltageProtection
            | P::InitSineMode
            | P::EncoderResolution
            | P::EncoderDirection
            | P::HallInterpolation
            | P::MotorPoles
            | P::HallSensorInvert
            | P::EnableDriver => self.kept_value(parameter),
        }
    }

    pub(super) fn set_parameter(&mut self, parameter: AxisParameter, value: i32) -> Result<(), Refused> {
        use AxisParameter as P;
        match parameter {
            P::TargetPosition => self.move_to(value),
            P::ActualPosition => self.redefine_position(value),
            P::TargetVelocity => self.turn(value),
            P::TargetCurrent => self.apply_torque(value),
            P::CommutationMode => self.set_commutation(value),
            P::ReinitCommutation => self.begin_initialization(),
            P::ThermalWindingTimeConstant => {
                self.kept.set(parameter.index(), value);
                self.i2t.set_window(protection::window_ticks(&self.kept));
            }
            P::ClearI2tFlag => self.i2t.clear_flag(),
            P::HallSensorInvert => {
                self.kept.set(parameter.index(), value);
                self.begin_halls_anew();
            }
            P::MinuteCounter => {
                self.kept.set(parameter.index(), value);
                self.minute_ticks = 0;
            }
            P::EncoderResolution | P::EncoderDirection if value != self.kept_value(parameter) => {
                self.kept.set(parameter.index(), value);
                self.forget_index();
            }
            P::MaxCurrent => {
                self.kept.set(parameter.index(), value);
                // A lower limit does not wait for AP 133.
                self.limit_target_current();
            }
            P::PidLoopDelay => {
                self.kept.set(parameter.index(), value);
                self.velocity_due = self.velocity_due.min(self.velocity_interval() - 1);
            }
            P::CurrentLoopDelay => {
                self.kept.set(parameter.index(), value);
                self.current_due = self.current_due.min(self.current_interval() - 1);
            }
            _ => self.kept.set(parameter.index(), value),
        }
        Ok(())
    }

    /// Calls the present place something else; the target goes along, so that nothing moves.
    pub(super) fn redefine_position(&mut self, position: i32) {
        let shift = position.wrapping_sub(self.position);
        self.target_position = self.target_position.wrapping_add(shift);
        self.set_position(position);
    }

    /// AP 159: the position is counted in the other sensor's steps from now on; by encoder, its offset has to be found.
    fn set_commutation(&mut self, mode: i32) {
        let before = self.counts_per_turn();
        self.kept.set(AxisParameter::CommutationMode.index(), mode);
        let position = i64::from(self.position) * self.counts_per_turn() / before;
        self.counted = self.counted_now();
        self.set_position(position as i32); // wraps
        self.target_position = self.position;
        self.begin_initialization();
    }

    /// AP 212: the angle of a field that drags the rotor.
    fn controlled_angle(&self) -> u16 {
        let drags = self.initialization.as_ref().filter(|initialization| initialization.drags());
        drags.map_or(0, |initialization| initialization.angle(0))
    }
}

/// An angle as the manual's range has it: −32 767 to 32 767.
fn signed(angle: u16) -> i32 {
    i32::from(angle.cast_signed()).max(-32_767)
}
