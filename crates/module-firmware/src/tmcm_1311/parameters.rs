//! What reading and writing each axis parameter means (TMCM-1311 §6).

use motion_control::ramp::Goal;

use super::encoder::CLEAR_ON_NEXT_NULL;
use super::{AxisParameter, RampMode, Tmcm1311, i2t};
use crate::axis::{Axis, Refused};

/// Full-scale RMS current of the power stage.
const FULL_SCALE_MA: i32 = 3000;

/// Supply limits and temperature of the status word; the manual gives none (decisions, TMCM-1311).
const UNDERVOLTAGE_DV: u16 = 100;
const OVERVOLTAGE_DV: u16 = 520;
const OVERTEMPERATURE_C: i16 = 100;

impl Tmcm1311 {
    pub(super) fn parameter(&self, parameter: AxisParameter) -> i32 {
        use AxisParameter as P;
        let [coil_a, coil_b] = self.sensed.coil_currents_ma.map(i32::from);
        match parameter {
            P::TargetPosition => self.target_position,
            P::ActualPosition => self.actual_position(),
            P::VirtualPosition => self.virtual_position(),
            P::PositionError => self.position_error(),
            P::TargetVelocity => self.commanded_velocity(),
            P::ActualVelocity if self.mode == RampMode::Torque => self.measured_velocity_pps(),
            P::ActualVelocity => self.ramp.velocity_pps(),
            P::MeasuredVelocity => self.measured_velocity_pps(),
            P::VelocityReached => i32::from(self.is_velocity_reached()),
            P::TorqueTargetCurrent => self.torque_or_advance(),
            P::TorqueActualCurrent => self.torque_current_ma(),
            P::ActualCurrentScale => self.current_scale(),
            P::TargetCurrentScale => self.target_current_scale(),
            P::ClosedLoopMode => i32::from(self.is_closing_or_closed()),
            P::ClosedLoopInitialized => i32::from(self.closed().is_some()),
            P::EncoderInitialization => self.detection_state,
            P::Gamma => self.gamma(),
            P::PositionReached => i32::from(self.is_position_reached()),
            P::MaxPossibleCurrent => self.max_possible_current_ma(),
            P::StatusWord => self.status_word(),
            P::RampMode => match self.mode {
                RampMode::Position => 0,
                RampMode::Velocity => 1,
                RampMode::Torque => 2,
            },
            P::MotorCurrent => amplitude(coil_a, coil_b),
            P::PhaseACurrent => coil_a,
            P::PhaseBCurrent => coil_b,
            P::SupplyVoltage => i32::from(self.sensed.supply_voltage_dv),
            P::DcCurrent => i32::from(self.sensed.supply_current_ma),
            P::ModuleTemperature => i32::from(self.sensed.temperature_c),
            P::CoolstepActualCurrent => i32::from(self.sensed.driver.current_scale),
            P::LoadValue => i32::from(self.sensed.driver.stallguard),
            P::ClearOnNull => i32::from(self.kept_value(P::EncoderMode) & CLEAR_ON_NEXT_NULL != 0),
            P::DriverErrorFlags => i32::from(self.sensed.driver.flags),
            P::EncoderCounter => self.encoder_counter(),
            P::I2tSum => self.i2t_sum(),
            P::HomeSwitch => i32::from(self.is_home_switch_active()),
            P::RightLimitSwitch => i32::from(self.is_right_switch_active()),
            P::LeftLimitSwitch => i32::from(self.is_left_switch_active()),
            P::MaxVelocity
            | P::MaxAcceleration
            | P::MaxCurrent
            | P::StandbyCurrent
            | P::RightLimitSwitchDisable
            | P::LeftLimitSwitchDisable
            | P::VelocityReachedWindow
            | P::TorqueCurrentSlope
            | P::ThermalWindingTimeConstant
            | P::I2tLimit
            | P::I2tExceedCounter
            | P::ClearI2tFlag
            | P::FieldWeakeningMinVelocity
            | P::FieldWeakeningMaxVelocity
            | P::EncoderOffset
            | P::CurrentScaleMin
            | P::CurrentScaleMax
            | P::CurrentScaleInput
            | P::CurrentScaleLowerErrorLimit
            | P::CurrentScaleUpperErrorLimit
            | P::CurrentScaleIncrement
            | P::CurrentScaleDecrement
            | P::CurrentScaleIncrementDelay
            | P::CurrentScaleDecrementDelay
            | P::CurrentScaleEnable
            | P::CorrectionVelocityP
            | P::MaxFollowingError
            | P::MaxCorrectionVelocity
            | P::RelativePositioningOption
            | P::StartStopVelocity
            | P::PositionReachedWindow
            | P::PositionReachedTime
            | P::StandstillGain
            | P::StandstillDamping
            | P::StandstillErrorLimit
            | P::MicrostepResolution
            | P::TorqueStartStopCurrent
            | P::SoftStop
            | P::ChopperBlankTime
            | P::ChopperMode
            | P::ChopperHysteresisDecrement
            | P::ChopperHysteresisEnd
            | P::ChopperHysteresisStart
            | P::ChopperOffTime
            | P::CoolstepMinCurrent
            | P::CoolstepDownStep
            | P::CoolstepHysteresis
            | P::CoolstepUpStep
            | P::CoolstepHysteresisStart
            | P::Stallguard2Filter
            | P::Stallguard2Threshold
            | P::SlopeControlHighSide
            | P::SlopeControlLowSide
            | P::ShortProtectionDisable
            | P::ShortDetectionTime
            | P::Vsense
            | P::StopOnStallVelocity
            | P::CoolstepThresholdVelocity
            | P::CoolstepSlowRunCurrent
            | P::ReferenceSearchMode
            | P::ReferenceSearchVelocity
            | P::ReferenceSwitchVelocity
            | P::EndSwitchDistance
            | P::BoostCurrent
            | P::EncoderMode
            | P::MotorFullSteps
            | P::FreewheelingDelay
            | P::EncoderDeviationFlag
            | P::EncoderResolution
            | P::MaxEncoderDeviation
            | P::PowerDownDelay
            | P::StepDirMode => self.kept_value(parameter),
        }
    }

