//! A TMCM-1640 without physics: what its controller would run.
#![no_std]
#![no_main]

use module_firmware::tmcm_1640::{Drive, Sensed, Tmcm1640};
use mps2_an385::{Exchange, run};

#[cortex_m_rt::entry]
fn main() -> ! {
    run::<Tmcm1640>(Exchange::<Sensed, Drive>::new())
}
