//! A link of whichever kind, and who talks to whom on it.

use std::time::Duration;

use tmcl_link::can::CanLink;
use tmcl_link::{Link, LinkError};
use tmcl_tables::GlobalParameter;

use crate::{CanIds, CanStream, Client, Settings};

/// What leads to a module.
pub enum AnyLink {
    /// Bytes.
    Bytes(Box<dyn Link>),
    /// Frames of a CAN bus.
    Can(CanStream<Box<dyn CanLink>>),
}

/// Who talks to whom: addresses from 0 to 255 where bytes travel, identifiers from 0 to 0x7FF on a CAN bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parties {
    /// The module: global parameter 66, on a CAN bus 71.
    pub module: u16,
    /// The host that it replies to: global parameter 76, on a CAN bus 70.
    pub host: u16,
}

impl Parties {
    /// `settings` with them; of identifiers the low bytes, which is what frames carry of them (TMCM-1311 §4.2).
    #[must_use]
    pub const fn within(self, settings: Settings) -> Settings {
        let (module_address, host_address) = (low_byte(self.module), low_byte(self.host));
        Settings { module_address, host_address, ..settings }
    }

    /// Both, as identifiers.
    #[must_use]
    pub const fn ids(self) -> CanIds {
        CanIds { module: Some(self.module), host: Some(self.host) }
    }
}

const fn low_byte(id: u16) -> u8 {
    id.to_le_bytes()[0]
}

impl AnyLink {
    /// Whether frames travel there, and no bytes.
    #[must_use]
    pub const fn is_can(&self) -> bool {
        matches!(self, Self::Can(_))
    }

    /// Says whose frames are meant; bytes carry their addresses themselves.
    ///
    /// # Errors
    /// [`LinkError`] when the bus is broken.
    pub fn turn_to(&mut self, parties: Parties) -> Result<(), LinkError> {
        match self {
            Self::Bytes(_) => Ok(()),
            Self::Can(stream) => stream.turn_to(parties.ids(), low_byte(parties.host)),
        }
    }

    fn as_link(&mut self) -> &mut dyn Link {
        match self {
            Self::Bytes(link) => link,
            Self::Can(stream) => stream,
        }
    }
}

impl Link for AnyLink {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.as_link().write(bytes)
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        self.as_link().read(buffer, timeout)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.as_link().discard_input()
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        self.as_link().wait(duration)
    }

    fn has_own_time(&self) -> bool {
        match self {
            Self::Bytes(link) => link.has_own_time(),
            Self::Can(stream) => stream.has_own_time(),
        }
    }
}

impl Client<AnyLink> {
    /// Who talks to whom.
    #[must_use]
    pub fn parties(&self) -> Parties {
        let settings = self.settings();
        let ids = match self.link() {
            AnyLink::Bytes(_) => CanIds::default(),
            AnyLink::Can(stream) => stream.ids(),
        };
        Parties {
            module: ids.module.unwrap_or(settings.module_address.into()),
            host: ids.host.unwrap_or(settings.host_address.into()),
        }
    }

    /// Talks to others from now on.
    ///
    /// # Errors
    /// [`LinkError`] when a CAN bus is broken.
    pub fn turn_to(&mut self, parties: Parties) -> Result<(), LinkError> {
        *self.settings_mut() = parties.within(self.settings());
        self.link_mut().turn_to(parties)
    }

    /// Goes on talking to a module that was told another address, or made to reply to another one: to be called when a
    /// parameter was written and the module has said yes, since that counts from the next request on (TMCM-1311 §10.1).
    /// Of other parameters, and those that mean nothing on this kind of link, it takes no notice.
    ///
    /// # Errors
    /// [`LinkError`] when a CAN bus is broken.
    pub fn follow(&mut self, parameter: GlobalParameter, value: i64) -> Result<(), LinkError> {
        let Ok(id) = u16::try_from(value) else { return Ok(()) };
        let Parties { module, host } = self.parties();
        let parties = match (parameter, self.link().is_can()) {
            (GlobalParameter::SerialAddress | GlobalParameter::HostAddress, false) if id > u8::MAX.into() => {
                return Ok(());
            }
            (GlobalParameter::SerialAddress, false) | (GlobalParameter::CanId, true) => {
                Parties { module: id, host }
            }
            (GlobalParameter::HostAddress, false) | (GlobalParameter::CanReplyId, true) => {
                Parties { module, host: id }
            }
            _ => return Ok(()),
        };
        self.turn_to(parties)
    }
}
