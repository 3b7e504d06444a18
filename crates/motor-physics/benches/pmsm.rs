//! A second of virtual time of the bare brushless motor: 20 000 steps of 50 µs.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use motor_physics::mechanics::Mechanics;
use motor_physics::pmsm::{Bridge, Pmsm};
use motor_physics::presets;

const DT_S: f64 = 50e-6;

fn second(motor: &mut Pmsm, load_nm: f64, bridge: impl Fn(&Pmsm) -> Bridge) {
    for _ in 0..20_000 {
        motor.advance(bridge(motor), load_nm, DT_S);
    }
}

fn commutated(motor: &Pmsm) -> Bridge {
    let (sine, cosine) = libm::sincos(motor.angle().electrical_rad());
    Bridge::Driven { voltage_alpha_beta_v: [-10.0 * sine, 10.0 * cosine] }
}

fn pmsm(c: &mut Criterion) {
    let parameters = presets::pmsm("QBL4208-61-04-013").expect("a preset");
    let inertia_kgm2 = parameters.rotor_inertia_kgm2 + 1e-5;
    let mechanics =
        Mechanics { inertia_kgm2, friction_nm: 2e-3, viscous_nm_s_per_rad: 2e-5, hard_stops: None };
    let mut turning = Pmsm::new(parameters, mechanics);
    second(&mut turning, -0.05, commutated);
    c.bench_function("pmsm/1 s turning", |b| {
        b.iter_batched_ref(
            || turning.clone(),
            |motor| second(motor, -0.05, commutated),
            BatchSize::SmallInput,
        );
    });
    c.bench_function("pmsm/1 s coasting", |b| {
        let coasting = |_: &Pmsm| Bridge::Floating { bus_voltage_v: 24.0 };
        b.iter_batched_ref(|| turning.clone(), |motor| second(motor, 0.0, coasting), BatchSize::SmallInput);
    });
}

criterion_group!(benches, pmsm);
criterion_main!(benches);
