use std::time::Duration;

use proptest::prelude::*;
use tmcl_client::{AnyLink, Client, Settings};
use tmcl_config::file::{self, Config, Header};
use tmcl_config::{Left, Wishes, items};
use tmcl_link::{Link, LinkError};
use tmcl_tables::Command;
use tmcl_wire::Request;
use tmcl_wire::serial::{decode_request, encode_request};
use virtual_bench::{Bench, BenchConfig, ModuleId, ModuleKind};

use super::*;
use crate::commands::dump::is_shown;
use crate::connection::AnyClient;
use crate::virtual_link::VirtualLink;

const ALL: Wishes = Wishes { connection: true };

fn client(kind: ModuleKind) -> AnyClient {
    let link = VirtualLink::new(Bench::new(&BenchConfig::default_for(kind)), ModuleId(0));
    let mut client = Client::new(AnyLink::Bytes(Box::new(link)));
    client.set_module(Some(kind.spec()));
    client
}

fn dump(client: &mut AnyClient, kind: ModuleKind) -> String {
    let module = kind.spec();
    let values = read_all(client, items(module).filter(|item| is_shown(*item))).expect("it answers");
    file::write(Header { module, firmware: module.firmware, writer: "tmcl" }, &values)
}

/// The module starts anew with the factory settings; it sends no reply.
fn factory_reset(client: &mut AnyClient) {
    client.send(Request::new(Command::FactoryReset, 0, 0, 1234)).expect("the link holds");
    client.link_mut().wait(Duration::from_secs(1)).expect("time passes");
    *client.settings_mut() = Settings::default();
}

fn parse(text: &str) -> Config {
    file::parse(text).unwrap_or_else(|findings| panic!("{findings:?}\n{text}"))
}

fn item(kind: ModuleKind, name: &str) -> Item {
    Name::parse(name, kind.spec()).expect("there is one").item
}

/// Every part of a configuration, but what would keep the module from answering or from being reset.
fn changeable(kind: ModuleKind) -> impl Iterator<Item = Item> {
    let kept = |item: &Item| !["suppress_reply", "eeprom_lock"].contains(&item.name().as_str());
    items(kind.spec()).filter(|item| item.is_configuration()).filter(kept)
}

/// A value that may be written, the same for the same seed.
fn legal(item: Item, seed: u64) -> i64 {
    let range = item.spec().map_or_else(|| item.range(), |spec| spec.write_range);
    let count = range.intervals.len() as u64;
    let (low, high) = range.intervals[(seed % count) as usize];
    let steps = (high - low) / range.step;
    low + ((seed / count) % (steps as u64 + 1)) as i64 * range.step
}

/// What came of it, where the connection holds.
fn apply(
    client: &mut AnyClient,
    config: &Config,
    wishes: Wishes,
    to_store: bool,
) -> Result<Progress, Failure> {
    let mut progress = Progress::default();
    super::apply(client, config, wishes, to_store, &mut progress).map(|()| progress)
}

