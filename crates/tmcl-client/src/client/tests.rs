//! Requests through lines that lose, spoil, delay and invent bytes.

use proptest::prelude::*;

use super::*;
use crate::fake::{FakeModule, Fault, value_of};

const TIMEOUT: Duration = Duration::from_secs(1);

fn client(faults: impl IntoIterator<Item = Fault>) -> Client<FakeModule> {
    Client::new(FakeModule::with_faults(faults))
}

fn repeated(fault: &Fault, times: usize) -> Vec<Fault> {
    vec![fault.clone(); times]
}

#[test]
fn a_quiet_line_costs_no_time_and_no_second_request() {
    let mut client = client([]);
    assert_eq!(client.get_axis_parameter(5).expect("it answers"), value_of(5));
    client.set_axis_parameter(5, -7).expect("it answers");
    assert_eq!(client.get_axis_parameter(5).expect("it answers"), -7);
    let module = client.into_link();
    assert_eq!((module.executed.len(), module.now), (3, Duration::ZERO));
}

#[test]
fn every_call_sends_what_its_name_says() {
    let mut client = client([]);
    client.rotate(-500).expect("it answers");
    client.stop_motor().expect("it answers");
    client.move_to(90_000).expect("it answers");
    client.move_by(-1000).expect("it answers");
    client.store_axis_parameter(4).expect("it answers");
    client.restore_axis_parameter(4).expect("it answers");
    client.set_global_parameter(2, 7, 11).expect("it answers");
    client.get_global_parameter(2, 7).expect("it answers");
    client.store_global_parameter(2, 7).expect("it answers");
    client.restore_global_parameter(2, 7).expect("it answers");
    client.set_output(1, 1).expect("it answers");
    client.get_input(0, 255).expect("it answers");
    let sent = client.link.executed.iter().map(|request| crate::Described(*request).to_string());
    insta::assert_snapshot!(sent.collect::<Vec<_>>().join("\n"), @r"
    ROR 0, -500
    MST 0
    MVP ABS, 0, 90000
    MVP REL, 0, -1000
    STAP 4, 0
    RSAP 4, 0
    SGP 7, 2, 11
    GGP 7, 2
    STGP 7, 2
    RSGP 7, 2
    SIO 1, 2, 1
    GIO 255, 0
    ");
}

#[test]
fn a_refusal_is_named_and_not_repeated() {
    let mut client = client([]);
    let error = client.get_axis_parameter(255).expect_err("there is none");
    assert!(matches!(error, ClientError::Status { status: Status::WrongType, .. }));
    assert_eq!(client.link.count(Command::GetAxisParameter), 1);
}

#[test]
fn whatever_happens_to_one_reply_the_next_attempt_mends() {
    let faults = [
        Fault::LoseRequest,
        Fault::SpoilRequest(Duration::ZERO),
        Fault::LoseReply,
        Fault::FlipBit(0),
        Fault::FlipBit(17),
        Fault::FlipBit(71),
        Fault::DropByte(0),
        Fault::DropByte(8),
        Fault::Delay(TIMEOUT / 2),
        Fault::Delay(TIMEOUT * 3 / 2),
        Fault::Noise(vec![2, 1, 100]),
        Fault::Noise(vec![0; 40]),
        Fault::Foreign(2, 9),
        Fault::Foreign(5, 1),
        Fault::Event,
    ];
    for fault in faults {
        let mut client = client([fault.clone(), Fault::None]);
        assert_eq!(client.get_axis_parameter(9).expect("it answers"), value_of(9), "{fault:?}");
        assert_eq!(client.get_axis_parameter(10).expect("it answers"), value_of(10), "{fault:?}");
    }
}

#[test]
fn what_must_not_be_done_twice_is_asked_once() {
    for fault in [Fault::LoseReply, Fault::FlipBit(30), Fault::Delay(TIMEOUT * 2), Fault::LoseRequest] {
        let mut client = client([fault.clone()]);
        let error = client.move_by(1000).expect_err("the reply is missing");
        assert!(matches!(error, ClientError::NoReply { attempts: 1, .. }), "{fault:?}: {error}");
        assert!(client.link.count(Command::MoveToPosition) <= 1);
    }
    let mut client = client([Fault::SpoilRequest(Duration::ZERO)]);
    let error = client.move_by(1000).expect_err("the request was spoiled");
    assert!(matches!(error, ClientError::Status { status: Status::WrongChecksum, .. }));
    assert_eq!(client.link.count(Command::MoveToPosition), 0);
}

/// The tables of the module that answers decide, once it is known.
#[test]
fn a_parameter_may_be_read_again_where_that_does_no_harm() {
    let mut client = client([Fault::LoseReply]);
    assert!(matches!(client.get_axis_parameter(132), Err(ClientError::NoReply { attempts: 1, .. })));
    client.set_module(Some(&tmcl_tables::tmcm_1640::SPEC));
    client.link.faults.extend([Fault::None, Fault::LoseReply]);
    assert_eq!(client.get_axis_parameter(132).expect("it answers"), value_of(132));
}

/// What is known of one module says nothing of another on the same bus.
#[test]
fn every_address_has_tables_of_its_own() {
    let mut client = client([]);
    client.set_module(Some(&tmcl_tables::tmcm_1640::SPEC));
    client.settings_mut().module_address = 5;
    client.link.address = 5;
    client.link.faults.push_back(Fault::LoseReply);
    assert_eq!(client.module(), None);
    assert!(matches!(client.get_axis_parameter(132), Err(ClientError::NoReply { attempts: 1, .. })));
    client.settings_mut().module_address = 1;
    assert_eq!(client.module().map(|spec| spec.number), Some(1640));
}

#[test]
fn silence_is_reported_with_what_was_heard() {
    let heard = |faults: Vec<Fault>, module: FakeModule| {
        let mut client = Client::new(FakeModule { faults: faults.into(), ..module });
        match client.get_axis_parameter(1) {
            Err(ClientError::NoReply { attempts: 3, timeout: TIMEOUT, heard, .. }) => heard,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(heard(repeated(&Fault::LoseReply, 3), FakeModule::default()), Heard::Nothing);
    assert_eq!(heard(repeated(&Fault::DropByte(3), 3), FakeModule::default()), Heard::Noise(8));
    let elsewhere = FakeModule { host: 7, ..FakeModule::default() };
    assert_eq!(heard(vec![], elsewhere), Heard::Other { host: 7, module: 1 });
    assert_eq!(heard(vec![], FakeModule { address: 3, ..FakeModule::default() }), Heard::Nothing);
}

#[test]
fn a_line_that_never_falls_silent_does_not_keep_us() {
    struct Chatter(usize);
    impl Link for Chatter {
        fn write(&mut self, _: &[u8]) -> Result<(), LinkError> {
            Ok(())
        }
        fn read(&mut self, buffer: &mut [u8], _: Duration) -> Result<usize, LinkError> {
            self.0 += buffer.len();
            buffer.fill(0x55);
            Ok(buffer.len())
        }
        fn discard_input(&mut self) -> Result<(), LinkError> {
            Ok(())
        }
    }
    let mut client = Client::new(Chatter(0));
    for _ in 0..3 {
        assert!(matches!(client.stop_motor(), Err(ClientError::NoReply { .. })));
    }
    assert!(client.link.0 < 20 * NOISE_LIMIT);
}

#[test]
fn a_module_in_download_mode_stores_what_should_be_executed() {
    let mut client = client([]);
    client.request(Request::new(Command::DownloadStart, 0, 0, 3)).expect("it answers");
    assert!(matches!(client.get_axis_parameter(1), Err(ClientError::Stored { .. })));
    // A second attempt would be a second instruction.
    client.link.faults.extend([Fault::LoseReply]);
    assert!(matches!(client.get_axis_parameter(1), Err(ClientError::NoReply { attempts: 1, .. })));
    client.request(Request::new(Command::DownloadEnd, 0, 0, 0)).expect("it answers");
    client.link.faults.extend([Fault::LoseReply]);
    assert_eq!(client.get_axis_parameter(1).expect("it answers"), value_of(1));
}

#[test]
fn another_address_is_talked_to_after_settings_change() {
    let mut client = client([]);
    client.set_global_parameter(0, 66, 9).expect("it answers");
    client.link.address = 9;
    client.settings_mut().module_address = 9;
    assert_eq!(client.get_axis_parameter(1).expect("it answers"), value_of(1));
}

#[test]
fn the_answer_to_something_sent_blindly_is_not_taken_for_another() {
    let mut client = client([Fault::Delay(TIMEOUT / 2)]);
    client.send(Request::new(Command::GetAxisParameter, 20, 0, 0)).expect("the line works");
    assert_eq!(client.get_axis_parameter(21).expect("it answers"), value_of(21));
}

#[test]
fn what_the_last_host_asked_is_not_taken_for_an_answer() {
    let mut last = client([]);
    last.send(Request::new(Command::GetAxisParameter, 20, 0, 0)).expect("the line works");
    let mut client = Client::new(last.into_link());
    assert_eq!(client.get_axis_parameter(21).expect("it answers"), value_of(21));
}

/// The complaint is about the first attempt, and the reply to the third is still on its way.
#[test]
fn a_late_complaint_does_not_say_that_all_is_through() {
    let faults = [Fault::SpoilRequest(TIMEOUT * 16 / 5), Fault::LoseRequest, Fault::Delay(TIMEOUT * 19 / 10)];
    let mut client = client(faults);
    assert!(client.get_axis_parameter(1).is_err());
    assert_eq!(client.get_axis_parameter(2).expect("it answers"), value_of(2));
}

/// When no question is left that would have an answer of its own, only waiting helps.
#[test]
fn silence_says_that_all_is_through() {
    let mut client = client([Fault::Delay(TIMEOUT * 3 / 2), Fault::LoseRequest, Fault::LoseRequest]);
    client.send(Request::new(Command::GetAxisParameter, 20, 0, 0)).expect("the line works");
    client.send(Request::new(Command::ApplicationStatus, 0, 0, 0)).expect("the line works");
    assert_eq!(client.get_axis_parameter(21).expect("it answers"), value_of(21));
}

/// Global parameter 255 keeps a module from answering anything but its own end.
#[test]
fn a_module_that_was_told_to_be_silent_can_be_woken() {
    let mut client = client(repeated(&Fault::LoseReply, 3 + 2));
    assert!(client.get_axis_parameter(1).is_err());
    client.set_global_parameter(0, 255, 0).expect("it answers this");
}

fn delays() -> impl Strategy<Value = Duration> {
    (0..1900_u64).prop_map(Duration::from_millis)
}

fn faults() -> impl Strategy<Value = Fault> {
    prop_oneof![
        3 => Just(Fault::None),
        1 => Just(Fault::LoseRequest),
        1 => delays().prop_map(Fault::SpoilRequest),
        1 => Just(Fault::LoseReply),
        1 => (0..72_usize).prop_map(Fault::FlipBit),
        1 => (0..9_usize).prop_map(Fault::DropByte),
        2 => delays().prop_map(Fault::Delay),
        // No noise that is a datagram: nobody could tell.
        1 => proptest::collection::vec(3..=255_u8, 0..30).prop_map(Fault::Noise),
        1 => (any::<u8>(), 2..=255_u8).prop_map(|(host, module)| Fault::Foreign(host, module)),
        1 => Just(Fault::Event),
    ]
}

proptest! {
    /// A value that is returned is the value of the parameter that was asked for, whatever the line did; and it is returned
    /// when the line did nothing to the last attempt.
    #[test]
    fn no_reply_is_taken_for_another(faults in proptest::collection::vec(faults(), 0..40), numbers: [u8; 12]) {
        let mut client = client(faults);
        for number in numbers.map(|number| number % 254) {
            match client.get_axis_parameter(number) {
                Ok(value) => prop_assert_eq!(value, value_of(number)),
                Err(ClientError::NoReply { .. } | ClientError::Status { status: Status::WrongChecksum, .. }) => {}
                Err(other) => prop_assert!(false, "{}", other),
            }
        }
        client.link.faults.clear();
        prop_assert_eq!(client.get_axis_parameter(7).expect("the line is good again"), value_of(7));
    }

    /// Reading memory goes through the same lines, with replies that have less to be known by.
    #[test]
    fn no_instruction_is_taken_for_another(faults in proptest::collection::vec(faults(), 0..40)) {
        let mut client = client(faults);
        client.link.memory = (0..12).map(|n| [5, n, 0, 0, 0, 1, n]).collect();
        for address in 0..12 {
            match client.read_program_instruction(u32::from(address)) {
                Ok(instruction) => prop_assert_eq!(instruction, [5, address, 0, 0, 0, 1, address]),
                Err(ClientError::NoReply { .. } | ClientError::Status { status: Status::WrongChecksum, .. }) => {}
                Err(other) => prop_assert!(false, "{}", other),
            }
        }
    }

    /// What must not be done twice is done at most once for each call, and exactly once if the module says so.
    #[test]
    fn nothing_moves_twice(faults in proptest::collection::vec(faults(), 0..40)) {
        let mut client = client(faults);
        for call in 0..12 {
            let before = client.link.count(Command::MoveToPosition);
            let moved = client.move_by(call).is_ok();
            let after = client.link.count(Command::MoveToPosition);
            prop_assert!(after - before <= 1);
            prop_assert!(!moved || after - before == 1);
        }
    }

    /// A request in pieces, noise before it and after it: nothing panics, whatever comes.
    #[test]
    fn any_bytes_are_survived(bytes in proptest::collection::vec(any::<u8>(), 0..200), command: u8) {
        let mut client = client([Fault::Noise(bytes.clone()), Fault::Noise(bytes)]);
        let _ = client.request(Request { command, kind: 1, motor: 0, value: 3 });
        let _ = client.read_program_instruction(3);
        let _ = client.version_string();
    }
}
