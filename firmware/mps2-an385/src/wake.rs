//! Sleep, for a module on a desk: the processor wakes every millisecond, and when a byte comes in.
//!
//! Nothing is interrupted: interrupts stay masked, and one that is pending ends the sleep all the same (Armv7-M, B1.5.18). The
//! timer is the CMSDK APB timer (Arm DDI 0479, §4.1); the numbers of the interrupts are the board's (Arm DAI 0385).

use cortex_m::peripheral::NVIC;

use crate::systick::CLOCK_HZ;
use crate::uart::Uart;

const TIMER_0: *mut u32 = 0x4000_0000 as *mut u32;
const TIMER_CONTROL: usize = 0;
const TIMER_VALUE: usize = 1;
const TIMER_RELOAD: usize = 2;
const TIMER_INTERRUPT_CLEAR: usize = 3;

/// The timer runs, and asks for an interrupt.
const TIMER_RUNS: u32 = 0b1001;

/// UART 0 and UART 1 have received, and the timer.
const INTERRUPTS: u32 = 1 << 0 | 1 << 2 | 1 << 8;

/// The timer's cycles between two of its interrupts.
const MILLISECOND: u32 = CLOCK_HZ / 1000;

/// What ends a sleep.
pub struct Alarm(NVIC);

impl Alarm {
    /// Sets it, for both UARTs.
    #[must_use]
    pub fn set(uarts: [&mut Uart; 2]) -> Self {
        cortex_m::interrupt::disable();
        uarts.into_iter().for_each(Uart::ask_for_interrupts);
        timer(TIMER_VALUE, MILLISECOND - 1);
        timer(TIMER_RELOAD, MILLISECOND - 1);
        timer(TIMER_CONTROL, TIMER_RUNS);
        // SAFETY: nobody else uses the NVIC, and interrupts are masked: enabling them wakes, and does no more.
        let nvic = unsafe {
            let nvic = cortex_m::Peripherals::steal().NVIC;
            nvic.iser[0].write(INTERRUPTS);
            nvic
        };
        Self(nvic)
    }

    /// Forgets what would have ended a sleep. What comes after this ends the next.
    pub fn clear(&mut self, uarts: [&mut Uart; 2]) {
        // SAFETY: as above.
        unsafe { self.0.icpr[0].write(INTERRUPTS) };
        // Only now: what asks in between is still heard, since a line that stays up is not pending a second time.
        timer(TIMER_INTERRUPT_CLEAR, 1);
        uarts.into_iter().for_each(Uart::clear_interrupts);
    }

    /// Sleeps until the next millisecond, or a byte.
    pub fn sleep(&self) {
        cortex_m::asm::wfi();
    }
}

fn timer(register: usize, value: u32) {
    // SAFETY: these are the registers of the timer, which is nobody else's.
    unsafe { TIMER_0.add(register).write_volatile(value) };
}
