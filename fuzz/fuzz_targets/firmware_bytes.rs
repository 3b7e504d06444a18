//! Any bytes to a module's ports: nothing panics, and every datagram for it gets whole replies.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tmcl_wire::serial::{checksum, encode_request};
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind, PortId};

fuzz_target!(|data: &[u8]| {
    let mut bench = Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311));
    // Eight bytes each: where to, and a request; or raw bytes, where the first says so.
    for chunk in data.chunks(9) {
        let (&first, rest) = chunk.split_first().expect("chunks are not empty");
        let port = PortId::ALL[usize::from(first % 4)];
        let sealed = match rest {
            &[command, kind, motor, a, b, c, d, time] if first < 0xF0 => {
                bench.advance_by(u64::from(time) * 1_000_000);
                let request = tmcl_wire::Request::from_bytes([command, kind, motor, a, b, c, d]);
                encode_request(first / 128 + 1, request).to_vec()
            }
            raw => raw.to_vec(),
        };
        let replies = bench.exchange(ModuleId(0), port, &sealed);
        assert_eq!(replies.len() % 9, 0);
        for reply in replies.chunks_exact(9) {
            let version = &reply[1..] == b"1311V111";
            assert!(version || checksum(&reply[..8]) == reply[8], "{reply:02x?}");
        }
    }
});
