//! Programs through good lines and bad.

use proptest::prelude::*;

use super::*;
use crate::fake::{FakeModule, Fault};

fn program(length: u8) -> Vec<[u8; 7]> {
    (0..length).map(|number| [5, number, 0, 0, 0, 1, number]).collect()
}

fn ignore(_: usize) {}

#[test]
fn a_program_is_stored_read_back_and_compared() {
    let mut client = Client::new(FakeModule::default());
    let program = program(20);
    let mut steps = Vec::new();
    client.download(&program, &mut |done| steps.push(done)).expect("it is stored");
    assert_eq!(steps, (1..=20).collect::<Vec<_>>());
    assert_eq!(client.link_mut().download, None);
    assert_eq!(client.link_mut().memory[..20], program);
    steps.clear();
    assert_eq!(client.read_program(20, &mut |done| steps.push(done)).expect("it is read"), program);
    assert_eq!(steps, (1..=20).collect::<Vec<_>>());
    client.verify(&program, &mut ignore).expect("it is the same");
    client.link_mut().memory[13][6] = 99;
    let error = client.verify(&program, &mut ignore).expect_err("it is not the same");
    assert_eq!(
        error.to_string(),
        "the program memory differs at address 13: it should hold 05 0d 00 00 00 01 0d, and holds 05 0d 00 00 00 01 63"
    );
}

#[test]
fn an_empty_program_is_a_program() {
    let mut client = Client::new(FakeModule::default());
    client.download(&[], &mut ignore).expect("there is nothing to go wrong");
    assert_eq!(client.read_program(0, &mut ignore).expect("there is nothing to read"), [[0; 7]; 0]);
}

#[test]
fn a_protected_program_is_left_alone() {
    let mut client = Client::new(FakeModule { protected: true, ..FakeModule::default() });
    let error = client.download(&program(3), &mut ignore).expect_err("it is protected");
    assert!(matches!(error, ClientError::Status { status: Status::NotAvailable, .. }), "{error}");
    assert_eq!(client.link_mut().count(Command::DownloadEnd), 1);
}

#[test]
fn a_program_that_is_too_long_is_cut_off_where_the_memory_ends() {
    let mut client = Client::new(FakeModule::default());
    match client.download(&program(65), &mut ignore) {
        Err(ClientError::Download { address: 64, count: 65, ended: true, source }) => {
            assert!(matches!(*source, ClientError::Status { status: Status::InvalidValue, .. }));
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(client.link_mut().download, None);
}

/// Sent again, it would be stored twice, and all that follow would move up.
#[test]
fn a_lost_reply_ends_the_download_at_that_instruction() {
    for fault in [Fault::LoseReply, Fault::LoseRequest, Fault::FlipBit(20)] {
        let faults = [Fault::None, Fault::None, Fault::None, fault.clone()];
        let mut client = Client::new(FakeModule::with_faults(faults));
        match client.download(&program(5), &mut ignore) {
            Err(ClientError::Download { address: 2, count: 5, ended: true, source }) => {
                assert!(matches!(*source, ClientError::NoReply { attempts: 1, .. }), "{fault:?}");
            }
            other => panic!("{fault:?}: {other:?}"),
        }
        assert_eq!(client.link_mut().download, None, "{fault:?}");
    }
}

#[test]
fn a_download_that_does_not_end_is_reported() {
    let faults = [Fault::None, Fault::None, Fault::LoseRequest];
    let mut client = Client::new(FakeModule::with_faults(faults));
    let error = client.download(&program(1), &mut ignore).expect_err("133 is lost");
    assert!(matches!(error, ClientError::DownloadEnd { count: 1, .. }), "{error}");
}

#[test]
fn a_module_that_does_not_store_is_reported() {
    // 132 is answered, but the module then leaves download mode by itself.
    struct Forgetful(FakeModule);
    impl Link for Forgetful {
        fn write(&mut self, bytes: &[u8]) -> Result<(), tmcl_link::LinkError> {
            self.0.download = None;
            self.0.write(bytes)
        }
        fn read(
            &mut self,
            buffer: &mut [u8],
            timeout: std::time::Duration,
        ) -> Result<usize, tmcl_link::LinkError> {
            self.0.read(buffer, timeout)
        }
        fn discard_input(&mut self) -> Result<(), tmcl_link::LinkError> {
            self.0.discard_input()
        }
    }
    let mut client = Client::new(Forgetful(FakeModule::default()));
    match client.download(&program(2), &mut ignore) {
        Err(ClientError::Download { address: 0, source, .. }) => {
            assert!(matches!(*source, ClientError::Executed { .. }));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn commands_of_a_host_are_no_instructions() {
    let mut client = Client::new(FakeModule::default());
    let mut program = program(3);
    program[1] = Request::new(Command::FactoryReset, 0, 0, 1234).to_bytes();
    let error = client.download(&program, &mut ignore).expect_err("it would be executed");
    assert!(matches!(error, ClientError::NotStorable { address: 1, .. }), "{error}");
    assert!(client.link_mut().executed.is_empty());
}

#[test]
fn addresses_outside_the_memory_are_refused() {
    let mut client = Client::new(FakeModule::default());
    for address in [64, u32::MAX] {
        let error = client.read_program_instruction(address).expect_err("there is none");
        assert!(matches!(error, ClientError::Status { status: Status::InvalidValue, .. }), "{error}");
    }
}

#[test]
fn a_complaint_about_a_wrong_checksum_is_no_instruction() {
    let mut client = Client::new(FakeModule { memory: program(1), ..FakeModule::default() });
    let spoil = || Fault::SpoilRequest(std::time::Duration::ZERO);
    client.link_mut().faults.extend([spoil()]);
    assert_eq!(client.read_program_instruction(0).expect("it is read"), program(1)[0]);
    client.link_mut().faults.extend([spoil(), spoil(), spoil()]);
    let error = client.read_program_instruction(0).expect_err("it is spoiled every time");
    assert!(matches!(error, ClientError::Status { status: Status::WrongChecksum, .. }), "{error}");
}

proptest! {
    /// Whatever may stand in a program is read back as it was stored.
    #[test]
    fn programs_survive_the_round_trip(mut program in proptest::collection::vec(any::<[u8; 7]>(), 0..64)) {
        for instruction in &mut program {
            instruction[0] %= 128; // what a host sends is no instruction
            instruction[2] %= 4; // and no module has more motors or banks
            instruction[6] |= 1; // see `read_program_instruction`
        }
        let mut client = Client::new(FakeModule::default());
        client.download(&program, &mut ignore).expect("it is stored");
        client.verify(&program, &mut ignore).expect("it is the same");
    }
}
