//! The CMSDK APB UARTs of the board (Arm DDI 0479, §4.3), polled.

/// One of the board's UARTs.
pub struct Uart {
    base: *mut u32,
}

const DATA: usize = 0;
const STATE: usize = 1;
const CONTROL: usize = 2;
const BAUD_DIVIDER: usize = 4;

const STATE_TX_FULL: u32 = 1;
const STATE_RX_FULL: u32 = 2;
const CONTROL_TX_RX: u32 = 3;

/// 25 MHz / 217 = 115 207 bit/s.
const DIVIDER_115200: u32 = 217;

impl Uart {
    /// UART 0: the module's TMCL port.
    #[must_use]
    pub fn tmcl() -> Self {
        Self::at(0x4000_4000)
    }

    /// UART 1: the harness of the images with physics.
    #[must_use]
    pub fn harness() -> Self {
        Self::at(0x4000_5000)
    }

    fn at(base: usize) -> Self {
        let mut uart = Self { base: base as *mut u32 };
        uart.write(BAUD_DIVIDER, DIVIDER_115200);
        uart.write(CONTROL, CONTROL_TX_RX);
        uart
    }

    /// A byte that has come in.
    pub fn receive(&mut self) -> Option<u8> {
        (self.read(STATE) & STATE_RX_FULL != 0).then(|| self.read(DATA) as u8)
    }

    /// Whether a byte can go out now.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.read(STATE) & STATE_TX_FULL == 0
    }

    /// Sends a byte, after those before it.
    pub fn send(&mut self, byte: u8) {
        while !self.has_room() {}
        self.write(DATA, byte.into());
    }

    fn read(&self, register: usize) -> u32 {
        // SAFETY: `at` is given the addresses of UARTs only, whose registers these are.
        unsafe { self.base.add(register).read_volatile() }
    }

    fn write(&mut self, register: usize, value: u32) {
        // SAFETY: as above.
        unsafe { self.base.add(register).write_volatile(value) }
    }
}
