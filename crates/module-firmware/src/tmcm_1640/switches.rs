//! The stop switches: IN_0 is the right one, IN_1 the left one (§3.1; AP 162, 164 and 166).

use super::{AxisParameter, RegulationMode, Tmcm1640};

/// Bits of AP 164 and AP 166, and of the inputs.
const LEFT: i32 = 1;
const RIGHT: i32 = 2;

impl Tmcm1640 {
    /// Whether the left and the right switch's inputs are active, enabled or not.
    pub(super) fn active_switches(&self) -> [bool; 2] {
        let polarity = self.kept_value(AxisParameter::StopSwitchPolarity);
        let active = |bit: i32, input: u8| (self.sensed.inputs & input != 0) == (polarity & bit != 0);
        [active(LEFT, 1 << 1), active(RIGHT, 1 << 0)]
    }

    /// Whether an enabled and active switch lies in the direction that the motor turns in or shall turn in.
    pub(super) fn is_stopped_by_switch(&self, velocity_rpm: i32) -> bool {
        let [left, right] = self.enabled_switches();
        let wanted = match self.mode {
            RegulationMode::Torque => self.kept_value(AxisParameter::TargetCurrent),
            RegulationMode::Velocity => self.target_velocity,
            RegulationMode::Position => self.target_position.wrapping_sub(self.position),
        };
        let stops = |direction: i32| (left && direction < 0) || (right && direction > 0);
        // One that turns away from the switch again is let go on.
        stops(wanted.signum()) || (wanted == 0 && stops(velocity_rpm.signum()))
    }

    fn enabled_switches(&self) -> [bool; 2] {
        let enabled = self.kept_value(AxisParameter::StopSwitchEnable);
        let [left, right] = self.active_switches();
        [left && enabled & LEFT != 0, right && enabled & RIGHT != 0]
    }

    /// AP 162: the next switch that becomes active makes the position 0, once.
    pub(super) fn clear_on_switch(&mut self) {
        let before = self.switches_before;
        self.switches_before = self.active_switches();
        let became = before.into_iter().zip(self.switches_before).any(|(before, now)| now && !before);
        if became && self.kept_value(AxisParameter::ClearOnSwitch) != 0 {
            self.zero_position();
            self.kept.set(AxisParameter::ClearOnSwitch.index(), 0);
        }
    }
}
