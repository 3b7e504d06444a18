//! The serial heartbeat: a host on RS485 that falls silent stops the motor (TMCM-1311 §10.1, GP 68).

use tmcl_tables::GlobalParameter;

use crate::TICKS_PER_MS;
use crate::axis::{Axis, Motion};
use crate::firmware::Firmware;
use crate::line::Line;
use crate::port::PortId;

/// When the motor is stopped unless a request comes before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heartbeat {
    /// `u64::MAX` while it is off or has already stopped the motor.
    expires_at: u64,
}

impl Heartbeat {
    pub(crate) const OFF: Self = Self { expires_at: u64::MAX };
}

impl<A: Axis> Firmware<A> {
    /// A request or a line for this module came to a serial port.
    pub(crate) fn note_serial_request(&mut self, port: PortId) {
        if self.ports.get(port.index()).is_some_and(|port| port.line == Line::Rs485) {
            self.restart_heartbeat();
        }
    }

    /// It begins anew.
    pub(crate) fn restart_heartbeat(&mut self) {
        let ms = u64::try_from(self.globals.setting(GlobalParameter::SerialHeartbeat)).unwrap_or(0);
        let expires_at = if ms == 0 { u64::MAX } else { self.ticks.saturating_add(ms * TICKS_PER_MS) };
        self.heartbeat = Heartbeat { expires_at };
    }

    /// When it stops the motor: never while no RS485 line is listened to.
    pub(crate) fn heartbeat_tick(&self) -> u64 {
        let watched = self.listens_to(Line::Rs485) && self.ports.iter().any(|port| port.line == Line::Rs485);
        if watched { self.heartbeat.expires_at } else { u64::MAX }
    }

    /// Stops the motor as MST does, once, if the time is up. A program that runs goes on, and may move it again (decision).
    pub(crate) fn check_heartbeat(&mut self) {
        if self.heartbeat.expires_at <= self.ticks && self.heartbeat_tick() <= self.ticks {
            self.heartbeat = Heartbeat::OFF;
            // An axis that cannot be stopped does not move.
            let _ = self.axis.motion(Motion::Stop);
        }
    }
}
