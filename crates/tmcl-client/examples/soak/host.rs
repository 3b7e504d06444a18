//! What a host does on the bus, and what it counts.

use std::fmt;
use std::time::Duration;

use tmcl_client::{Client, ClientError, Settings};
use tmcl_link::{Direction, Faults, FaultyLink};
use tmcl_tables::Status;

use crate::bus::{BusLink, SharedBench};

/// Longer than the silence after which a module forgets half a datagram, and shorter than some delays.
pub(crate) const TIMEOUT: Duration = Duration::from_millis(150);
const LONGEST_DELAY: Duration = Duration::from_millis(250);

/// No request may take longer.
const PATIENCE: Duration = Duration::from_secs(5);

/// What happened so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) requests: u64,
    pub(crate) repeated: u64,
    pub(crate) failures: u64,
    pub(crate) stores: u64,
    pub(crate) moves: u64,
    pub(crate) downloads: u64,
    pub(crate) power_cycles: u64,
    pub(crate) resets: u64,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { requests, repeated, failures, stores, moves, downloads, power_cycles, resets } = self;
        write!(
            f,
            "{requests} requests, {repeated} sent again, {failures} reported as failed; {stores} values stored, "
        )?;
        write!(
            f,
            "{moves} moves, {downloads} programs; {power_cycles} power cycles, {resets} software resets"
        )
    }
}

/// The host, its line, and the bench at the other end.
pub(crate) struct Host {
    pub(crate) bench: SharedBench,
    pub(crate) client: Client<FaultyLink<BusLink>>,
    pub(crate) counts: Counts,
    good_line: bool,
    /// Requests since the line became good: the first may meet what the bad one left.
    good_requests: u32,
}

impl Host {
    pub(crate) fn new(bench: SharedBench, seed: u64) -> Self {
        let line = FaultyLink::new(bench.link(), seed, Faults::NONE);
        let client = Client::with_settings(line, Settings { timeout: TIMEOUT, ..Settings::default() });
        Self { bench, client, counts: Counts::default(), good_line: true, good_requests: 0 }
    }

    /// How bad the line is from now on: the probability of each fault.
    pub(crate) fn set_line(&mut self, probability: f64) {
        // The checksum sees every single fault, but not every two of them.
        let faults = Faults { gap: 9, ..Faults::all(probability, LONGEST_DELAY) };
        for direction in [Direction::Out, Direction::In] {
            self.client.link_mut().set_faults(direction, faults);
        }
        self.good_line = probability == 0.0;
        self.good_requests = 0;
    }

    pub(crate) fn has_good_line(&self) -> bool {
        self.good_line
    }

    /// Turns to another module, which on a good line starts afresh with its first request.
    pub(crate) fn turn_to(&mut self, address: u8) {
        if self.client.settings().module_address != address {
            self.client.settings_mut().module_address = address;
            self.good_requests = 0;
        }
    }

    /// A call of the client: `Ok(None)` when the line made it fail, an error when something is wrong.
    pub(crate) fn call<T>(
        &mut self,
        call: impl FnOnce(&mut Client<FaultyLink<BusLink>>) -> Result<T, ClientError>,
    ) -> Result<Option<T>, String> {
        let start = self.bench.now();
        let result = call(&mut self.client);
        let took = self.bench.now() - start;
        let (attempts, exchange) = match self.client.last_exchange() {
            Some(exchange) => (exchange.attempts, exchange.to_string()),
            None => (0, String::new()),
        };
        self.counts.requests += 1;
        self.counts.repeated += u64::from(attempts.saturating_sub(1));
        if took > PATIENCE {
            return Err(format!("a request took {took:?}: {exchange}"));
        }
        self.good_requests = self.good_requests.saturating_add(1);
        let must_succeed = self.good_line && self.good_requests > 1;
        if must_succeed && attempts > 1 {
            return Err(format!("out of step on a good line: {exchange}"));
        }
        match result {
            Ok(value) => Ok(Some(value)),
            Err(ClientError::NoReply { .. } | ClientError::Status { status: Status::WrongChecksum, .. })
                if !must_succeed =>
            {
                self.counts.failures += 1;
                Ok(None)
            }
            Err(error) => Err(format!("{error}; {exchange}")),
        }
    }
}
