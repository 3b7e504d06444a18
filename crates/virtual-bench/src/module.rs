//! One virtual module: firmware, hardware and EEPROM.

use module_firmware::{Axis, Firmware, Line, PORTS, PortId, RecordKey, Storage, Vm};
use tmcl_tables::GlobalParameter;
use tmcl_wire::can::Frame;

use crate::TICK_NS;
use crate::config::{Power, Setting};
use crate::eeprom::Eeprom;
use crate::refusals::Refusals;
use bench_hardware::{Hardware, Physical, PulseLevels, Surroundings};

/// What the bench does with a module of any kind.
pub(crate) trait VirtualModule {
    /// One control period, which ends at `until_ns`. Returns whether anything changed but the time.
    fn tick(&mut self, until_ns: u64) -> bool;
    /// `periods` further control periods like the last one, in which nothing changed; the last ends at `until_ns`.
    fn rest(&mut self, periods: u64, until_ns: u64);
    /// The next instant after `now_ns` at which something may change by itself.
    fn next_change_ns(&self, now_ns: u64) -> u64;
    /// Bytes arrive at a port. Returns how many were taken; the rest did not fit and may be offered again.
    fn receive(&mut self, port: PortId, bytes: &[u8]) -> usize;
    /// Appends what leaves a port to `out`.
    fn transmit(&mut self, port: PortId, out: &mut Vec<u8>);
    /// The next byte that leaves a port.
    fn transmit_byte(&mut self, port: PortId) -> Option<u8>;
    /// A frame arrives at a port on CAN. What there is no room for is lost.
    fn receive_frame(&mut self, port: PortId, frame: &Frame);
    /// The next frame that leaves a port on CAN.
    fn transmit_frame(&mut self, port: PortId) -> Option<Frame>;
    /// What a port is connected to, from now on.
    fn set_line(&mut self, port: PortId, line: Line);
    /// Bits a second on RS485.
    fn baud_rate(&self) -> u32;
    /// Bits a second on CAN.
    fn can_bit_rate(&self) -> u32;
    /// Whether bytes wait to leave a port.
    fn has_output(&self, port: PortId) -> bool;
    /// The client at a port went away.
    fn disconnect(&mut self, port: PortId);
    /// How long a line may be silent within a datagram.
    fn set_silence(&mut self, ticks: u64);
    /// Switches it off or on: the EEPROM keeps its records, the rotor its place.
    fn set_power(&mut self, on: bool);
    /// Changes something about its surroundings.
    fn apply(&mut self, setting: Setting);
    /// What an axis parameter reads; 0 where there is none.
    fn parameter(&self, number: u8) -> i32;
    /// What a global parameter reads, without side effect; 0 where there is none.
    fn global(&self, bank: u8, number: u8) -> i32;
    /// What a coordinate reads; 0 where there is none.
    fn coordinate(&self, number: u8) -> i32;
    /// What a port reads; 0 where there is none.
    fn port(&self, bank: u8, number: u8) -> i32;
    /// The raw count of the encoder.
    fn encoder_counts(&self) -> i32;
    /// Pulses at the step/direction connector, those to the right less those to the left.
    fn step_pulses(&self) -> i64;
    /// Levels that wires drive at STEP and DIR.
    fn pulse_levels(&self) -> PulseLevels;
    /// The truth about the shaft.
    fn physical(&self) -> Physical;
    /// The EEPROM.
    fn eeprom(&self) -> &Eeprom;
    /// The EEPROM, to cut its power or to take its patches.
    fn eeprom_mut(&mut self) -> &mut Eeprom;
    /// The instructions of its program that it refused.
    fn refusals(&self) -> &Refusals;
    /// The program's registers, flags and stack.
    fn program(&self) -> &Vm;
}

