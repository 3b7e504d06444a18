//! A module on modelled hardware: physics and firmware on the same processor, and a harness at UART 1 that holds the clock.
//!
//! Virtual time is counted here and passes only when the harness says so; SysTick measures. Commands of the harness are a
//! letter and its operands, little-endian; each is answered with `A` and the tick by then (u64), after whatever left a
//! port meanwhile: `O`, the tick (u64), the port, a length and so many bytes.
//!
//! | command | operands | what it does |
//! |---|---|---|
//! | `T` | ticks (u32) | lets so many control periods pass |
//! | `D` | port, length, bytes | bytes arrive at a port |
//! | `P` | | switches the module off and on: what it stored is kept, the rotor keeps its place |
//! | `L` | torque (f64, Nm) | the load's torque from now on |
//! | `I` | number, level | the level of a digital input |
//! | `M` | | answers `M`, the measurements since the last `M` (six u32: [`Measured`]) |
//! | `K` | | answers `K`, the bytes of stack that were ever used and those there are (two u32) |
//! | `F` | | gives UART 0 to port 0 and lets time pass by the clock, or as fast as it can, for ever |

use core::mem::MaybeUninit;

use bench_hardware::{Hardware, Power, Setting, Surroundings, TICK_NS};
use module_firmware::{Axis, Firmware, PORTS, PortId};

use crate::module::unusable;
use crate::psram::{self, Media};
use crate::stack;
use crate::systick::{CLOCK_HZ, Cycles, PERIOD};
use crate::uart::Uart;

/// Cycles of SysTick that control periods and bytes took.
#[derive(Clone, Copy, Default)]
struct Measured {
    /// Control periods that were gone through one by one.
    periods: u32,
    /// All of them together.
    total: u32,
    /// The longest.
    longest: u32,
    /// The tick of the longest.
    longest_at: u32,
    /// The longest that a byte took, with the request that it completed.
    longest_byte: u32,
    /// The longest that one call of [`Firmware::background`] took.
    longest_work: u32,
}

/// A module and what it drives.
struct Module<A: Axis + 'static, H> {
    firmware: &'static mut Firmware<A>,
    media: Media,
    hardware: H,
    ticks: u64,
    cycles: Cycles,
    measured: Measured,
    /// Cycles that reading SysTick twice takes.
    overhead: u32,
}

impl<A, H> Module<A, H>
where
    A: Axis,
    H: Hardware<Sensed = A::Sensed, Drive = A::Drive> + Surroundings,
{
    fn now_ns(&self) -> u64 {
        self.ticks.saturating_mul(TICK_NS)
    }

    /// One control period. Whether anything changed but the time.
    fn tick(&mut self) -> bool {
        let sensed = self.hardware.sensed();
        let idle = self.firmware.is_idle(&sensed);
        let before = self.cycles.now();
        let drive = self.firmware.tick(&sensed);
        let after = self.cycles.now();
        self.ticks += 1;
        self.note_period(before, after);
        let changed = self.hardware.advance(&drive, self.now_ns());
        self.work();
        changed || !idle
    }

    fn note_period(&mut self, before: u32, after: u32) {
        let took = self.cycles.between(before, after).saturating_sub(self.overhead);
        let measured = &mut self.measured;
        measured.periods = measured.periods.wrapping_add(1);
        measured.total = measured.total.wrapping_add(took);
        if took > measured.longest {
            measured.longest = took;
            measured.longest_at = self.ticks as u32;
        }
    }

    /// Goes through the control periods, `most` at most, in which nothing can change. How many that were.
    fn rest(&mut self, most: u64) -> u64 {
        let now_ns = self.now_ns();
        let quiet_ns =
            self.firmware.quiet_ticks().saturating_add(1).saturating_mul(TICK_NS).saturating_add(now_ns);
        let change_ns = self.hardware.next_change_ns().min(quiet_ns);
        // The period in which something may change is not for resting.
        let periods = (change_ns.saturating_sub(1).saturating_sub(now_ns) / TICK_NS).min(most);
        if periods > 0 {
            self.ticks += periods;
            self.hardware.rest(periods, self.now_ns());
            self.firmware.skip(periods);
        }
        periods
    }

    /// What has to be done in the background; these media take no virtual time.
    fn work(&mut self) {
        while self.firmware.has_background_work() {
            let before = self.cycles.now();
            self.firmware.background(&mut self.media);
            let took = self.cycles.between(before, self.cycles.now()).saturating_sub(self.overhead);
            self.measured.longest_work = self.measured.longest_work.max(took);
        }
    }

    /// Whether a byte was taken.
    fn receive(&mut self, port: PortId, byte: u8) -> bool {
        let before = self.cycles.now();
        let taken = self.firmware.receive(port, byte);
        let took = self.cycles.between(before, self.cycles.now()).saturating_sub(self.overhead);
        self.measured.longest_byte = self.measured.longest_byte.max(took);
        self.work();
        taken
    }

    /// The next byte that leaves a port. Room in its outbox lets the next request go ahead.
    fn transmit(&mut self, port: PortId) -> Option<u8> {
        if let Some(byte) = self.firmware.transmit(port) {
            return Some(byte);
        }
        self.firmware.background(&mut self.media);
        self.work();
        self.firmware.transmit(port)
    }

    fn power_cycle(&mut self) {
        self.hardware.apply(Setting::Power(Power::Off));
        self.firmware.power_on_again(&mut self.media);
        self.hardware.apply(Setting::Power(Power::On));
    }
}

/// The harness at its UART.
struct Harness(Uart);

