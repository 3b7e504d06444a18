//! Is there a module at this address?

use std::time::Duration;

use tmcl_link::Link;
use tmcl_tables::Status;
use tmcl_wire::serial::encode_request;

use crate::answer::{Answer, Question};
use crate::exchange::Exchange;
use crate::{Client, ClientError, FirmwareVersion, Heard, version};

/// Who is at an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// Nobody, or nobody who hears us.
    Nobody,
    /// A module, and it says which it is.
    Module(FirmwareVersion),
    /// A module that does not say which it is.
    Silent(Status),
    /// Something came that is no answer: the late reply of another module, two modules at once, a wrong baud rate.
    Unclear(Heard),
}

impl<L: Link> Client<L> {
    /// Asks once whether a module is at `address` (command 136, type 1), and waits for `timeout` and no longer: for a bus on
    /// which most addresses are nobody's. The client's settings stay as they are, and so does what it knows of its module.
    ///
    /// # Errors
    /// [`ClientError::Link`] when the link is broken.
    pub fn probe(&mut self, address: u8, timeout: Duration) -> Result<Presence, ClientError> {
        let settings = self.settings();
        let request = version::binary();
        let question = Question { host: settings.host_address, module: address, request };
        if address == settings.module_address {
            self.settle()?;
        }
        self.begin(Exchange::new(request, encode_request(address, request)));
        let answer = self.write_begun().and_then(|()| self.receive(timeout, |bytes| question.reply(bytes)));
        if !matches!(answer, Ok(Ok(_))) {
            self.owe_from(address, request.command);
        }
        Ok(match answer? {
            Ok(Answer::Done(reply)) => Presence::Module(FirmwareVersion::from_value(reply.value)),
            Ok(Answer::Refused(status)) => Presence::Silent(status),
            Ok(Answer::Unknown(_)) => Presence::Unclear(Heard::OtherCommand(request.command)),
            Err(Heard::Nothing) => Presence::Nobody,
            Err(heard) => Presence::Unclear(heard),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fake::{FakeModule, Fault};

    const SHORT: Duration = Duration::from_millis(30);

    #[test]
    fn a_bus_is_searched_without_waiting_for_what_is_not_there() {
        let mut client = Client::new(FakeModule { address: 77, ..FakeModule::default() });
        let found: Vec<_> = (1..=255)
            .map(|address| (address, client.probe(address, SHORT).expect("the line works")))
            .filter(|(_, presence)| *presence != Presence::Nobody)
            .collect();
        let version = FirmwareVersion { module: 1311, major: 1, minor: 11 };
        assert_eq!(found, [(77, Presence::Module(version))]);
        // Address 1 is the client's own module, which costs it three timeouts to settle only when it is asked again.
        assert_eq!(client.link_mut().now, 254 * SHORT);
        assert_eq!(client.last_exchange().expect("there was one").sent, [255, 136, 1, 0, 0, 0, 0, 0, 136]);
    }

    #[test]
    fn what_is_no_answer_is_reported() {
        let probe = |fault| {
            let mut client = Client::new(FakeModule::with_faults([fault]));
            client.probe(1, SHORT).expect("the line works")
        };
        assert_eq!(probe(Fault::LoseReply), Presence::Nobody);
        assert_eq!(probe(Fault::FlipBit(11)), Presence::Unclear(Heard::Noise(9)));
        let spoiled = probe(Fault::SpoilRequest(Duration::ZERO));
        assert_eq!(spoiled, Presence::Silent(Status::WrongChecksum));
        let mut client = Client::new(FakeModule::with_faults([Fault::Foreign(2, 9), Fault::LoseReply]));
        assert!(matches!(client.probe(1, SHORT), Ok(Presence::Module(_))));
    }

    /// A late answer to a probe is not the answer to what is asked next.
    #[test]
    fn a_late_answer_is_waited_for_where_it_matters() {
        let late = Fault::Delay(2 * SHORT);
        let mut client = Client::new(FakeModule::with_faults([late]));
        assert_eq!(client.probe(1, SHORT).expect("the line works"), Presence::Nobody);
        client.firmware_version().expect("it answers");
        assert_eq!(client.get_axis_parameter(5).expect("it answers"), crate::fake::value_of(5));
    }

    /// Nor is it after the client has turned to that address.
    #[test]
    fn so_is_one_from_elsewhere() {
        let late = Fault::Delay(2 * SHORT);
        let mut client = Client::new(FakeModule { address: 5, ..FakeModule::with_faults([late]) });
        assert_eq!(client.probe(5, SHORT).expect("the line works"), Presence::Nobody);
        client.settings_mut().module_address = 5;
        assert!(client.is_owed());
        assert_eq!(client.get_axis_parameter(5).expect("it answers"), crate::fake::value_of(5));
        assert!(!client.is_owed());
    }
}
