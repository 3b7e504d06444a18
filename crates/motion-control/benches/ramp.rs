//! How long a tick of the ramp takes: standing, accelerating, and braking (the longest way through).
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use motion_control::ramp::{Goal, Limits, Ramp};

const LIMITS: Limits =
    Limits { max_velocity_pps: 51_200, acceleration_pps2: 51_200, start_stop_velocity_pps: 0 };

/// A ramp `ticks` into a two-second move.
fn after(ticks: u32) -> Ramp {
    let mut ramp = Ramp::default();
    ramp.set_goal(Goal::Position(51_200));
    for _ in 0..ticks {
        ramp.tick(&LIMITS);
    }
    ramp
}

fn ramp(c: &mut Criterion) {
    for (name, ticks) in [("standing", 50_000), ("accelerating", 10_000), ("braking", 30_000)] {
        let start = after(ticks);
        c.bench_function(&format!("ramp/1000 ticks {name}"), |b| {
            b.iter_batched_ref(
                || start.clone(),
                |ramp| (0..1000).for_each(|_| ramp.tick(&LIMITS)),
                BatchSize::SmallInput,
            );
        });
    }
}

criterion_group!(benches, ramp);
criterion_main!(benches);
