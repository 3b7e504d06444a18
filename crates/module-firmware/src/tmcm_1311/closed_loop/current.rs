//! How large the current is: as large as the position error needs it (TMCM-1311 §8.8; AP 113 to 123 and 236).

use motion_control::closed_loop::current_scale;
use motion_control::sine;

use super::{AxisParameter, ClosedLoop, Operation, RampMode, Tmcm1311};

impl Tmcm1311 {
    /// Brings the current scale on its way; it stays at 255 where AP 122 is 0, where torque mode sets the current, and in the
    /// step/direction modes whose current is the maximum (§6, AP 254).
    pub(super) fn regulate_current(&mut self) {
        let regulated = self.kept_value(AxisParameter::CurrentScaleEnable) != 0
            && self.kept_value(AxisParameter::StepDirMode) <= 1
            && !self.is_torque_driven();
        let error = if regulated { self.regulated_error() } else { 0 };
        let Operation::Closed(closed) = &mut self.operation else { return };
        if regulated {
            closed.current.tick(error, &self.prepared.current);
        } else {
            closed.current.full();
        }
    }

    /// The position error that the current depends on: in encoder steps, times AP 136 where AP 115 says so. A ramp that gives
    /// way to an overload makes the error no smaller, or an encoder of few counts would never get the whole current (decision).
    fn regulated_error(&self) -> u32 {
        use AxisParameter as P;
        let error = self.closed().map_or(0, |closed| closed.rotor.counts_to(closed.shortfall()));
        let error = u32::try_from(error.unsigned_abs()).unwrap_or(u32::MAX);
        let gain = match self.kept_value(P::CurrentScaleInput) {
            0 => 1,
            _ => self.kept_value(P::StandstillGain).unsigned_abs(),
        };
        error.saturating_mul(gain)
    }

    /// Whether torque mode sets the current: not while it is held before a stop switch.
    fn is_torque_driven(&self) -> bool {
        self.search.is_none()
            && self.mode == RampMode::Torque
            && self.closed().is_some_and(|closed| !closed.torque_is_held)
    }

    /// The coil currents in 1/248 of the current scale.
    pub(in super::super) fn coil_currents(&self) -> [i16; 2] {
        let (a, b) = sine::vector(self.phase);
        match &self.operation {
            Operation::Open | Operation::Detecting(_) => [a, b],
            Operation::Aligning { .. } => {
                [a, b].map(|coil| current_scale::scaled(coil, self.alignment_current))
            }
            Operation::Closed(closed) if self.is_torque_driven() => {
                [a, b].map(|coil| self.torque_part(closed, coil))
            }
            Operation::Closed(closed) => {
                [a, b].map(|coil| current_scale::scaled(coil, closed.current.actual()))
            }
        }
    }

    /// The part of AP 15 that AP 19 is; never more than all of it.
    fn torque_part(&self, closed: &ClosedLoop, coil: i16) -> i16 {
        let largest_ma = self.max_possible_current_ma().max(1);
        let current_ma = closed.torque.actual_ma().saturating_abs().min(largest_ma);
        let doubled = 2 * i32::from(coil) * current_ma / largest_ma;
        i16::try_from((doubled + doubled.signum()) / 2).unwrap_or(coil)
    }
}
