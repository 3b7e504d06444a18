//! Which ports this computer has.

use std::io;
use std::path::Path;

use serialport::{SerialPortInfo, SerialPortType};

use crate::{LinkAddress, LinkError};

/// A port that a module may be behind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// What the system calls it: `/dev/ttyACM0`, `COM3`, `can0`.
    pub name: String,
    /// What it is.
    pub kind: PortKind,
}

/// What a port is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortKind {
    /// A serial port on USB.
    Usb(UsbDevice),
    /// A serial port on the computer's board, or on a card in it.
    Pci,
    /// A serial port over Bluetooth.
    Bluetooth,
    /// A serial port of which the system does not say more.
    Serial,
    /// A CAN interface (Linux).
    Can,
}

/// What a USB device says about itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UsbDevice {
    /// The number of its vendor.
    pub vendor: u16,
    /// The number that the vendor gave the product.
    pub product: u16,
    /// Its serial number.
    pub serial_number: Option<String>,
    /// The vendor's name.
    pub manufacturer: Option<String>,
    /// The product's name.
    pub name: Option<String>,
}

impl Port {
    /// The address to open it with.
    #[must_use]
    pub fn address(&self) -> LinkAddress {
        match self.kind {
            PortKind::Can => LinkAddress::Can { interface: self.name.clone() },
            _ => LinkAddress::Serial { path: self.name.clone(), baud_rate: None },
        }
    }
}

/// The serial ports and CAN interfaces of this computer, in the order of their names. There may be more: pseudo terminals,
/// for instance, are not listed.
///
/// # Errors
/// [`LinkError::List`] when the system does not tell.
pub fn ports() -> Result<Vec<Port>, LinkError> {
    let mut ports = serial_ports()?;
    ports.extend(can_interfaces(Path::new("/sys/class/net")).map_err(|source| LinkError::List { source })?);
    ports.sort_by_cached_key(|port| natural_order(&port.name));
    Ok(ports)
}

fn serial_ports() -> Result<Vec<Port>, LinkError> {
    // The library panics on a Linux without it, as in some containers.
    if cfg!(target_os = "linux") && !Path::new("/sys/class/tty").is_dir() {
        return Ok(Vec::new());
    }
    let ports = serialport::available_ports().map_err(|error| LinkError::List { source: error.into() })?;
    Ok(ports.into_iter().map(serial_port).collect())
}

fn serial_port(info: SerialPortInfo) -> Port {
    let kind = match info.port_type {
        SerialPortType::UsbPort(usb) => PortKind::Usb(UsbDevice {
            vendor: usb.vid,
            product: usb.pid,
            serial_number: usb.serial_number,
            manufacturer: usb.manufacturer,
            name: usb.product,
        }),
        SerialPortType::PciPort => PortKind::Pci,
        SerialPortType::BluetoothPort => PortKind::Bluetooth,
        SerialPortType::Unknown => PortKind::Serial,
    };
    Port { name: info.port_name, kind }
}

/// What Linux calls the type of a CAN interface.
const CAN_TYPE: &str = "280";

/// The interfaces in a directory like `/sys/class/net`, a directory each, whose file `type` holds the number of a CAN.
fn can_interfaces(directory: &Path) -> io::Result<Vec<Port>> {
    if !directory.is_dir() {
        return Ok(Vec::new());
    }
    let mut ports = Vec::new();
    for entry in directory.read_dir()? {
        let entry = entry?;
        // An interface may have gone meanwhile.
        let kind = std::fs::read_to_string(entry.path().join("type")).unwrap_or_default();
        if kind.trim() == CAN_TYPE {
            ports.push(Port { name: entry.file_name().to_string_lossy().into_owned(), kind: PortKind::Can });
        }
    }
    Ok(ports)
}

/// `COM10` comes after `COM9`.
fn natural_order(name: &str) -> (String, u64, String) {
    let stem = name.trim_end_matches(|letter: char| letter.is_ascii_digit());
    let number = name.get(stem.len()..).unwrap_or_default().parse().unwrap_or(0);
    (stem.to_owned(), number, name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_computer_tells_and_its_ports_have_addresses() {
        for port in ports().expect("the system tells") {
            let address = port.address();
            assert_eq!(address.to_string().parse(), Ok(address));
        }
    }

    #[test]
    fn can_interfaces_are_told_from_others_by_their_type() {
        let directory = std::env::temp_dir().join(format!("opentmcl-net-{}", std::process::id()));
        for (name, kind) in [("can1", "280\n"), ("eth0", "1\n"), ("can0", "280\n")] {
            std::fs::create_dir_all(directory.join(name)).expect("a directory of ours");
            std::fs::write(directory.join(name).join("type"), kind).expect("a directory of ours");
        }
        let mut names: Vec<_> =
            can_interfaces(&directory).expect("it is there").into_iter().map(|port| port.name).collect();
        names.sort();
        std::fs::remove_dir_all(&directory).expect("a directory of ours");
        assert_eq!(names, ["can0", "can1"]);
        assert_eq!(can_interfaces(&directory).expect("nothing is no error"), []);
    }

    #[test]
    fn numbers_are_in_the_order_of_numbers() {
        let mut names = ["COM10", "can0", "COM9", "/dev/ttyS0", "/dev/ttyACM1"];
        names.sort_by_cached_key(|name| natural_order(name));
        assert_eq!(names, ["/dev/ttyACM1", "/dev/ttyS0", "COM9", "COM10", "can0"]);
    }

    #[test]
    fn what_usb_says_is_passed_on() {
        let usb = serialport::UsbPortInfo {
            vid: 0x2A3C,
            pid: 0x0100,
            serial_number: Some("TMCSTEP".to_owned()),
            manufacturer: None,
            product: Some("TMCM-1311".to_owned()),
        };
        let info = SerialPortInfo { port_name: "COM3".to_owned(), port_type: SerialPortType::UsbPort(usb) };
        let port = serial_port(info);
        assert_eq!(port.address(), LinkAddress::Serial { path: "COM3".to_owned(), baud_rate: None });
        let PortKind::Usb(device) = port.kind else { panic!("{port:?}") };
        assert_eq!((device.vendor, device.product), (0x2A3C, 0x0100));
        assert_eq!(
            (device.serial_number.as_deref(), device.name.as_deref()),
            (Some("TMCSTEP"), Some("TMCM-1311"))
        );
    }
}
