//! Programs on bare firmware: a debugger that looks on changes nothing, and a storage that fails gives nothing away.

mod common;

use common::Memory;
use module_firmware::tmcm_1311::{Sensed, Tmcm1311};
use module_firmware::{Breakpoints, Firmware, Halted, PortId};
use proptest::prelude::*;
use tmcl_tables::{Command, Status};
use tmcl_wire::{Request, serial};

const PORT: PortId = PortId::ALL[0];

/// A module with its storage, and what it answers.
#[derive(Clone, Debug)]
struct Host {
    firmware: Firmware<Tmcm1311>,
    storage: Memory,
}

impl Host {
    fn new(mut storage: Memory) -> Self {
        Self { firmware: Firmware::power_on(&mut storage), storage }
    }

    fn send(&mut self, request: Request) -> [u8; 9] {
        for byte in serial::encode_request(1, request) {
            assert!(self.firmware.receive(PORT, byte));
            while self.firmware.background(&mut self.storage) {}
        }
        std::array::from_fn(|_| self.firmware.transmit(PORT).expect("a reply"))
    }

    /// A command that must get this status.
    #[track_caller]
    fn command(&mut self, status: Status, command: Command, kind: u8, motor: u8, value: i32) {
        let reply = self.send(Request::new(command, kind, motor, value));
        assert_eq!(reply[2], status.number(), "{command:?}: {reply:02x?}");
    }

    fn download(&mut self, program: &[Request]) {
        self.command(Status::Ok, Command::DownloadStart, 0, 0, 0);
        for instruction in program {
            assert_eq!(self.send(*instruction)[2], Status::Loaded.number());
        }
        self.command(Status::Ok, Command::DownloadEnd, 0, 0, 0);
    }

    fn work(&mut self) {
        while self.firmware.has_background_work() {
            self.firmware.background(&mut self.storage);
        }
    }
}

fn op(command: Command, kind: u8, motor: u8, value: i32) -> Request {
    Request::new(command, kind, motor, value)
}

/// Instructions of programs that do something: they count, write parameters and outputs, move, wait, are refused, and store.
fn instruction() -> impl Strategy<Value = Request> {
    let address = || 0..24_i32;
    prop_oneof![
        4 => (0..11_u8, -3..4_i32).prop_map(|(kind, value)| op(Command::Calculate, kind, 0, value)),
        2 => (-3..4_i32).prop_map(|value| op(Command::Compare, 0, 0, value)),
        3 => (0..13_u8, address()).prop_map(|(kind, to)| op(Command::JumpConditional, kind, 0, to)),
        2 => address().prop_map(|to| op(Command::Jump, 0, 0, to)),
        2 => address().prop_map(|to| op(Command::CallSubroutine, 0, 0, to)),
        2 => Just(op(Command::ReturnFromSubroutine, 0, 0, 0)),
        3 => (0..6_u8, -1..3_i32).prop_map(|(kind, ticks)| op(Command::Wait, kind, 0, ticks)),
        2 => (0..5_u8, address()).prop_map(|(number, to)| op(Command::SetInterruptVector, number, 0, to)),
        2 => prop_oneof![0..4_u8, Just(255)].prop_map(|number| op(Command::EnableInterrupt, number, 0, 0)),
        2 => Just(op(Command::ReturnFromInterrupt, 0, 0, 0)),
        2 => (0..3_u8, 0..4_i32).prop_map(|(number, ms)| op(Command::SetGlobalParameter, number, 3, ms)),
        2 => (0..9_u8).prop_map(|number| op(Command::SetOutput, number, 2, 1)),
        2 => (-300..300_i32).prop_map(|position| op(Command::MoveToPosition, 0, 0, position)),
        1 => Just(op(Command::StoreAxisParameter, 4, 0, 0)),
        1 => Just(op(Command::GetGlobalParameter, 133, 0, 0)),
        1 => any::<[u8; 7]>().prop_map(Request::from_bytes),
    ]
    // A download takes no commands 128 to 139.
    .prop_filter("stored", |request| !(128..140).contains(&request.command))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// [`Firmware::tick_unless`], halted again and again, and then [`Firmware::tick`] make the same run as `tick` alone,
    /// however many instructions a control period has.
    #[test]
    fn halting_anywhere_and_going_on_is_never_halting(
        program in prop::collection::vec(instruction(), 1..24),
        instructions_per_tick in prop_oneof![Just(1), Just(2), Just(7), Just(50)],
        stops in prop::collection::vec(any::<bool>(), 24),
    ) {
        let mut undisturbed = Host::new(Memory::default());
        undisturbed.firmware.set_instructions_per_tick(instructions_per_tick);
        undisturbed.download(&program);
        undisturbed.command(Status::Ok, Command::ApplicationRun, 1, 0, 0);
        let mut watched = undisturbed.clone();
        let mut breakpoints = Breakpoints::new();
        for (address, stop) in (0..).zip(&stops) {
            breakpoints.set(address, *stop);
        }
        for _ in 0..400 {
            let drive = undisturbed.firmware.tick(&Sensed::default());
            undisturbed.work();
            let mut passed = None;
            let halted_drive = loop {
                // Each halt is let go once, so that an instruction after it can halt in the same control period.
                let mut halt = |_: &Firmware<Tmcm1311>, address: u16| {
                    breakpoints.contains(address) && passed.take() != Some(address)
                };
                match watched.firmware.tick_unless(&Sensed::default(), &mut halt) {
                    Ok(drive) => break drive,
                    Err(Halted { address }) => {
                        prop_assert!(breakpoints.contains(address));
                        passed = Some(address);
                    }
                }
            };
            watched.work();
            prop_assert_eq!(drive, halted_drive);
            prop_assert_eq!(format!("{:?}", watched), format!("{:?}", undisturbed));
        }
    }
}