/// A module on the bench.
#[derive(Clone, Debug)]
pub(crate) struct Module<A: Axis, H> {
    firmware: Firmware<A>,
    hardware: H,
    eeprom: Eeprom,
    powered: bool,
    silence_ticks: Option<u64>,
    lines: [Line; PORTS],
    instructions_per_tick: u16,
    refusals: Refusals,
    time_ns: u64,
}

impl<A, H> Module<A, H>
where
    A: Axis,
    H: Hardware<Sensed = A::Sensed, Drive = A::Drive> + Surroundings,
{
    /// A module that is switched on with what its EEPROM holds, once `presets` are among it.
    pub(crate) fn new(
        hardware: H,
        mut eeprom: Eeprom,
        presets: &[(GlobalParameter, i32)],
        instructions_per_tick: u16,
    ) -> Self {
        let firmware = power_on_with(&mut eeprom, presets);
        let refusals = Refusals::default();
        let mut module = Self {
            firmware,
            hardware,
            eeprom,
            powered: true,
            silence_ticks: None,
            lines: [Line::Usb; PORTS],
            instructions_per_tick,
            refusals,
            time_ns: 0,
        };
        module.set_up();
        module.work();
        module
    }

    /// What the firmware is told by its surroundings after power-on.
    fn set_up(&mut self) {
        self.firmware.set_instructions_per_tick(self.instructions_per_tick);
        if let Some(ticks) = self.silence_ticks {
            self.firmware.set_silence(ticks);
        }
        for (port, line) in PortId::ALL.into_iter().zip(self.lines) {
            self.firmware.set_line(port, line);
        }
    }

    /// Lets the firmware finish what it has to do in the background; this EEPROM takes no time. Notes what was refused.
    fn work(&mut self) {
        while self.firmware.has_background_work() && !self.eeprom.is_cut() {
            self.firmware.background(&mut self.eeprom);
        }
        if self.powered && self.eeprom.is_cut() {
            self.fail();
        }
        if let Some(refusal) = self.firmware.take_refusal() {
            self.refusals.add(refusal, self.time_ns);
        }
    }

    /// The power is gone. What the module was about to say is lost; what can be looked at is what would be after power-on.
    fn fail(&mut self) {
        self.powered = false;
        self.hardware.apply(Setting::Power(Power::Off));
        let mut eeprom = self.eeprom.clone();
        eeprom.never_cut();
        eeprom.power_on();
        self.firmware = Firmware::power_on(&mut eeprom);
        self.set_up();
    }
}

/// The firmware after power-on, with settings of its surroundings in its EEPROM, which is written only where they differ.
fn power_on_with<A: Axis>(eeprom: &mut Eeprom, presets: &[(GlobalParameter, i32)]) -> Firmware<A> {
    eeprom.power_on();
    let firmware = Firmware::power_on(eeprom);
    let mut differs = false;
    for (parameter, value) in presets {
        let (bank, number) = parameter.address();
        if firmware.peek_global(bank, number) != Some(*value) {
            // The EEPROM has room for every parameter that is stored.
            differs |= eeprom.write(RecordKey::Global(bank, number), &value.to_le_bytes()).is_ok();
        }
    }
    if differs { Firmware::power_on(eeprom) } else { firmware }
}

