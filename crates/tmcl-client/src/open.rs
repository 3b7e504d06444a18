//! A client for whatever is at an address.

use tmcl_link::{Carrier, LinkAddress, LinkError, Speeds};

use crate::{AnyLink, CanIds, CanStream, Client, Settings};

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

/// A way to the module at `address`, whatever it is, for bytes as a client speaks them. Nothing is sent to the module yet.
///
/// # Errors
/// [`LinkError`] when the text is no address, or nothing can be opened there.
pub fn open_link(address: &str, options: OpenOptions) -> Result<AnyLink, LinkError> {
    let address: LinkAddress = address.parse()?;
    Ok(match tmcl_link::open_with(address, options.speeds)? {
        Carrier::Bytes(link) => AnyLink::Bytes(link),
        Carrier::Frames(bus) => {
            AnyLink::Can(CanStream::new(bus, options.can, options.settings.host_address)?)
        }
    })
}

/// A client for the module at `address`, over whatever leads there. Nothing is sent to the module yet.
///
/// # Errors
/// As [`open_link`].
pub fn open(address: &str, options: OpenOptions) -> Result<Client<AnyLink>, LinkError> {
    Ok(Client::with_settings(open_link(address, options)?, options.settings))
}
