//! Any bytes in place of replies, in pieces of any size: the client does not panic, does not wait for ever, and returns
//! nothing but what the module said.
#![no_main]

use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use tmcl_client::Client;
use tmcl_link::{Link, LinkError};
use tmcl_wire::Request;
use tmcl_wire::serial::{checksum, encode_reply};

/// Says `bytes` once, in pieces as long as `pieces` say, over and over; 0 is silence.
struct Script<'a> {
    pieces: &'a [u8],
    bytes: &'a [u8],
    reads: usize,
}

impl Link for Script<'_> {
    fn write(&mut self, _: &[u8]) -> Result<(), LinkError> {
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], _: Duration) -> Result<usize, LinkError> {
        self.reads += 1;
        let piece = usize::from(self.pieces[self.reads % self.pieces.len()] % 10);
        let (now, later) = self.bytes.split_at(piece.min(buffer.len()).min(self.bytes.len()));
        buffer[..now.len()].copy_from_slice(now);
        self.bytes = later;
        Ok(now.len())
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        Ok(())
    }
}

fuzz_target!(|data: &[u8]| {
    let Some((pieces, bytes)) = data.split_first_chunk::<8>() else { return };
    let said = |datagram: [u8; 9]| bytes.windows(9).any(|window| window == datagram);
    let mut client = Client::new(Script { pieces, bytes, reads: 0 });
    for command in [6, 4, 135, 138] {
        if let Ok(reply) = client.request(Request { command, kind: 1, motor: 0, value: 0 }) {
            assert!(said(encode_reply(2, 1, reply)), "{reply:?}");
        }
        if let Ok([a, b, c, d, e, f, g]) = client.read_program_instruction(0) {
            assert!(said([2, a, b, c, d, e, f, g, checksum(&[2, a, b, c, d, e, f, g])]));
        }
        if let Ok(version) = client.version_string() {
            assert!(bytes.windows(9).any(|window| window[0] == 2 && &window[1..] == version.as_bytes()));
        }
        let _ = client.program_status();
        let _ = client.download(&[[5, 4, 0, 0, 0, 0, 1]; 3], &mut |_| {});
    }
    assert!(client.into_link().reads <= 200 + data.len());
});
