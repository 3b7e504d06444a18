//! What went over the line, for those who want to see it.

use std::fmt;

use tmcl_wire::Request;
use tmcl_wire::serial::DATAGRAM_LENGTH;

use crate::Described;

/// The last request, and all that came until it was answered or given up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// What was asked.
    pub request: Request,
    /// The bytes sent, each time the same.
    pub sent: [u8; DATAGRAM_LENGTH],
    /// How often they were sent.
    pub attempts: u32,
    /// Every byte that came, noise and replies to others included.
    pub received: Vec<u8>,
    /// Whether the last nine of them answer the request.
    pub answered: bool,
}

impl Exchange {
    pub(crate) fn new(request: Request, sent: [u8; DATAGRAM_LENGTH]) -> Self {
        Self { request, sent, attempts: 0, received: Vec::new(), answered: false }
    }

    /// The bytes of the answer.
    #[must_use]
    pub fn reply(&self) -> Option<[u8; DATAGRAM_LENGTH]> {
        self.received.last_chunk().copied().filter(|_| self.answered)
    }
}

/// `sent 01 06 01 00 00 00 00 00 08 (GAP 1, 0), received 02 01 64 06 00 00 00 00 6d`.
impl fmt::Display for Exchange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sent {} ({})", hexadecimal(&self.sent), Described(self.request))?;
        if self.attempts > 1 {
            write!(f, " {} times", self.attempts)?;
        }
        match self.received.as_slice() {
            [] => f.write_str(", received nothing"),
            received => write!(f, ", received {}", hexadecimal(received)),
        }
    }
}

/// Bytes as two digits each.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    let digits: Vec<_> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    digits.join(" ")
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use tmcl_tables::Command;

    use super::*;
    use crate::fake::{FakeModule, Fault};
    use crate::{Client, ClientError};

    #[test]
    fn what_went_over_the_line_can_be_seen() {
        let mut client = Client::new(FakeModule::with_faults([Fault::Noise(vec![0xFF, 0x00])]));
        assert_eq!(client.last_exchange(), None);
        client.get_axis_parameter(1).expect("it answers");
        let exchange = client.last_exchange().expect("there was one");
        assert_eq!(
            exchange.to_string(),
            "sent 01 06 01 00 00 00 00 00 08 (GAP 1, 0), received ff 00 02 01 64 06 01 02 06 01 77"
        );
        assert_eq!(exchange.reply(), Some([2, 1, 100, 6, 1, 2, 6, 1, 0x77]));
        assert_eq!((exchange.attempts, exchange.answered), (1, true));
    }

    #[test]
    fn so_can_what_did_not_come() {
        let mut client = Client::new(FakeModule::with_faults([Fault::LoseReply, Fault::DropByte(0)]));
        client.get_axis_parameter(1).expect("it answers at last");
        let exchange = client.last_exchange().expect("there was one").clone();
        assert_eq!((exchange.attempts, exchange.received.len()), (3, 17));
        client.settings_mut().module_address = 7;
        client.settings_mut().timeout = Duration::from_millis(150);
        let error = client.move_by(5).expect_err("nobody is there");
        assert!(matches!(error, ClientError::NoReply { attempts: 1, .. }), "{error}");
        let exchange = client.last_exchange().expect("there was one");
        assert_eq!(exchange.request, Request::new(Command::MoveToPosition, 1, 0, 5));
        assert_eq!(exchange.to_string(), "sent 07 04 01 00 00 00 00 05 11 (MVP REL, 0, 5), received nothing");
        assert_eq!(exchange.reply(), None);
        client.settings_mut().module_address = 1;
        client.send(Request::new(Command::MotorStop, 0, 0, 0)).expect("the line works");
        assert_eq!(
            client.last_exchange().expect("there was one").to_string(),
            "sent 01 03 00 00 00 00 00 00 04 (MST 0), received nothing"
        );
    }
}
