//! How a motion begins: torque, velocity and position mode (TMCM-1640 §4.6.1 to §4.6.4, §7).

use motion_control::foc::pi::Pi;

use super::{AxisParameter, RegulationMode, Tmcm1640};

impl Tmcm1640 {
    /// Velocity mode (§4.6.1).
    pub(super) fn turn(&mut self, velocity_rpm: i32) {
        self.change_mode(RegulationMode::Velocity);
        self.target_velocity = velocity_rpm;
        self.regulation.position_reached = false;
    }

    /// Position mode (§4.6.4).
    pub(super) fn move_to(&mut self, position: i32) {
        self.change_mode(RegulationMode::Position);
        self.target_position = position;
        // Hosts poll at once: the flag is right before the reply.
        self.judge_position(self.velocity_rpm());
    }

    /// Torque mode (§7.2).
    pub(super) fn apply_torque(&mut self, current_ma: i32) {
        self.kept.set(AxisParameter::TargetCurrent.index(), current_ma);
        self.change_mode(RegulationMode::Torque);
        self.regulation.position_reached = false;
        // No regulator makes this current: it does not wait for AP 133.
        self.velocity_due = 0;
    }

    /// The velocity regulator takes over from the current that flows, and the other way round: no jump.
    pub(super) fn change_mode(&mut self, mode: RegulationMode) {
        let takes_over = (self.mode == RegulationMode::Torque) != (mode == RegulationMode::Torque);
        self.mode = mode;
        if takes_over {
            let velocity_rpm = self.velocity_rpm();
            self.regulation.ramp.set(velocity_rpm);
            self.regulation.velocity = Pi::default();
        }
    }
}
