//! A module on a board: control periods, bytes, and work in the background.

use core::mem::MaybeUninit;

use module_firmware::{Axis, Firmware, PortId};

use crate::psram;
use crate::systick::ControlPeriods;
use crate::uart::Uart;

/// What a board's sensors and power stage do, once a control period.
pub trait PowerStage {
    /// What the sensors say.
    type Sensed;
    /// What the power stage and the outputs shall do.
    type Drive;

    /// Reads the sensors.
    fn sensed(&mut self) -> Self::Sensed;
    /// Sets power stage and outputs.
    fn drive(&mut self, drive: &Self::Drive);
}

/// The port that is UART 0.
const TMCL: PortId = PortId::ALL[0];

/// Runs a module for ever. It lives in `place`, for it is too large for a stack.
pub fn run<A: Axis>(
    place: &'static mut MaybeUninit<Firmware<A>>,
    mut stage: impl PowerStage<Sensed = A::Sensed, Drive = A::Drive>,
) -> ! {
    let mut uart = Uart::tmcl();
    let instructions = A::SPEC.program_memory;
    let Ok(mut media) = psram::open(instructions) else { unusable() };
    let firmware = Firmware::power_on_in(place, &mut media);
    let mut periods = ControlPeriods::begin();
    loop {
        if periods.is_over() {
            let drive = firmware.tick(&stage.sensed());
            stage.drive(&drive);
        }
        if let Some(byte) = uart.receive() {
            // What finds no room is lost, as at every UART.
            let _ = firmware.receive(TMCL, byte);
        }
        if uart.has_room()
            && let Some(byte) = firmware.transmit(TMCL)
        {
            uart.send(byte);
        }
        firmware.background(&mut media);
    }
}

/// The media are too small for the module, which is a mistake of who put them together: it stays without power.
pub(crate) fn unusable() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
