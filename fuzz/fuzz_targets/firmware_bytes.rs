//! Any bytes to a module's ports: nothing panics, and every datagram for it gets whole replies, as long as no port can be
//! in ASCII mode (there is a target of its own for that).
//!
//! The first byte says what the module is, and what state it is in: an axis in closed loop, or one that commutates by its
//! encoder, takes a second of virtual time to get there, and some luck.
#![no_main]

use std::cell::LazyCell;

use libfuzzer_sys::fuzz_target;
use tmcl_wire::Request;
use tmcl_wire::serial::{checksum, encode_request};
use virtual_bench::config::Setting;
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId};

const MODULE: ModuleId = ModuleId(0);

thread_local! {
    static OPEN: LazyCell<Bench> = LazyCell::new(|| Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311)));
    static CLOSED: LazyCell<Bench> = LazyCell::new(closed);
    static HALLS: LazyCell<Bench> = LazyCell::new(|| Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1640)));
    static ENCODER: LazyCell<Bench> = LazyCell::new(by_encoder);
    static PULSES: LazyCell<Bench> = LazyCell::new(pulsed);
}

/// What comes back of a request in no time.
fn exchange(bench: &mut Bench, request: [u8; 7]) -> Vec<u8> {
    bench.exchange(MODULE, PortId::ALL[0], &encode_request(1, Request::from_bytes(request)))
}

/// A module after SAP 129, 0, 1 and the time that takes.
fn closed() -> Bench {
    let mut bench = OPEN.with(|open| Bench::clone(open));
    exchange(&mut bench, [5, 129, 0, 0, 0, 0, 1]);
    bench.advance_by(1_500_000_000);
    let initialized = exchange(&mut bench, [6, 133, 0, 0, 0, 0, 0]);
    assert_eq!(initialized[4..8], [0, 0, 0, 1], "AP 133");
    bench
}

/// A TMCM-1640 after SAP 159, 0, 7 and the time that takes, turning.
fn by_encoder() -> Bench {
    let mut bench = HALLS.with(|halls| Bench::clone(halls));
    exchange(&mut bench, [5, 159, 0, 0, 0, 0, 7]);
    exchange(&mut bench, [1, 0, 0, 0, 0, 2, 88]);
    bench.advance_by(1_500_000_000);
    let velocity = exchange(&mut bench, [6, 3, 0, 0, 0, 0, 0]);
    assert_ne!(velocity[4..8], [0, 0, 0, 0], "AP 3");
    bench
}

/// A TMCM-1076 that follows 100 000 pulses a second.
fn pulsed() -> Bench {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1076));
    exchange(&mut bench, [5, 140, 0, 0, 0, 0, 8]);
    bench.apply(MODULE, Setting::StepAccelerationHzPerS(100_000.0));
    bench.apply(MODULE, Setting::StepFrequencyHz(100_000.0));
    bench.advance_by(1_500_000_000);
    let tstep = exchange(&mut bench, [6, 135, 0, 0, 0, 0, 0]);
    assert_eq!(tstep[4..8], [0, 0, 0, 120], "AP 135");
    bench
}

fuzz_target!(|data: &[u8]| {
    let Some((state, data)) = data.split_first() else { return };
    let states = [&OPEN, &CLOSED, &HALLS, &ENCODER, &PULSES];
    let mut bench = states[usize::from(state % 5)].with(|bench| Bench::clone(bench));
    let (mut binary, mut in_step) = (true, true);
    // Eight bytes each: where to, and a request; or raw bytes, where the first says so.
    for chunk in data.chunks(9) {
        let (&first, rest) = chunk.split_first().expect("chunks are not empty");
        let port = PortId::ALL[usize::from(first % 4)];
        let sealed = match rest {
            &[command, kind, motor, a, b, c, d, time] if first < 0xF0 => {
                bench.advance_by(u64::from(time) * 1_000_000);
                let request = Request::from_bytes([command, kind, motor, a, b, c, d]);
                encode_request(first / 128 + 1, request).to_vec()
            }
            raw => raw.to_vec(),
        };
        // Command 139 leads to ASCII, and so may what sets global parameter 67. Once raw bytes have come, they may be anywhere.
        in_step &= sealed.len() == 9;
        binary &= match sealed[..] {
            [_, command, kind, ..] if in_step => command != 139 && kind != 67,
            _ => !sealed.iter().any(|byte| [139, 67].contains(byte)),
        };
        let replies = bench.exchange(MODULE, port, &sealed);
        if !binary {
            continue;
        }
        assert_eq!(replies.len() % 9, 0);
        for reply in replies.chunks_exact(9) {
            let version = [&b"1311V111"[..], b"1640V200", b"1076V102"].contains(&&reply[1..]);
            assert!(version || checksum(&reply[..8]) == reply[8], "{reply:02x?}");
        }
    }
});