/// Halting takes no time, and the rest of the period's instructions are those that were left.
#[test]
fn a_halt_among_several_instructions_leaves_the_rest_of_them() {
    let mut host = Host::new(Memory::default());
    host.firmware.set_instructions_per_tick(5);
    let add = op(Command::Calculate, 0, 0, 1);
    host.download(&[add, add, add, add, add, add, add, op(Command::Jump, 0, 0, 0)]);
    host.command(Status::Ok, Command::ApplicationRun, 1, 0, 0);
    let mut breakpoints = Breakpoints::new();
    breakpoints.set(3, true);
    let before = host.clone();
    for _ in 0..3 {
        let halted = host.firmware.tick_unless(&Sensed::default(), &mut breakpoints);
        assert_eq!(halted.map(|_| ()), Err(Halted { address: 3 }));
        assert_eq!(host.firmware.program().registers.accumulator, 3);
    }
    let _ = host.firmware.tick(&Sensed::default());
    assert_eq!(host.firmware.program().registers.accumulator, 5);
    let mut undisturbed = before;
    let _ = undisturbed.firmware.tick(&Sensed::default());
    assert_eq!(format!("{host:?}"), format!("{undisturbed:?}"));
}

/// A program that is protected from being read stays so if it cannot be erased.
#[test]
fn what_cannot_be_erased_stays_protected() {
    let mut host = Host::new(Memory::default());
    host.download(&[op(Command::Calculate, 9, 0, 5)]);
    host.command(Status::Ok, Command::SetGlobalParameter, 81, 0, 1);
    host.storage.erasing_fails = true;
    host.command(Status::Ok, Command::SetGlobalParameter, 64, 0, 0);
    let mut after = Host::new(host.storage);
    after.command(Status::NotAvailable, Command::ReadProgramMemory, 0, 0, 0);

    // Nor does taking the protection off help, now or after power-on.
    after.command(Status::Ok, Command::SetGlobalParameter, 64, 0, 228);
    after.command(Status::NotAvailable, Command::SetGlobalParameter, 81, 0, 0);
    let read = after.send(op(Command::ReadProgramMemory, 0, 0, 0));
    assert_ne!(&read[1..8], op(Command::Calculate, 9, 0, 5).to_bytes());
    let mut again = Host::new(after.storage);
    again.command(Status::NotAvailable, Command::ReadProgramMemory, 0, 0, 0);
}

/// A storage that fails is an instruction that fails: it is reported, and the program goes on (decisions 3.11).
#[test]
fn a_failing_storage_is_a_refusal() {
    let mut host = Host::new(Memory::default());
    host.download(&[op(Command::StoreAxisParameter, 4, 0, 0), op(Command::Calculate, 9, 0, 5)]);
    host.command(Status::Ok, Command::ApplicationRun, 1, 0, 0);
    host.storage.writing_fails = true;
    let _ = host.firmware.tick(&Sensed::default());
    assert_eq!(host.firmware.take_refusal(), None, "not before the storage has tried");
    host.work();
    let refusal = host.firmware.take_refusal().expect("a refusal");
    assert_eq!((refusal.address, refusal.status), (0, Status::NotAvailable));
    assert_eq!(host.firmware.take_refusal(), None);
    let _ = host.firmware.tick(&Sensed::default());
    assert_eq!(host.firmware.program().registers.accumulator, 5);
}

/// Real storage takes time: here one record a control period. A program that stores without a pause keeps no host waiting, and
/// no host keeps it waiting.
#[test]
fn a_program_that_stores_all_the_time_starves_nobody() {
    let mut host = Host::new(Memory::default());
    let store = op(Command::StoreAxisParameter, 4, 0, 0);
    host.download(&[store, store, op(Command::Calculate, 0, 0, 1), op(Command::Jump, 0, 0, 0)]);
    host.command(Status::Ok, Command::ApplicationRun, 1, 0, 0);
    for _ in 0..50 {
        let rounds = host.firmware.program().registers.accumulator;
        for byte in serial::encode_request(1, store) {
            assert!(host.firmware.receive(PORT, byte));
        }
        let mut reply = Vec::new();
        for _ in 0..12 {
            let _ = host.firmware.tick(&Sensed::default());
            host.firmware.background(&mut host.storage);
            reply.extend(std::iter::from_fn(|| host.firmware.transmit(PORT)));
        }
        assert_eq!(reply.get(2), Some(&Status::Ok.number()), "{reply:02x?}");
        assert!(host.firmware.program().registers.accumulator > rounds);
    }
}
