//! What a client's bytes are to the line they come along.

use virtual_bench::{Bench, PortId, Wiring};

/// One side speaks to a client in bytes, the other to a line of the bench.
pub(crate) trait Protocol: Send + 'static {
    /// What kind of line it needs.
    fn wiring(&self) -> Wiring;

    /// Bytes of the client arrive; what it shall read thereupon is appended to `out`. Returns how many were taken; the rest
    /// is offered again a little later.
    fn hear(&mut self, bytes: &[u8], bench: &mut Bench, line: PortId, out: &mut Vec<u8>) -> usize;

    /// Appends what the client shall read unasked to `out`.
    fn tell(&mut self, bench: &mut Bench, line: PortId, out: &mut Vec<u8>);
}

/// The client's bytes are those on the line.
pub(crate) struct Plain {
    wiring: Wiring,
    /// Says which baud rate the client has set, where that counts.
    baud: Option<BaudSource>,
}

/// Says which baud rate a client has set; `None` when that cannot be told.
pub(crate) type BaudSource = Box<dyn FnMut() -> Option<u32> + Send>;

impl Plain {
    pub(crate) fn new(wiring: Wiring) -> Self {
        Self { wiring, baud: None }
    }

    /// The line's rate is always that of the client.
    pub(crate) fn following(wiring: Wiring, baud: BaudSource) -> Self {
        Self { wiring, baud: Some(baud) }
    }
}

impl Protocol for Plain {
    fn wiring(&self) -> Wiring {
        self.wiring
    }

    fn hear(&mut self, bytes: &[u8], bench: &mut Bench, line: PortId, out: &mut Vec<u8>) -> usize {
        if let Some(baud) = self.baud.as_mut().and_then(|baud| baud()) {
            bench.set_rate(line, baud);
        }
        bench.converse(line, bytes, out)
    }

    fn tell(&mut self, bench: &mut Bench, line: PortId, out: &mut Vec<u8>) {
        bench.take(line, out);
    }
}
