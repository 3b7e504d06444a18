//! Lines with several modules on them: RS485 and CAN.
//!
//! A bus joins one port of every module. What the host sends reaches all of them, and what any of them sends reaches the host;
//! who is meant is the modules' business. Time is an argument, and all state is plain data.
//!
//! This module must never know what a byte or a frame means.

mod can;
mod heard;
mod serial;
#[cfg(test)]
mod tests;
mod wire;

pub(crate) use can::{CanBus, CanStations};
pub(crate) use serial::{SerialBus, SerialStations};

/// What lies between a host and the modules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wiring {
    /// A port of the first module, by itself and without a baud rate, like USB.
    #[default]
    Usb,
    /// An RS485 bus with a port of every module on it.
    Rs485 {
        /// Bits a second, ten for each byte, half duplex: only modules whose rate this is hear it (GP 65). `None`: bytes take
        /// no time, and every module hears them.
        baud: Option<u32>,
    },
    /// A CAN bus with a port of every module on it. Frames take no time.
    Can {
        /// Bits a second: only modules whose rate this is take part (GP 69).
        bit_rate: u32,
    },
}

impl Wiring {
    /// A CAN bus at the rate that modules come with: 1 Mbit/s (TMCM-1311 §10.1).
    pub const CAN: Self = Self::Can { bit_rate: 1_000_000 };
}

/// One line of the bench as it is wired.
#[derive(Clone, Debug, Default)]
pub(crate) enum Bus {
    /// No bus: the first module's port.
    #[default]
    None,
    Serial(SerialBus),
    Can(CanBus),
}

impl Bus {
    pub(crate) fn new(wiring: Wiring, modules_hear_replies: bool) -> Self {
        match wiring {
            Wiring::Usb => Self::None,
            Wiring::Rs485 { baud } => Self::Serial(SerialBus::new(baud, modules_hear_replies)),
            Wiring::Can { bit_rate } => Self::Can(CanBus::new(bit_rate, modules_hear_replies)),
        }
    }

    /// Everything up to now. `spoke` is whether a module may have something to say. Returns whether anything happened.
    pub(crate) fn step(
        &mut self,
        now_ns: u64,
        spoke: bool,
        stations: &mut (impl SerialStations + CanStations),
    ) -> bool {
        match self {
            Self::None => false,
            Self::Serial(bus) => bus.step(now_ns, spoke, stations),
            Self::Can(bus) => spoke && bus.round(stations),
        }
    }

    /// When something happens here by itself.
    pub(crate) fn next_change_ns(&self) -> u64 {
        match self {
            Self::None | Self::Can(_) => u64::MAX,
            Self::Serial(bus) => bus.next_change_ns(),
        }
    }
}
