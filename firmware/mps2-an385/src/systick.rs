//! The processor's SysTick timer: the control period of a module, and a count of cycles.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// The clock of the board's processor.
pub const CLOCK_HZ: u32 = 25_000_000;

/// Cycles in a control period.
pub const PERIOD: u32 = CLOCK_HZ / module_firmware::TICKS_PER_SECOND as u32;

/// SysTick counts 24 bits.
const LARGEST: u32 = 0x00FF_FFFF;

/// SysTick as the clock of control periods.
pub struct ControlPeriods(SYST);

impl ControlPeriods {
    /// Begins the first control period.
    #[must_use]
    pub fn begin() -> Self {
        Self(start(PERIOD - 1))
    }

    /// Whether another control period is over.
    pub fn is_over(&mut self) -> bool {
        self.0.has_wrapped()
    }
}

/// SysTick as a stop watch.
pub struct Cycles(SYST);

impl Cycles {
    /// Begins to count.
    #[must_use]
    pub fn count() -> Self {
        Self(start(LARGEST))
    }

    /// What it counts now, downwards and round.
    #[must_use]
    pub fn now(&self) -> u32 {
        SYST::get_current()
    }

    /// Cycles between two counts, less than 2²⁴ of them.
    #[must_use]
    pub fn between(&self, earlier: u32, later: u32) -> u32 {
        earlier.wrapping_sub(later) & LARGEST
    }

    /// Whether it counts; it always does.
    #[must_use]
    pub fn is_counting(&mut self) -> bool {
        self.0.is_counter_enabled()
    }
}

fn start(reload: u32) -> SYST {
    // SAFETY: whoever has a `ControlPeriods` or a `Cycles` is the only one to use SysTick: an image makes one of them, once.
    let mut syst = unsafe { cortex_m::Peripherals::steal() }.SYST;
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(reload);
    syst.clear_current();
    syst.enable_counter();
    syst
}
