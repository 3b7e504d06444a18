//! One virtual module: firmware, hardware and EEPROM.

use module_firmware::{Axis, Firmware, PortId};

use crate::eeprom::Eeprom;
use crate::hardware::{Hardware, Physical};

/// What the bench does with a module of any kind.
pub(crate) trait VirtualModule {
    /// One control period, which ends at `until_ns`.
    fn tick(&mut self, until_ns: u64);
    /// Bytes arrive at a port. Returns how many were taken; the rest did not fit and may be offered again.
    fn receive(&mut self, port: PortId, bytes: &[u8]) -> usize;
    /// Appends what leaves a port to `out`.
    fn transmit(&mut self, port: PortId, out: &mut Vec<u8>);
    /// Whether bytes wait to leave a port.
    fn has_output(&self, port: PortId) -> bool;
    /// The client at a port went away.
    fn disconnect(&mut self, port: PortId);
    /// How long a line may be silent within a datagram.
    fn set_silence(&mut self, ticks: u64);
    /// Switches it off and on again: the EEPROM keeps its records, the rotor its place.
    fn power_cycle(&mut self);
    /// The truth about the shaft.
    fn physical(&self) -> Physical;
    /// The EEPROM.
    fn eeprom(&self) -> &Eeprom;
}

/// A module on the bench.
#[derive(Clone, Debug)]
pub(crate) struct Module<A: Axis, H> {
    firmware: Firmware<A>,
    hardware: H,
    eeprom: Eeprom,
    silence_ticks: Option<u64>,
}

impl<A, H> Module<A, H>
where
    A: Axis,
    H: Hardware<Sensed = A::Sensed, Drive = A::Drive>,
{
    /// A module that is switched on with what its EEPROM holds.
    pub(crate) fn new(hardware: H, mut eeprom: Eeprom) -> Self {
        Self { firmware: Firmware::power_on(&mut eeprom), hardware, eeprom, silence_ticks: None }
    }

    /// Lets the firmware finish what it has to do in the background; this EEPROM takes no time.
    fn work(&mut self) {
        while self.firmware.has_background_work() {
            self.firmware.background(&mut self.eeprom);
        }
    }
}

impl<A, H> VirtualModule for Module<A, H>
where
    A: Axis,
    H: Hardware<Sensed = A::Sensed, Drive = A::Drive>,
{
    fn tick(&mut self, until_ns: u64) {
        let drive = self.firmware.tick(&self.hardware.sensed());
        self.hardware.advance(&drive, until_ns);
        self.work();
    }

    fn receive(&mut self, port: PortId, bytes: &[u8]) -> usize {
        let taken = bytes.iter().take_while(|byte| {
            let taken = self.firmware.receive(port, **byte);
            self.work();
            taken
        });
        taken.count()
    }

    fn transmit(&mut self, port: PortId, out: &mut Vec<u8>) {
        loop {
            while let Some(byte) = self.firmware.transmit(port) {
                out.push(byte);
            }
            // Room in the outbox lets the next request in the inbox go ahead.
            self.firmware.background(&mut self.eeprom);
            self.work();
            if !self.firmware.has_output(port) {
                break;
            }
        }
    }

    fn has_output(&self, port: PortId) -> bool {
        self.firmware.has_output(port)
    }

    fn disconnect(&mut self, port: PortId) {
        self.firmware.disconnect(port);
    }

    fn set_silence(&mut self, ticks: u64) {
        self.silence_ticks = Some(ticks);
        self.firmware.set_silence(ticks);
    }

    fn power_cycle(&mut self) {
        self.firmware = Firmware::power_on(&mut self.eeprom);
        if let Some(ticks) = self.silence_ticks {
            self.firmware.set_silence(ticks);
        }
    }

    fn physical(&self) -> Physical {
        self.hardware.physical()
    }

    fn eeprom(&self) -> &Eeprom {
        &self.eeprom
    }
}
