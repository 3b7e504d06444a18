//! The lines at the ports: which of them are listened to, at what rate, and how long an answer waits.

use tmcl_tables::GlobalParameter;
use tmcl_wire::serial::DATAGRAM_LENGTH;

use crate::axis::Axis;
use crate::firmware::Firmware;
use crate::globals::Globals;
use crate::port::PortId;
use crate::{TICKS_PER_MS, TICKS_PER_SECOND};

/// What kind of line is at a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Line {
    /// A stream without a baud rate, which always listens: USB.
    #[default]
    Usb,
    /// A serial bus shared with other modules, with the baud rate of global parameter 65 and the pause of 75.
    Rs485,
    /// A CAN bus. It carries frames, not bytes.
    Can,
}

/// Bits a second by the value of global parameter 65 (TMCM-1311 §10.1, TMCM-1640 §6.1).
const BAUD_RATES: [u32; 12] =
    [9600, 14_400, 19_200, 28_800, 38_400, 57_600, 76_800, 115_200, 230_400, 250_000, 500_000, 1_000_000];

/// Bits a second by the value of global parameter 69, which begins with 2 (TMCM-1311 §10.1).
const CAN_BIT_RATES: [u32; 7] = [20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 1_000_000];

/// Bits of a byte on a serial line: start, eight, stop.
const BITS_PER_BYTE: u64 = 10;

/// How long a stream without a baud rate may be silent within a datagram, unless the surroundings know better.
const STREAM_SILENCE_TICKS: u64 = 100 * TICKS_PER_MS;

/// The rates in effect. A new one waits until the reply to the request that carried it has left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    baud: i32,
    can: i32,
    /// The port whose replies have to leave first.
    awaits: Option<PortId>,
}

impl Rates {
    pub(crate) fn new(baud: i32, can: i32) -> Self {
        Self { baud, can, awaits: None }
    }

    /// As the settings say.
    pub(crate) fn of(globals: &Globals) -> Self {
        Self::new(globals.setting(GlobalParameter::BaudRate), globals.setting(GlobalParameter::CanBitRate))
    }

    /// A change, if there is one, waits for what this port has to say.
    pub(crate) fn await_port(&mut self, port: PortId) {
        self.awaits.get_or_insert(port);
    }
}

impl<A: Axis> Firmware<A> {
    /// Says what kind of line is at a port; a USB stream by default. Told after power-on, kept when the module starts anew by
    /// itself. What the port had half heard or not yet said is forgotten when the kind changes.
    pub fn set_line(&mut self, id: PortId, line: Line) {
        if let Some(port) = self.port_mut(id).filter(|port| port.line != line) {
            port.line = line;
            port.clear();
            self.start_port(id);
            self.restart_heartbeat();
        }
    }

    /// How long every port's line may be silent within a datagram before what came of it is dropped. By default 100 ms on
    /// USB, and on RS485 as long as a datagram takes (decision).
    ///
    /// Where time does not run as fast as the clients' does, 100 ms of theirs are another number of ticks.
    pub fn set_silence(&mut self, ticks: u64) {
        for port in &mut self.ports {
            port.silence_ticks = Some(ticks);
        }
    }

    /// Bits a second on RS485 in effect (global parameter 65). A new rate counts once the reply to the request that set it
    /// has left.
    #[must_use]
    pub fn baud_rate(&self) -> u32 {
        let index = usize::try_from(self.rates.baud).unwrap_or(0);
        BAUD_RATES.get(index).copied().unwrap_or(9600)
    }

    /// Bits a second on CAN in effect (global parameter 69), likewise; 0 for a module without CAN.
    #[must_use]
    pub fn can_bit_rate(&self) -> u32 {
        let index = self.rates.can.checked_sub(2).and_then(|index| usize::try_from(index).ok());
        index.and_then(|index| CAN_BIT_RATES.get(index)).copied().unwrap_or(0)
    }

    /// Whether a line is listened to: USB always, RS485 or CAN as global parameter 88 says (decision). A module that has none
    /// has no CAN.
    pub(crate) fn listens_to(&self, line: Line) -> bool {
        let can = self.globals.setting(GlobalParameter::InterfaceSelection) != 0;
        match line {
            Line::Usb => true,
            Line::Rs485 => !can,
            Line::Can => can,
        }
    }