impl Harness {
    /// Waits for a byte.
    fn byte(&mut self) -> u8 {
        loop {
            if let Some(byte) = self.0.receive() {
                return byte;
            }
        }
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        bytes.fill_with(|| self.byte());
        bytes
    }

    fn say(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0.send(*byte);
        }
    }

    fn numbers(&mut self, letter: u8, numbers: &[u32]) {
        self.say(&[letter]);
        for number in numbers {
            self.say(&number.to_le_bytes());
        }
    }

    /// Tells what leaves the ports now.
    fn collect<A, H>(&mut self, module: &mut Module<A, H>)
    where
        A: Axis,
        H: Hardware<Sensed = A::Sensed, Drive = A::Drive> + Surroundings,
    {
        for (number, port) in (0..PORTS as u8).zip(PortId::ALL) {
            while module.firmware.has_output(port) {
                let mut bytes = [0; 64];
                let mut length = 0;
                for slot in &mut bytes {
                    let Some(byte) = module.transmit(port) else { break };
                    *slot = byte;
                    length += 1;
                }
                self.say(b"O");
                self.say(&module.ticks.to_le_bytes());
                self.say(&[number, length]);
                self.say(bytes.get(..usize::from(length)).unwrap_or_default());
            }
        }
    }

    fn run_ticks<A, H>(&mut self, module: &mut Module<A, H>, ticks: u32)
    where
        A: Axis,
        H: Hardware<Sensed = A::Sensed, Drive = A::Drive> + Surroundings,
    {
        let mut left = u64::from(ticks);
        while left > 0 {
            let changed = module.tick();
            left -= 1;
            self.collect(module);
            if !changed {
                left -= module.rest(left);
            }
        }
    }

    /// Bytes arrive at a port, and what leaves thereupon makes room for the rest. What finds none is lost.
    fn deliver<A, H>(&mut self, module: &mut Module<A, H>)
    where
        A: Axis,
        H: Hardware<Sensed = A::Sensed, Drive = A::Drive> + Surroundings,
    {
        let [number, length] = self.bytes();
        let port = PortId::ALL.get(usize::from(number)).copied();
        for _ in 0..length {
            let byte = self.byte();
            let Some(port) = port else { continue };
            if !module.receive(port, byte) {
                self.collect(module);
                let _ = module.receive(port, byte);
            }
        }
        self.collect(module);
    }
}

/// Runs a module on this hardware for ever. It lives in `place`, for it is too large for a stack.
pub fn run_bench<A, H>(place: &'static mut MaybeUninit<Firmware<A>>, hardware: H) -> !
where
    A: Axis,
    H: Hardware<Sensed = A::Sensed, Drive = A::Drive> + Surroundings,
{
    let Ok(mut media) = psram::open(A::SPEC.program_memory) else { unusable() };
    let firmware = Firmware::power_on_in(place, &mut media);
    let cycles = Cycles::count();
    let overhead = {
        let before = cycles.now();
        cycles.between(before, cycles.now())
    };
    let mut module =
        Module { firmware, media, hardware, ticks: 0, cycles, measured: Measured::default(), overhead };
    let mut harness = Harness(Uart::harness());
    loop {
        match harness.byte() {
            b'T' => {
                let ticks = u32::from_le_bytes(harness.bytes());
                harness.run_ticks(&mut module, ticks);
            }
            b'D' => harness.deliver(&mut module),
            b'P' => module.power_cycle(),
            b'L' => {
                let torque_nm = f64::from_le_bytes(harness.bytes());
                module.hardware.apply(Setting::LoadTorqueNm(torque_nm));
            }
            b'I' => {
                let [number, level] = harness.bytes();
                module.hardware.apply(Setting::Input { number, high: level != 0 });
            }
            b'M' => {
                let Measured { periods, total, longest, longest_at, longest_byte, longest_work } =
                    core::mem::take(&mut module.measured);
                harness.numbers(b'M', &[periods, total, longest, longest_at, longest_byte, longest_work]);
            }
            b'K' => harness.numbers(b'K', &[stack::used(), stack::size()]),
            b'F' => run_freely(module),
            _ => continue,
        }
        harness.say(b"A");
        harness.say(&module.ticks.to_le_bytes());
    }
}

/// How far virtual time may fall behind the clock before it slips, in cycles: 20 ms, as the host may let QEMU wait. What is made up
/// for at once must be far less than the silence within a datagram that makes a module forget it, 100 ms.
const PATIENCE: u32 = CLOCK_HZ / 50;

/// As a module on a desk: UART 0 is its port, and time is the clock's where the processor keeps up with it.
fn run_freely<A, H>(mut module: Module<A, H>) -> !
where
    A: Axis,
    H: Hardware<Sensed = A::Sensed, Drive = A::Drive> + Surroundings,
{
    let [port, ..] = PortId::ALL;
    let mut uart = Uart::tmcl();
    // A byte that found no room yet; the UART holds the next, and whoever sends it.
    let mut waiting = None;
    let mut last = module.cycles.now();
    let mut due = 0;
    loop {
        let now = module.cycles.now();
        due = PATIENCE.min(due + module.cycles.between(last, now));
        last = now;
        if due >= PERIOD {
            due -= PERIOD;
            if !module.tick() {
                due -= module.rest(u64::from(due / PERIOD)) as u32 * PERIOD;
            }
        }
        waiting = waiting.or_else(|| uart.receive()).filter(|byte| !module.receive(port, *byte));
        while uart.has_room()
            && let Some(byte) = module.transmit(port)
        {
            uart.send(byte);
        }
    }
}
