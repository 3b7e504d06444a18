//! A second of virtual time, and a snapshot of everything.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use tmcl_tables::Command;
use tmcl_wire::{Request, serial};
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId};

fn bench(c: &mut Criterion) {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
    c.bench_function("bench/1 s standing", |b| {
        b.iter_batched_ref(|| bench.clone(), |bench| bench.advance_by(1_000_000_000), BatchSize::LargeInput);
    });
    let rotate = serial::encode_request(1, Request::new(Command::RotateRight, 0, 0, 51_200));
    bench.exchange(ModuleId(0), PortId::ALL[0], &rotate);
    bench.advance_by(2_000_000_000);
    c.bench_function("bench/1 s turning", |b| {
        b.iter_batched_ref(|| bench.clone(), |bench| bench.advance_by(1_000_000_000), BatchSize::LargeInput);
    });
    c.bench_function("bench/snapshot", |b| b.iter(|| bench.clone()));
}

criterion_group!(benches, bench);
criterion_main!(benches);