#[test]
fn the_factory_settings_are_applied_without_a_write() {
    for kind in ModuleKind::ALL {
        let mut client = client(kind);
        let config = parse(&dump(&mut client, kind));
        assert_eq!(differences(&mut client, &config).expect("it answers"), []);
        let progress = apply(&mut client, &config, ALL, false).expect("it answers");
        assert!(progress.written.is_empty() && progress.refused.is_empty() && progress.mismatches.is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Change everything, dump, factory reset, apply, dump: the same text. What the module refuses is reported, not lost.
    #[test]
    fn a_configuration_survives_a_factory_reset(seeds in proptest::collection::vec(any::<u64>(), 256)) {
        for kind in ModuleKind::ALL {
            let mut client = client(kind);
            let factory = dump(&mut client, kind);
            for (item, seed) in changeable(kind).zip(&seeds) {
                write(&mut client, item, legal(item, *seed)).expect("the tables allow it");
            }
            let before = dump(&mut client, kind);
            factory_reset(&mut client);
            prop_assert_eq!(dump(&mut client, kind), factory);
            let progress = apply(&mut client, &parse(&before), ALL, false).expect("it answers");
            prop_assert!(progress.refused.is_empty(), "{:?}", progress.refused);
            prop_assert_eq!(&progress.mismatches, &[]);
            prop_assert_eq!(&progress.left, &[]);
            prop_assert_eq!(dump(&mut client, kind), before);
        }
    }
}

/// With `store` the settings are there after a restart, without it they are not.
#[test]
fn what_is_stored_survives_a_restart() {
    for (to_store, expected) in [(true, 40_000), (false, 51_200)] {
        let kind = ModuleKind::Tmcm1311;
        let mut client = client(kind);
        let text = "module = \"tmcm-1311\"\n[axis]\nmax_velocity = 40000\n[variable]\n3 = 7\n[global]\nauto_start = \"on\"";
        let progress = apply(&mut client, &parse(text), ALL, to_store).expect("it answers");
        assert_eq!((progress.stored, progress.written.len()), (if to_store { 2 } else { 0 }, 3));
        client.send(Request::new(Command::SoftwareReset, 0, 0, 1234)).expect("the link holds");
        client.link_mut().wait(Duration::from_secs(1)).expect("time passes");
        let value = |client: &mut AnyClient, name| read(client, item(kind, name)).expect("it answers");
        assert_eq!(value(&mut client, "max_velocity"), expected);
        assert_eq!(value(&mut client, "variable.3"), if to_store { 7 } else { 0 });
        // Bank 0 is stored by every write.
        assert_eq!(value(&mut client, "auto_start"), 1);
    }
}

#[test]
fn coordinates_are_stored_and_restored_on_demand() {
    let kind = ModuleKind::Tmcm1311;
    let mut client = client(kind);
    let coordinate = item(kind, "coordinate.3");
    assert_eq!(storage(item(kind, "coordinate.0")), Storage::None);
    write(&mut client, coordinate, 700).expect("it answers");
    store(&mut client, coordinate).expect("it answers");
    write(&mut client, coordinate, 9).expect("it answers");
    restore(&mut client, coordinate).expect("it answers");
    assert_eq!(read(&mut client, coordinate).expect("it answers"), 700);
}

/// The client goes on talking to a module with new addresses, and the lock comes after them.
#[test]
fn addresses_and_locks_come_last() {
    let kind = ModuleKind::Tmcm1311;
    let mut client = client(kind);
    let text = "module = \"tmcm-1311\"\n[axis]\nmax_velocity = 7\n[connection]\nserial_address = 9\nhost_address = 8\n\
                baud_rate = \"baud_115200\"\n[global]\neeprom_lock = \"locked\"\nauto_start = \"on\"\n";
    let left = apply(&mut client, &parse(text), Wishes::default(), false).expect("it answers").left;
    assert_eq!(left.iter().map(|(left, _)| *left).collect::<Vec<_>>(), [Left::Connection; 3]);
    // It is locked now: what is stored as it is written is refused, and said.
    let progress = apply(&mut client, &parse(text), ALL, true).expect("it answers");
    assert_eq!(progress.refused.len(), 4, "{:?}", progress.refused);
    let unlock = item(kind, "eeprom_lock");
    write(&mut client, unlock, 0).expect("it takes 4321");
    let progress = apply(&mut client, &parse(text), ALL, true).expect("it answers");
    assert!(progress.refused.is_empty() && progress.mismatches.is_empty(), "{progress:?}");
    assert_eq!((client.settings().module_address, client.settings().host_address), (9, 8));
    assert_eq!(read(&mut client, unlock).expect("it answers"), 1);
    // A file does not unlock.
    let unlocked = text.replace("\"locked\"", "\"unlocked\"");
    let progress = apply(&mut client, &parse(&unlocked), ALL, false).expect("it answers");
    assert_eq!(progress.left.iter().map(|(left, _)| *left).collect::<Vec<_>>(), [Left::Lock]);
}

/// AP 198 is a bit of AP 201: a file that says two different things cannot be right, and that is said.
#[test]
fn what_contradicts_itself_is_a_mismatch() {
    let kind = ModuleKind::Tmcm1311;
    let mut client = client(kind);
    let text = "module = \"tmcm-1311\"\n[axis]\nclear_on_null = 1\nencoder_mode = 16\n";
    let progress = apply(&mut client, &parse(text), ALL, false).expect("it answers");
    assert_eq!(progress.mismatches, [(item(kind, "clear_on_null"), 1, 0)]);
}

/// What is refused does not keep the rest from being written: the motor moves, and step/direction mode wants it at rest.
#[test]
fn what_is_refused_is_said_and_the_rest_is_written() {
    let kind = ModuleKind::Tmcm1311;
    let mut client = client(kind);
    client.rotate(1000).expect("it answers");
    client.link_mut().wait(Duration::from_millis(100)).expect("time passes");
    let text = "module = \"tmcm-1311\"\n[axis]\nstep_dir_mode = \"automatic\"\nmotor_full_steps = 400\n";
    let progress = apply(&mut client, &parse(text), ALL, false).expect("it answers");
    assert_eq!(progress.written.len(), 1);
    assert!(progress.mismatches.is_empty(), "{:?}", progress.mismatches);
    assert_eq!(
        progress.refused.iter().map(|(_, failure)| failure.code()).collect::<Vec<_>>(),
        [Code::TmclStatus]
    );
    assert_eq!(read(&mut client, item(kind, "motor_full_steps")).expect("it answers"), 400);
}

/// A module that takes AP 4 only after AP 202.
struct Picky<L> {
    link: L,
    willing: bool,
}

impl<L: Link> Link for Picky<L> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let (address, mut request) =
            decode_request(bytes.try_into().expect("a datagram")).expect("a good one");
        if request.command == Command::SetAxisParameter.number() {
            self.willing |= request.kind == 202;
            if request.kind == 4 && !self.willing {
                request.value = -1;
            }
        }
        self.link.write(&encode_request(address, request))
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        self.link.read(buffer, timeout)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.link.discard_input()
    }
}

