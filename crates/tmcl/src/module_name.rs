//! Module names on the command line: `tmcm-1311`, `1311`, `tmcm-1311@5`.

use tmcl_tables::{MODULES, ModuleSpec, module_by_id};
use virtual_bench::ModuleKind;

/// Why a name names nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NameError {
    /// No such module.
    #[error("no such module; there are {0}")]
    Module(String),
    /// A module that the tables know, but that there is no virtual one of.
    #[error("there is no virtual one yet; there are {0}")]
    NotVirtual(String),
    /// An address for a module whose address is fixed.
    #[error("the address of a {0} is 1 and cannot be changed")]
    FixedAddress(&'static str),
    /// The part behind the `@`.
    #[error("the address behind the @ is a number from 0 to 255, not `{0}`")]
    Address(String),
}

/// A virtual module as the command line names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct VirtualModule {
    /// What it is.
    pub(crate) kind: ModuleKind,
    /// Its serial address, where one is given; it beats the bench file, and that the EEPROM.
    pub(crate) address: Option<u8>,
}

/// A module that the tables know.
pub(crate) fn spec(name: &str) -> Result<&'static ModuleSpec, NameError> {
    module_by_id(name).map_err(|_| NameError::Module(list(MODULES.iter().map(|spec| spec.id))))
}

/// A virtual module, with its address where one is given.
pub(crate) fn setup(name: &str) -> Result<VirtualModule, NameError> {
    let (name, address) = name.split_once('@').map_or((name, None), |(name, address)| (name, Some(address)));
    let kind = ModuleKind::try_from(spec(name)?).map_err(|_| NameError::NotVirtual(virtual_modules()))?;
    let address =
        address.map(|text| text.parse().map_err(|_| NameError::Address(text.to_owned()))).transpose()?;
    if address.is_some_and(|address| address != 1) && !kind.has_settable_address() {
        return Err(NameError::FixedAddress(kind.spec().name));
    }
    Ok(VirtualModule { kind, address })
}

/// The modules that there are virtual ones of.
pub(crate) fn virtual_modules() -> String {
    list(ModuleKind::ALL.iter().map(|kind| kind.spec().id))
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_stands_behind_an_at_sign() {
        let kind = ModuleKind::Tmcm1311;
        assert_eq!(setup("tmcm-1311"), Ok(VirtualModule { kind, address: None }));
        assert_eq!(setup("TMCM-1311@7"), Ok(VirtualModule { kind, address: Some(7) }));
        assert_eq!(setup("1311@256"), Err(NameError::Address("256".to_owned())));
        assert_eq!(setup("tmcm-1640"), Ok(VirtualModule { kind: ModuleKind::Tmcm1640, address: None }));
        assert_eq!(setup("1076@1"), Ok(VirtualModule { kind: ModuleKind::Tmcm1076, address: Some(1) }));
        assert_eq!(setup("1076@2"), Err(NameError::FixedAddress("TMCM-1076")));
        assert!(matches!(setup("tmcm-1312"), Err(NameError::Module(_))));
    }
}
