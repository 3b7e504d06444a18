use proptest::prelude::*;

use super::*;

fn tcp(host: &str, port: u16) -> Result<LinkAddress, AddressError> {
    Ok(LinkAddress::Tcp { host: host.to_owned(), port })
}

fn serial(path: &str, baud_rate: impl Into<Option<u32>>) -> Result<LinkAddress, AddressError> {
    Ok(LinkAddress::Serial { path: path.to_owned(), baud_rate: baud_rate.into() })
}

fn slcan(path: &str, bit_rate: impl Into<Option<BitRate>>) -> Result<LinkAddress, AddressError> {
    Ok(LinkAddress::Slcan { path: path.to_owned(), bit_rate: bit_rate.into() })
}

#[test]
fn sockets() {
    assert_eq!("tcp:localhost:4000".parse(), tcp("localhost", 4000));
    assert_eq!("tcp://localhost:4000".parse(), tcp("localhost", 4000));
    assert_eq!("127.0.0.1:4000".parse(), tcp("127.0.0.1", 4000));
    assert_eq!("TCP:[::1]:4000".parse(), tcp("::1", 4000));
    // A host may have the name of a port.
    assert_eq!("com3:4000".parse(), tcp("com3", 4000));
    assert_eq!("tcp:com3:4000".parse(), tcp("com3", 4000));
}

#[test]
fn serial_ports() {
    assert_eq!("/dev/ttyACM0".parse(), serial("/dev/ttyACM0", None));
    assert_eq!("serial:/dev/ttyACM0@115200".parse(), serial("/dev/ttyACM0", 115_200));
    assert_eq!("./module".parse(), serial("./module", None));
    assert_eq!("serial:module".parse(), serial("module", None));
    assert_eq!("COM3".parse(), serial("COM3", None));
    assert_eq!("com12@250000".parse(), serial("com12", 250_000));
    assert_eq!(r"\\.\COM10".parse(), serial(r"\\.\COM10", None));
    assert_eq!("serial:///dev/ttyS0@9600".parse(), serial("/dev/ttyS0", 9600));
    assert_eq!("/dev/odd@name@9600".parse(), serial("/dev/odd@name", 9600));
    assert_eq!("/tmp/a:1".parse(), serial("/tmp/a:1", None));
}

#[test]
fn can_buses() {
    assert_eq!("slcan:///dev/ttyACM0".parse(), slcan("/dev/ttyACM0", None));
    assert_eq!("slcan:/dev/ttyACM0@500000".parse(), slcan("/dev/ttyACM0", BitRate::Kbit500));
    assert_eq!("slcan:COM5@1000000".parse(), slcan("COM5", BitRate::Kbit1000));
    for text in ["can://can0", "can:can0", "CAN:can0"] {
        assert_eq!(text.parse(), Ok(LinkAddress::Can { interface: "can0".to_owned() }));
    }
}

#[test]
fn what_the_address_leaves_open_the_caller_says() {
    let with = |text: &str, speeds| {
        text.parse::<LinkAddress>().map(|address| address.with_speeds(speeds).to_string())
    };
    let speeds = Speeds { baud_rate: Some(115_200), can_bit_rate: Some(BitRate::Kbit250) };
    assert_eq!(with("/dev/a", Speeds::default()), Ok("serial:/dev/a@9600".to_owned()));
    assert_eq!(with("/dev/a", speeds), Ok("serial:/dev/a@115200".to_owned()));
    assert_eq!(with("/dev/a@19200", speeds), Ok("serial:/dev/a@19200".to_owned()));
    assert_eq!(with("slcan:/dev/a", Speeds::default()), Ok("slcan:/dev/a@1000000".to_owned()));
    assert_eq!(with("slcan:/dev/a", speeds), Ok("slcan:/dev/a@250000".to_owned()));
    assert_eq!(with("slcan:/dev/a@10000", speeds), Ok("slcan:/dev/a@10000".to_owned()));
    assert_eq!(with("can:can0", speeds), Ok("can:can0".to_owned()));
}

#[test]
fn errors_say_what_is_wrong() {
    let error = |text: &str| text.parse::<LinkAddress>().expect_err("no address").to_string();
    assert_eq!(
        error("module"),
        "\"module\" is no address of a module: write tcp://HOST:PORT, /dev/ttyACM0, /dev/ttyUSB0@115200, COM3, \
         slcan:///dev/ttyACM0 or can://can0"
    );
    assert_eq!(
        error("localhost:"),
        "\"\" in \"localhost:\" is no TCP port: write HOST:PORT with a port from 1 to 65535"
    );
    assert_eq!(
        error("/dev/ttyACM0@fast"),
        "\"fast\" in \"/dev/ttyACM0@fast\" is no baud rate: write a number such as 9600 or 115200 after the @"
    );
    assert_eq!(
        error("slcan:/dev/ttyACM0@9600"),
        "\"9600\" in \"slcan:/dev/ttyACM0@9600\" is no bit rate of a CAN bus: write 10000, 20000, 50000, 100000, \
         125000, 250000, 500000, 800000 or 1000000 after the @"
    );
    assert_eq!(
        error("can:/dev/can0"),
        "\"/dev/can0\" in \"can:/dev/can0\" is no CAN interface: write its name, up to 15 characters, as in can://can0"
    );
    let all = [
        "",
        "tcp:",
        "tcp:////:1",
        ":1",
        "[]:1",
        "[::1:4",
        "::1:4",
        "a:0",
        "a:65536",
        "serial:",
        "serial:@1",
        "COM",
        "COM1@0",
        "slcan:",
        "slcan://",
        "slcan:@10000",
        "can:",
        "can://",
        "can:..",
        "can:a b",
        "can:sixteen_letters_",
    ];
    for text in all {
        assert!(text.parse::<LinkAddress>().is_err(), "{text}");
    }
}

proptest! {
    /// What is printed can be typed.
    #[test]
    fn every_address_survives_being_printed(text: String) {
        if let Ok(address) = text.parse::<LinkAddress>() {
            prop_assert_eq!(address.to_string().parse(), Ok(address));
        }
    }

    #[test]
    fn so_do_likely_ones(text in "(tcp:|serial:|slcan:|can:)?/{0,4}[a-z/@:0-9\\[\\]]{0,12}[@:]?[0-9]{0,5}") {
        if let Ok(address) = text.parse::<LinkAddress>() {
            prop_assert_eq!(address.to_string().parse(), Ok(address));
        }
    }
}
