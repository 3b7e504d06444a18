//! A TMCM-1640 with the physics of the default bench around it, and a harness that holds its clock.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use bench_hardware::BldcBench;
use bench_hardware::parts::BldcParts;
use cortex_m::singleton;
use module_firmware::Firmware;
use module_firmware::tmcm_1640::Tmcm1640;
use module_storage::InPlace;
use mps2_an385::psram::InPlacePrograms;
use mps2_an385::{run_bench, without_parts};

type Module = InPlace<Tmcm1640, InPlacePrograms<2048>>;

#[cortex_m_rt::entry]
fn main() -> ! {
    let place = singleton!(: MaybeUninit<Firmware<Module>> = MaybeUninit::uninit());
    let Some((place, parts)) = place.zip(BldcParts::standard()) else { without_parts() };
    run_bench(place, BldcBench::new(&parts))
}
