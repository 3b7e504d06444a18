//! A TMCM-1640 without physics: what its controller would run.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m::singleton;
use module_firmware::Firmware;
use module_firmware::tmcm_1640::{Drive, Sensed, Tmcm1640};
use module_storage::InPlace;
use mps2_an385::psram::InPlacePrograms;
use mps2_an385::{Exchange, run};

type Module = InPlace<Tmcm1640, InPlacePrograms<2048>>;

#[cortex_m_rt::entry]
fn main() -> ! {
    let place = singleton!(: MaybeUninit<Firmware<Module>> = MaybeUninit::uninit());
    let Some(place) = place else { loop {} };
    run(place, Exchange::<Sensed, Drive>::new())
}