/// One parameter may depend on another that comes later in the tables.
#[test]
fn what_is_refused_is_tried_once_more_after_the_others() {
    let kind = ModuleKind::Tmcm1311;
    let bench = VirtualLink::new(Bench::new(&BenchConfig::default_for(kind)), ModuleId(0));
    let link = Picky { link: bench, willing: false };
    let mut client = Client::new(AnyLink::Bytes(Box::new(link)));
    let text = "module = \"tmcm-1311\"\n[axis]\nmax_velocity = 7\nmotor_full_steps = 400\n";
    let progress = apply(&mut client, &parse(text), ALL, false).expect("it answers");
    let written: Vec<_> = progress.written.iter().map(|difference| difference.item.name()).collect();
    assert_eq!(written, ["motor_full_steps", "max_velocity"]);
    assert!(progress.refused.is_empty() && progress.mismatches.is_empty(), "{progress:?}");
}

/// A module that is told not to answer is not lost, and nothing is waited for.
#[test]
fn silence_comes_last_and_is_not_read_back() {
    let kind = ModuleKind::Tmcm1640;
    let mut client = client(kind);
    let text =
        "module = \"tmcm-1640\"\n[connection]\nsuppress_reply = 1\nserial_address = 3\n[variable]\n1 = 1\n";
    let progress = apply(&mut client, &parse(text), ALL, false).expect("it answers");
    assert_eq!(progress.written.len(), 3);
    let unheard: Vec<_> = progress.unheard.iter().map(|item| item.name()).collect();
    assert_eq!(unheard, ["serial_address", "suppress_reply"]);
}
