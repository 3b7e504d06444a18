//! Virtual seconds per wall second of a whole virtual TMCM-1640, for `motor-physics/benches/compare/compare.py`.
//!
//! Firmware, power stage, motor, sensors and supply of the default bench, turning at 2000 rpm. Prints the fastest of a few runs.
#![allow(clippy::disallowed_methods, reason = "it measures itself: the clock never reaches the bench")]

use std::time::Instant;

use tmcl_tables::Command;
use tmcl_wire::{Request, serial};
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId};

const MODULE: ModuleId = ModuleId(0);
const SECOND_NS: u64 = 1_000_000_000;
const RUNS: usize = 5;
const VELOCITY_RPM: i32 = 2000;

fn main() {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1640));
    let request = Request { command: Command::RotateRight.number(), kind: 0, motor: 0, value: VELOCITY_RPM };
    bench.exchange(MODULE, PortId::ALL[0], &serial::encode_request(1, request));
    bench.advance_by(3 * SECOND_NS);
    let fastest = (0..RUNS).map(|_| {
        let mut bench = bench.clone();
        let begin = Instant::now();
        bench.advance_by(2 * SECOND_NS);
        2.0 / begin.elapsed().as_secs_f64()
    });
    println!("{}", fastest.fold(0.0, f64::max));
}