    pub(super) fn set_parameter(&mut self, parameter: AxisParameter, value: i32) -> Result<(), Refused> {
        use AxisParameter as P;
        if matches!(parameter, P::TargetPosition | P::TargetVelocity | P::RampMode | P::TorqueTargetCurrent) {
            self.require_obedience()?;
        }
        match parameter {
            P::TargetPosition => self.move_to(value),
            P::ActualPosition => self.redefine_position(value),
            P::TargetVelocity => self.turn(value),
            P::RampMode => self.set_mode(value)?,
            P::TorqueTargetCurrent => self.apply_torque(value)?,
            P::TorqueActualCurrent => self.set_torque_current(value),
            P::ClosedLoopMode => self.switch_closed_loop(value != 0)?,
            P::EncoderInitialization => self.switch_detection(value != 0)?,
            // Measured, although the manual's table says RW: a write is accepted and changes nothing.
            P::ActualVelocity | P::CoolstepActualCurrent => {}
            P::EncoderCounter => self.redefine_encoder(value),
            P::ThermalWindingTimeConstant => {
                self.kept.set(parameter.index(), value);
                self.i2t.set_window(i2t::window_ticks(&self.kept));
            }
            P::ClearI2tFlag => self.i2t.clear_flag(),
            P::ClearOnNull => {
                let others = self.kept_value(P::EncoderMode) & !CLEAR_ON_NEXT_NULL;
                self.kept.set(P::EncoderMode.index(), others | (value * CLEAR_ON_NEXT_NULL));
            }
            _ => self.kept.set(parameter.index(), value),
        }
        Ok(())
    }

    /// SAP 1 calls the present place something else; the target goes along, so that nothing moves.
    fn redefine_position(&mut self, position: i32) {
        if self.closed().is_some() {
            return self.redefine_encoder(position);
        }
        let shift = position.wrapping_sub(self.ramp.position());
        self.target_position = self.target_position.wrapping_add(shift);
        self.ramp.redefine_position(position);
        if let Some(search) = &mut self.search {
            search.shift(shift);
        }
    }

    /// AP 128, written directly: goes on with the target that stands.
    fn set_mode(&mut self, mode: i32) -> Result<(), Refused> {
        match mode {
            0 => self.move_to(self.target_position),
            1 => self.turn(self.target_velocity),
            2 => self.apply_torque(self.kept_value(AxisParameter::TorqueTargetCurrent))?,
            _ => return Err(Refused::NotAvailable),
        }
        Ok(())
    }

    /// AP 2: in position mode the velocity the ramp is driving at, 0 while it brakes or rests; a stop switch leaves what was
    /// commanded in velocity mode.
    fn commanded_velocity(&self) -> i32 {
        match self.ramp.goal() {
            Goal::Velocity(velocity_pps) if self.search.is_some() => velocity_pps,
            _ if self.search.is_none() && self.mode == RampMode::Velocity => self.target_velocity,
            _ if self.ramp.is_standing() || self.ramp.is_braking() => 0,
            _ => self.top_velocity_pps() * self.ramp.velocity_pps().signum(),
        }
    }

    /// The largest velocity of what the ramp is doing now.
    pub(super) fn top_velocity_pps(&self) -> i32 {
        if self.search.is_some() {
            self.search_pace().switch_pps
        } else {
            self.kept_value(AxisParameter::MaxVelocity)
        }
    }

    /// AP 15: 3 A RMS in 32 steps, half of it with VSENSE set (AP 179).
    pub(super) fn max_possible_current_ma(&self) -> i32 {
        let steps = self.kept_value(AxisParameter::MaxCurrent) / 8 + 1;
        (FULL_SCALE_MA * steps / 32) >> self.kept_value(AxisParameter::Vsense).clamp(0, 1)
    }

    /// AP 18.
    fn status_word(&self) -> i32 {
        let bits = [
            (0, self.is_position_reached()),
            (1, self.is_velocity_reached()),
            (2, self.closed().is_some()),
            (3, self.mode == RampMode::Position),
            (4, self.mode == RampMode::Velocity),
            (5, self.mode == RampMode::Torque),
            (6, self.is_home_switch_active()),
            (7, self.is_left_switch_active()),
            (8, self.is_right_switch_active()),
            (9, self.sensed.supply_voltage_dv < UNDERVOLTAGE_DV),
            (10, self.sensed.supply_voltage_dv > OVERVOLTAGE_DV),
            (11, self.sensed.temperature_c >= OVERTEMPERATURE_C),
            (12, self.is_holding()),
            (13, self.i2t.is_flagged()),
        ];
        bits.into_iter().fold(0, |word, (bit, set)| word | (i32::from(set) << bit))
    }
}

/// √(a² + b²), rounded down. Sixteen bits each leave room: 2 · 2³⁰ fits without a sign.
fn amplitude(a: i32, b: i32) -> i32 {
    let squares = a.unsigned_abs().pow(2).saturating_add(b.unsigned_abs().pow(2));
    squares.isqrt().cast_signed()
}
