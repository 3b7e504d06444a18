//! What the bench sets in a module before it is first switched on.

use tmcl_tables::GlobalParameter;

use crate::config::{Interface, ModuleConfig};

/// The module's address on RS485 and CAN, where the configuration has one, and the interface that it sits on; as far as the
/// module has such parameters.
pub(crate) fn presets(module: &ModuleConfig, interface: Option<Interface>) -> Vec<(GlobalParameter, i32)> {
    let spec = module.kind.spec();
    let address = module.address.map(i32::from);
    let interface = interface.map(|interface| match interface {
        Interface::Rs485 => 0,
        Interface::Can => 1,
    });
    let wanted = [
        (GlobalParameter::SerialAddress, address),
        (GlobalParameter::CanId, address),
        (GlobalParameter::InterfaceSelection, interface),
    ];
    let has = |parameter: GlobalParameter| {
        let (bank, number) = parameter.address();
        spec.global_parameter(bank, number).is_some()
    };
    let wanted = wanted.into_iter().filter(|(parameter, _)| has(*parameter));
    wanted.filter_map(|(parameter, value)| Some((parameter, value?))).collect()
}
