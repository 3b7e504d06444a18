//! Which module is this?

use std::fmt;

use tmcl_link::Link;
use tmcl_tables::{Command, MODULES, ModuleSpec};
use tmcl_wire::Request;

use crate::answer::Question;
use crate::{Client, ClientError};

/// Type of command 136: eight characters.
const AS_STRING: u8 = 0;

/// Type of command 136: a number in a normal reply.
const AS_NUMBER: u8 = 1;

/// Command 136, type 1.
pub(crate) const fn binary() -> Request {
    Request::new(Command::FirmwareVersion, AS_NUMBER, 0, 0)
}

/// Which module, and which firmware (TMCM-1311 §5.7.39).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FirmwareVersion {
    /// The number in the module's name, 1311.
    pub module: u16,
    /// The firmware's major version.
    pub major: u8,
    /// The firmware's minor version.
    pub minor: u8,
}

impl FirmwareVersion {
    /// The version that the value of a reply to command 136, type 1 stands for (decision: module number in the upper half).
    #[must_use]
    pub const fn from_value(value: i32) -> Self {
        let [high, low, major, minor] = value.to_be_bytes();
        Self { module: u16::from_be_bytes([high, low]), major, minor }
    }

    /// The module's tables, if it is one that we know. They may be of another firmware version:
    /// [`ModuleSpec::firmware`] tells.
    #[must_use]
    pub fn module_spec(self) -> Option<&'static ModuleSpec> {
        MODULES.iter().copied().find(|spec| spec.number == self.module)
    }
}

impl fmt::Display for FirmwareVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.module_spec() {
            Some(spec) => f.write_str(spec.name)?,
            None => write!(f, "module {}", self.module)?,
        }
        write!(f, " V{}.{:02}", self.major, self.minor)
    }
}

impl<L: Link> Client<L> {
    /// Asks which module this is, and remembers its tables ([`Client::module`]).
    ///
    /// # Errors
    /// As [`Client::request`].
    pub fn firmware_version(&mut self) -> Result<FirmwareVersion, ClientError> {
        let version = FirmwareVersion::from_value(self.execute(Command::FirmwareVersion, AS_NUMBER, 0, 0)?);
        self.set_module(version.module_spec());
        Ok(version)
    }

    /// Asks which module this is, in eight characters such as `1311V111`.
    ///
    /// The reply has no checksum; what is no letter or digit is taken for noise.
    ///
    /// # Errors
    /// As [`Client::request`].
    pub fn version_string(&mut self) -> Result<String, ClientError> {
        let request = Request::new(Command::FirmwareVersion, AS_STRING, 0, 0);
        let characters = self.exchange(request, Question::version_string)?;
        Ok(characters.iter().copied().map(char::from).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fake::{FakeModule, Fault};

    #[test]
    fn the_numbers_are_those_of_the_tables() {
        let type_of = |id: &str| {
            let types = Command::FirmwareVersion.spec().types;
            types.iter().find(|named| named.id == id).map(|named| named.value)
        };
        assert_eq!((type_of("string"), type_of("binary")), (Some(AS_STRING), Some(AS_NUMBER)));
    }

    #[test]
    fn known_modules_are_found_by_their_answer() {
        for spec in MODULES {
            let version = FirmwareVersion::from_value(spec.version_number());
            assert_eq!(version.module_spec(), Some(spec));
        }
        let version = FirmwareVersion::from_value(0x051F_010B);
        assert_eq!(version, FirmwareVersion { module: 1311, major: 1, minor: 11 });
        assert_eq!(version.to_string(), "TMCM-1311 V1.11");
        assert_eq!(FirmwareVersion::from_value(0x007B_0203).to_string(), "module 123 V2.03");
    }

    #[test]
    fn a_module_says_which_it_is() {
        let mut client = Client::new(FakeModule::default());
        assert_eq!(client.version_string().expect("it answers"), "1311V111");
        assert_eq!(client.module(), None);
        assert_eq!(client.firmware_version().expect("it answers").module, 1311);
        assert_eq!(client.module().map(|spec| spec.number), Some(1311));
    }

    /// The characters carry no checksum, but a reply that lost one is seen, and asked for again.
    #[test]
    fn a_version_string_survives_a_bad_line() {
        let faults = [Fault::DropByte(3), Fault::Noise(vec![0, 2, 255]), Fault::FlipBit(7)];
        for fault in faults {
            let mut client = Client::new(FakeModule::with_faults([fault.clone()]));
            assert_eq!(client.version_string().expect("it answers"), "1311V111", "{fault:?}");
        }
    }
}
