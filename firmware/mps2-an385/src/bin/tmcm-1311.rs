//! A TMCM-1311 without physics: what its controller would run.
#![no_std]
#![no_main]

use module_firmware::tmcm_1311::{Drive, Sensed, Tmcm1311};
use mps2_an385::{Exchange, run};

#[cortex_m_rt::entry]
fn main() -> ! {
    run::<Tmcm1311>(Exchange::<Sensed, Drive>::new())
}
