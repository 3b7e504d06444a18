//! Any bytes at any times: the decoder does not panic, and after silence it understands the next datagram.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tmcl_wire::serial::encode_request;
use tmcl_wire::{Decoder, Event, Listener, Request};

const LISTENER: Listener = Listener { address: 1, secondary_address: 7, silence: 100 };

fuzz_target!(|data: &[u8]| {
    let mut decoder = Decoder::new();
    let mut now = 0;
    for pair in data.chunks_exact(2) {
        now += u64::from(pair[0]);
        decoder.push(pair[1], now, &LISTENER);
    }
    let request = Request { command: 6, kind: 1, motor: 0, value: -1 };
    let last = encode_request(1, request).map(|byte| decoder.push(byte, now + 1000, &LISTENER))[8];
    assert_eq!(last, Some(Event::Request { address: 1, request }));
});