impl<A, H> VirtualModule for Module<A, H>
where
    A: Axis,
    H: Hardware<Sensed = A::Sensed, Drive = A::Drive> + Surroundings,
{
    fn tick(&mut self, until_ns: u64) -> bool {
        self.time_ns = until_ns;
        if !self.powered {
            return self.hardware.advance(&A::Drive::default(), until_ns);
        }
        let sensed = self.hardware.sensed();
        let idle = self.firmware.is_idle(&sensed);
        let drive = self.firmware.tick(&sensed);
        let changed = self.hardware.advance(&drive, until_ns);
        self.work();
        changed || !idle
    }

    fn rest(&mut self, periods: u64, until_ns: u64) {
        self.time_ns = until_ns;
        self.hardware.rest(periods, until_ns);
        if self.powered {
            self.firmware.skip(periods);
        }
    }

    fn next_change_ns(&self, now_ns: u64) -> u64 {
        let quiet_ticks = if self.powered { self.firmware.quiet_ticks() } else { u64::MAX };
        let program_ns = quiet_ticks.saturating_add(1).saturating_mul(TICK_NS).saturating_add(now_ns);
        self.hardware.next_change_ns().min(program_ns)
    }

    fn receive(&mut self, port: PortId, bytes: &[u8]) -> usize {
        if !self.powered {
            return bytes.len(); // nobody listens
        }
        let taken = bytes.iter().take_while(|byte| {
            // The power may fail in the midst of them.
            let taken = !self.powered || self.firmware.receive(port, **byte);
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

    fn transmit_byte(&mut self, port: PortId) -> Option<u8> {
        let byte = self.firmware.transmit(port)?;
        // Room in the outbox lets the next request in the inbox go ahead.
        self.firmware.background(&mut self.eeprom);
        self.work();
        Some(byte)
    }

    fn receive_frame(&mut self, port: PortId, frame: &Frame) {
        if self.powered {
            // A frame that there is no room for is lost.
            let _ = self.firmware.receive_frame(port, frame);
            self.work();
        }
    }

    fn transmit_frame(&mut self, port: PortId) -> Option<Frame> {
        let frame = self.firmware.transmit_frame(port)?;
        self.firmware.background(&mut self.eeprom);
        self.work();
        Some(frame)
    }

    fn set_line(&mut self, port: PortId, line: Line) {
        if let Some(known) = self.lines.get_mut(port.index()) {
            *known = line;
        }
        self.firmware.set_line(port, line);
    }

    fn baud_rate(&self) -> u32 {
        self.firmware.baud_rate()
    }

    fn can_bit_rate(&self) -> u32 {
        self.firmware.can_bit_rate()
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

    fn set_power(&mut self, on: bool) {
        if on == self.powered {
            return;
        }
        if !on {
            return self.fail();
        }
        self.powered = true;
        self.hardware.apply(Setting::Power(Power::On));
        // Without power it forgot everything but its EEPROM.
        self.eeprom.power_on();
        self.firmware = Firmware::power_on(&mut self.eeprom);
        self.set_up();
        // The power may have failed meanwhile.
        self.work();
    }

    fn apply(&mut self, setting: Setting) {
        match setting {
            Setting::EepromCut(Some(writes)) => self.eeprom.cut_after(writes.into()),
            Setting::EepromCut(None) => self.eeprom.never_cut(),
            setting => self.hardware.apply(setting),
        }
    }

    fn parameter(&self, number: u8) -> i32 {
        A::Parameter::try_from(number).map_or(0, |parameter| self.firmware.axis().get(parameter))
    }

    fn global(&self, bank: u8, number: u8) -> i32 {
        self.firmware.peek_global(bank, number).unwrap_or(0)
    }

    fn coordinate(&self, number: u8) -> i32 {
        self.firmware.peek_coordinate(number).unwrap_or(0)
    }

    fn port(&self, bank: u8, number: u8) -> i32 {
        A::port(bank, number).map_or(0, |port| self.firmware.axis().read_port(port))
    }

    fn encoder_counts(&self) -> i32 {
        self.hardware.encoder_counts()
    }

    fn step_pulses(&self) -> i64 {
        self.hardware.step_pulses()
    }

    fn pulse_levels(&self) -> PulseLevels {
        self.hardware.pulse_levels()
    }

    fn physical(&self) -> Physical {
        self.hardware.physical()
    }

    fn eeprom(&self) -> &Eeprom {
        &self.eeprom
    }

    fn eeprom_mut(&mut self) -> &mut Eeprom {
        &mut self.eeprom
    }

    fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    fn program(&self) -> &Vm {
        self.firmware.program()
    }
}
