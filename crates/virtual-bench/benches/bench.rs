//! A second of virtual time, and a snapshot of everything.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use tmcl_tables::Command;
use tmcl_tables::tmcm_1311::AxisParameter;
use tmcl_tables::{tmcm_1076, tmcm_1640};
use tmcl_wire::{Request, serial};
use virtual_bench::config::Setting;
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId, Probe, Quantity};

/// µsteps in a turn at 256 µsteps per full step.
const TURN: i32 = 51_200;

const MODULE: ModuleId = ModuleId(0);
const SECOND_NS: u64 = 1_000_000_000;

fn send(bench: &mut Bench, command: Command, kind: u8, value: i32) {
    let reply = bench.exchange(
        MODULE,
        PortId::ALL[0],
        &serial::encode_request(1, Request::new(command, kind, 0, value)),
    );
    assert_eq!(reply.get(2), Some(&100), "status 100");
}

/// Turning for a while, its ramp over.
fn turning(turns_per_s: i32) -> Bench {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
    send(&mut bench, Command::SetAxisParameter, AxisParameter::MaxVelocity.number(), 10 * TURN);
    send(&mut bench, Command::SetAxisParameter, AxisParameter::MaxAcceleration.number(), 5 * TURN);
    send(&mut bench, Command::RotateRight, 0, turns_per_s * TURN);
    bench.advance_by(3 * SECOND_NS);
    bench
}

/// In closed loop, with a current that follows the position error.
fn closed_loop() -> Bench {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
    for (parameter, value) in [
        (AxisParameter::EncoderResolution, 40_000),
        (AxisParameter::MaxVelocity, 5 * TURN),
        (AxisParameter::MaxAcceleration, 5 * TURN),
        (AxisParameter::CurrentScaleEnable, 1),
        (AxisParameter::ClosedLoopMode, 1),
    ] {
        send(&mut bench, Command::SetAxisParameter, parameter.number(), value);
    }
    bench.advance_by(2 * SECOND_NS); // the initialisation takes one
    let quantity = Quantity::Parameter(AxisParameter::ClosedLoopInitialized.number());
    assert_eq!(bench.read(Probe { module: MODULE, quantity }), 1.0, "not initialised");
    bench
}

/// In closed loop and on its way for a while.
fn closed_loop_after(command: Command, kind: u8, value: i32) -> Bench {
    let mut bench = closed_loop();
    send(&mut bench, command, kind, value);
    bench.advance_by(3 * SECOND_NS);
    bench
}

/// A brushless motor that turns at 2000 rpm, its ramp over.
fn brushless() -> Bench {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1640));
    send(&mut bench, Command::RotateRight, 0, 2000);
    bench.advance_by(3 * SECOND_NS);
    let velocity_rpm = bench.physical(MODULE).velocity_rpm;
    assert!((1900.0..2100.0).contains(&velocity_rpm), "{velocity_rpm} rpm");
    bench
}

/// A brushless motor on its way to a position far away, by its encoder.
fn brushless_positioning() -> Bench {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1640));
    let commutation = tmcm_1640::AxisParameter::CommutationMode.number();
    send(&mut bench, Command::SetAxisParameter, commutation, 7);
    send(&mut bench, Command::SetAxisParameter, tmcm_1640::AxisParameter::MaxVelocity.number(), 2000);
    bench.advance_by(2 * SECOND_NS);
    send(&mut bench, Command::MoveToPosition, 0, 100_000 * 4096);
    bench.advance_by(3 * SECOND_NS);
    let velocity_rpm = bench.physical(MODULE).velocity_rpm;
    assert!((1900.0..2100.0).contains(&velocity_rpm), "{velocity_rpm} rpm");
    bench
}

/// A TMCM-1076 that follows so many pulses a second at so many microsteps, 2^resolution, to a full step.
fn pulsed(frequency_hz: f64, resolution: i32) -> Bench {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1076));
    let parameter = tmcm_1076::AxisParameter::MicrostepResolution.number();
    send(&mut bench, Command::SetAxisParameter, parameter, resolution);
    // Quick enough not to stay in the motor's resonance.
    bench.apply(MODULE, Setting::StepAccelerationHzPerS(4.0 * frequency_hz));
    bench.apply(MODULE, Setting::StepFrequencyHz(frequency_hz));
    bench.advance_by(3 * SECOND_NS);
    let turns_per_s = frequency_hz / (200.0 * f64::from(1 << resolution));
    let velocity_rps = bench.physical(MODULE).velocity_rpm / 60.0;
    assert!((velocity_rps / turns_per_s - 1.0).abs() < 0.1, "{velocity_rps} turns a second");
    bench
}

fn bench(c: &mut Criterion) {
    let mut second = |name: &str, bench: &Bench| {
        c.bench_function(name, |b| {
            b.iter_batched_ref(|| bench.clone(), |bench| bench.advance_by(SECOND_NS), BatchSize::LargeInput);
        });
    };
    let mut standing = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
    standing.advance_by(SECOND_NS); // currents, supply and driver chip have settled
    second("bench/1 s standing", &standing);
    second("bench/1 s moving at 1 turn/s", &turning(1));
    let moving = turning(5);
    second("bench/1 s moving at 5 turns/s", &moving);
    second("bench/1 s closed loop standing", &closed_loop());
    let far = 1000 * 40_000;
    second("bench/1 s closed loop to a position", &closed_loop_after(Command::MoveToPosition, 0, far));
    second("bench/1 s closed loop at 5 turns/s", &closed_loop_after(Command::RotateRight, 0, 5 * TURN));
    let torque = AxisParameter::TorqueTargetCurrent.number();
    second("bench/1 s closed loop with 300 mA", &closed_loop_after(Command::SetAxisParameter, torque, 300));
    second("bench/1 s of a brushless motor at 2000 rpm", &brushless());
    second("bench/1 s of a brushless motor to a position", &brushless_positioning());
    second("bench/1 s of a TMCM-1076 at 16 000 pulses/s", &pulsed(16_000.0, 4));
    second("bench/1 s of a TMCM-1076 at 100 000 pulses/s", &pulsed(100_000.0, 7));
    c.bench_function("bench/snapshot", |b| b.iter(|| moving.clone()));
}

criterion_group!(benches, bench);
criterion_main!(benches);
