//! A TMCM-1311 with the physics of the default bench around it, and a harness that holds its clock.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use bench_hardware::StepperBench;
use bench_hardware::parts::StepperParts;
use cortex_m::singleton;
use module_firmware::Firmware;
use module_firmware::tmcm_1311::Tmcm1311;
use module_storage::InPlace;
use mps2_an385::psram::InPlacePrograms;
use mps2_an385::{run_bench, without_parts};

type Module = InPlace<Tmcm1311, InPlacePrograms<2048>>;

#[cortex_m_rt::entry]
fn main() -> ! {
    let place = singleton!(: MaybeUninit<Firmware<Module>> = MaybeUninit::uninit());
    let Some((place, parts)) = place.zip(StepperParts::standard()) else { without_parts() };
    run_bench(place, StepperBench::new(&parts))
}
