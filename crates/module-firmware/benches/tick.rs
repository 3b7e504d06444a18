//! How long a control period takes: the module standing, and in the middle of a move.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use module_firmware::Events;
use module_firmware::tmcm_1311::{Sensed, Tmcm1311};
use module_firmware::{Axis, Motion};

fn tick(c: &mut Criterion) {
    for (name, motion, ticks) in [("standing", Motion::Stop, 0), ("moving", Motion::MoveTo(51_200), 10_000)] {
        let mut axis = Tmcm1311::default();
        axis.motion(motion).expect("open loop moves");
        for _ in 0..ticks {
            axis.tick(&Sensed::default(), &mut Events::default());
        }
        c.bench_function(&format!("tmcm-1311/1000 ticks {name}"), |b| {
            b.iter_batched_ref(
                || axis.clone(),
                |axis| {
                    (0..1000).fold(0, |sum, _| {
                        sum + i32::from(axis.tick(&Sensed::default(), &mut Events::default()).coils[0])
                    })
                },
                BatchSize::SmallInput,
            );
        });
    }
}

criterion_group!(benches, tick);
criterion_main!(benches);
