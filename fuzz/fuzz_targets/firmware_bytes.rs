//! Any bytes to a module's ports: nothing panics, and every datagram for it gets whole replies.
//!
//! The first byte says what state the module is in: an axis in closed loop takes a second of virtual time to get there, and
//! some luck.
#![no_main]

use std::cell::LazyCell;

use libfuzzer_sys::fuzz_target;
use tmcl_wire::Request;
use tmcl_wire::serial::{checksum, encode_request};
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId};

const MODULE: ModuleId = ModuleId(0);

thread_local! {
    static OPEN: LazyCell<Bench> = LazyCell::new(|| Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311)));
    static CLOSED: LazyCell<Bench> = LazyCell::new(closed);
}

/// A module after SAP 129, 0, 1 and the time that takes.
fn closed() -> Bench {
    let mut bench = OPEN.with(|open| Bench::clone(open));
    let send = |bench: &mut Bench, request| {
        bench.exchange(MODULE, PortId::ALL[0], &encode_request(1, Request::from_bytes(request)))
    };
    send(&mut bench, [5, 129, 0, 0, 0, 0, 1]);
    bench.advance_by(1_500_000_000);
    let initialized = send(&mut bench, [6, 133, 0, 0, 0, 0, 0]);
    assert_eq!(initialized[4..8], [0, 0, 0, 1], "AP 133");
    bench
}

fuzz_target!(|data: &[u8]| {
    let Some((state, data)) = data.split_first() else { return };
    let mut bench = if state % 2 == 0 { &OPEN } else { &CLOSED }.with(|bench| Bench::clone(bench));
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
        let replies = bench.exchange(MODULE, port, &sealed);
        assert_eq!(replies.len() % 9, 0);
        for reply in replies.chunks_exact(9) {
            let version = &reply[1..] == b"1311V111";
            assert!(version || checksum(&reply[..8]) == reply[8], "{reply:02x?}");
        }
    }
});
