//! Stop switches and home switch: which are active (TMCM-1311 §6, AP 9 to 11; §10.1, GP 79).
//!
//! Contacts are normally closed, so that a broken wire stops the motor: an open one is active (decision, from §9).

use super::Tmcm1311;

/// IN_1, which is the home switch too.
const HOME_INPUT: u8 = 1 << 1;

impl Tmcm1311 {
    pub(super) fn is_left_switch_active(&self) -> bool {
        self.sensed.left_switch_open != self.reversed_switches
    }

    pub(super) fn is_right_switch_active(&self) -> bool {
        self.sensed.right_switch_open != self.reversed_switches
    }

    /// Its contact pulls IN_1 down while it is closed.
    pub(super) fn is_home_switch_active(&self) -> bool {
        let open = self.sensed.inputs & HOME_INPUT != 0;
        open != self.reversed_switches
    }
}