    /// Global parameter 88 was written: what deaf lines had half heard or still wait for is forgotten.
    pub(crate) fn select_interface(&mut self) {
        for port in PortId::ALL {
            let Some(line) = self.ports.get(port.index()).map(|port| port.line) else { continue };
            if !self.listens_to(line)
                && let Some(port) = self.port_mut(port)
            {
                port.forget_input();
            }
        }
        self.restart_heartbeat();
    }

    /// How long a port's line may be silent within a datagram.
    pub(crate) fn silence_ticks(&self, port: PortId) -> u64 {
        let Some(port) = self.ports.get(port.index()) else { return STREAM_SILENCE_TICKS };
        port.silence_ticks.unwrap_or_else(|| match port.line {
            Line::Usb | Line::Can => STREAM_SILENCE_TICKS,
            Line::Rs485 => {
                let bits = DATAGRAM_LENGTH as u64 * BITS_PER_BYTE;
                (bits * TICKS_PER_SECOND).div_ceil(u64::from(self.baud_rate()))
            }
        })
    }

    /// When what is said at a port now may leave: after the pause of global parameter 75 on RS485 (decision: milliseconds).
    pub(crate) fn ready_at(&self, port: PortId) -> u64 {
        let paused = self.ports.get(port.index()).is_some_and(|port| port.line == Line::Rs485);
        let pause_ms = if paused { self.globals.byte(GlobalParameter::TelegramPause) } else { 0 };
        self.ticks + u64::from(pause_ms) * TICKS_PER_MS
    }

    /// Control periods that can pass before the lines have something to say or a heartbeat stops the motor.
    pub(crate) fn line_quiet_ticks(&self) -> u64 {
        let speaks = self.ports.iter().filter_map(|port| port.speaks_at(self.ticks)).min();
        let next = speaks.unwrap_or(u64::MAX).min(self.heartbeat_tick());
        next.saturating_sub(self.ticks).saturating_sub(1)
    }

    /// Puts new rates in effect if nothing they have to wait for is left.
    pub(crate) fn settle_rates(&mut self) {
        let baud = self.globals.setting(GlobalParameter::BaudRate);
        let can = self.globals.setting(GlobalParameter::CanBitRate);
        if (self.rates.baud, self.rates.can) == (baud, can) {
            self.rates.awaits = None;
            return;
        }
        let awaited = self.rates.awaits.and_then(|port| self.ports.get(port.index()));
        let has_left = awaited.is_none_or(|port| self.pending.is_none() && port.is_drained());
        if has_left {
            self.rates = Rates::new(baud, can);
        }
    }
}

#[cfg(test)]
mod tests {
    use tmcl_tables::{ModuleSpec, tmcm_1311, tmcm_1640};

    use super::*;

    /// The figures stand in the tables' names, `9600 baud` and `20 kbit/s`.
    #[track_caller]
    fn assert_rates(
        spec: &ModuleSpec,
        parameter: GlobalParameter,
        unit: u32,
        rate: impl Fn(i64) -> Option<u32>,
    ) {
        let (bank, number) = parameter.address();
        let values = spec.global_parameter(bank, number).expect("there is one").parameter.values;
        assert!(!values.is_empty());
        for named in values {
            let figure: u32 = named.name.split(' ').next().expect("a figure").parse().expect("a number");
            assert_eq!(rate(named.value), Some(figure * unit), "{}", named.name);
        }
    }

    #[test]
    fn rates_are_those_of_the_tables() {
        let baud = |value| BAUD_RATES.get(usize::try_from(value).ok()?).copied();
        assert_rates(&tmcm_1311::SPEC, GlobalParameter::BaudRate, 1, baud);
        assert_rates(&tmcm_1640::SPEC, GlobalParameter::BaudRate, 1, baud);
        let can = |value: i64| CAN_BIT_RATES.get(usize::try_from(value - 2).ok()?).copied();
        assert_rates(&tmcm_1311::SPEC, GlobalParameter::CanBitRate, 1000, can);
    }
}
