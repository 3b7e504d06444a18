//! `tmcl ports`: where a module may be plugged in.

use clap::Args;
use serde::Serialize;
use tmcl_link::{Port, PortKind, UsbDevice};

use crate::exit::{Code, Failure, Outcome};
use crate::print;

/// `tmcl ports`.
#[derive(Args)]
#[command(
    after_help = "The serial ports and CAN interfaces of this computer, as --port takes them. A CAN adapter that speaks slcan is \
    listed as the serial port it is: name it as slcan:///dev/ttyACM0."
)]
pub(crate) struct Ports {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A port for machines.
#[derive(Serialize)]
struct Row {
    /// What `--port` takes.
    port: String,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    vendor: Option<u16>,
    #[serde(skip_serializing_if = "Option::is_none")]
    product: Option<u16>,
    description: String,
}

/// Lists them.
pub(crate) fn run(options: &Ports) -> Outcome {
    let ports = tmcl_link::ports().map_err(|error| Failure::new(Code::Connection, error.to_string()))?;
    let rows: Vec<Row> = ports.iter().map(row).collect();
    if options.json {
        return Ok(print::json(&rows)?);
    }
    if rows.is_empty() {
        print::note("this computer has no serial ports and no CAN interfaces");
        return Ok(());
    }
    let cells = |row: &Row| {
        let ids = row.vendor.zip(row.product).map(|(vendor, product)| format!("{vendor:04x}:{product:04x}"));
        [row.port.clone(), row.kind.to_owned(), ids.unwrap_or_default(), row.description.clone()]
    };
    Ok(print::listing(["port", "kind", "usb", "description"], rows.iter().map(cells))?)
}

fn row(port: &Port) -> Row {
    let (kind, usb) = match &port.kind {
        PortKind::Usb(device) => ("usb", Some(device)),
        PortKind::Pci => ("pci", None),
        PortKind::Bluetooth => ("bluetooth", None),
        PortKind::Serial => ("serial", None),
        PortKind::Can => ("can", None),
    };
    Row {
        port: if port.kind == PortKind::Can { format!("can://{}", port.name) } else { port.name.clone() },
        kind,
        vendor: usb.map(|device| device.vendor),
        product: usb.map(|device| device.product),
        description: usb.map_or_else(String::new, description),
    }
}

/// What the device says of itself.
fn description(device: &UsbDevice) -> String {
    let number = device.serial_number.as_ref().map(|number| format!("serial number {number}"));
    let parts = [device.manufacturer.clone(), device.name.clone(), number];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_named_as_they_are_opened() {
        let device = UsbDevice {
            vendor: 0x2a3c,
            product: 0x0100,
            serial_number: Some("7".to_owned()),
            manufacturer: Some("Trinamic".to_owned()),
            name: None,
        };
        let usb = row(&Port { name: "/dev/ttyACM0".to_owned(), kind: PortKind::Usb(device) });
        assert_eq!((usb.port.as_str(), usb.kind), ("/dev/ttyACM0", "usb"));
        assert_eq!(usb.description, "Trinamic, serial number 7");
        let can = row(&Port { name: "can0".to_owned(), kind: PortKind::Can });
        assert_eq!((can.port.as_str(), can.kind), ("can://can0", "can"));
    }
}
