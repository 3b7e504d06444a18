//! A client for whatever is at an address.

use tmcl_link::{Carrier, Link, LinkAddress, LinkError, Speeds};

use crate::{CanIds, CanStream, Client, Settings};

/// What an address does not say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenOptions {
    /// Who talks to whom, and how patiently.
    pub settings: Settings,
    /// Speeds of the ways there.
    pub speeds: Speeds,
    /// Who is who on a CAN bus; nothing to anything else.
    pub can: CanIds,
}

/// A client for the module at `address`, over whatever leads there. Nothing is sent to the module yet.
///
/// # Errors
/// [`LinkError`] when the text is no address, or nothing can be opened there.
pub fn open(address: &str, options: OpenOptions) -> Result<Client<Box<dyn Link>>, LinkError> {
    let OpenOptions { settings, speeds, can } = options;
    let address: LinkAddress = address.parse()?;
    let link = match tmcl_link::open_with(address, speeds)? {
        Carrier::Bytes(link) => link,
        Carrier::Frames(bus) => Box::new(CanStream::new(bus, can, settings.host_address)?),
    };
    Ok(Client::with_settings(link, settings))
}
