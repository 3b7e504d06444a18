//! The modules' firmware on a Cortex-M3: Arm's MPS2 board with FPGA image AN385 (Arm DAI 0385), as QEMU emulates it.
//!
//! [`run`] is the whole of a module: `module-firmware` unchanged, UART 0 as its TMCL port, its records and its program in a
//! memory that survives ([`psram`]), and a [`PowerStage`] behind which is what the board drives. It allocates nothing, and
//! nothing in it panics.
#![no_std]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![warn(missing_docs)]

mod bench;
mod division;
mod memory;
mod module;
pub mod psram;
pub mod stack;
pub mod systick;
pub mod uart;

pub use bench::run_bench;
pub use memory::Exchange;
pub use module::{PowerStage, run};

/// The parts of a standard bench are not to be had, which cannot happen: it stays without power.
pub fn without_parts() -> ! {
    module::unusable()
}

/// What cannot happen: nothing here or in the crates below panics, and `cargo xtask firmware` looks for it in the image. A real
/// board has to switch its power stage off here; there is none to switch.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::bkpt();
    }
}
