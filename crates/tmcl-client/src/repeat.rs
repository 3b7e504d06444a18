//! Which requests may be sent again when it is not known whether they were executed.

use tmcl_tables::{Command, CommandSpec, Group, MODULES, ModuleSpec, MotorField, TypeField};
use tmcl_wire::Request;

/// Whether doing `request` twice is the same as once, by the tables of `module`; of every module when it is not known which
/// one this is. A module that is downloading stores all but a host's commands, one after the other, so that none of those
/// may be repeated.
pub(crate) fn is_repeat_safe(module: Option<&ModuleSpec>, request: Request, downloading: bool) -> bool {
    let Ok(spec) = Command::try_from(request.command).map(Command::spec) else { return false };
    if !spec.repeat_safe || (downloading && spec.group != Group::Host) {
        return false;
    }
    match module {
        Some(module) => parameter_is_safe(module, spec, request),
        None => MODULES.iter().all(|module| parameter_is_safe(module, spec, request)),
    }
}

/// A parameter that the module does not have does nothing, however often it is asked for.
fn parameter_is_safe(module: &ModuleSpec, spec: &CommandSpec, request: Request) -> bool {
    match (spec.type_field, spec.motor_field) {
        (TypeField::AxisParameter, _) => {
            module.axis_parameter(request.kind).is_none_or(|parameter| parameter.repeat_safe)
        }
        (TypeField::GlobalParameter, MotorField::Bank) => module
            .global_parameter(request.motor, request.kind)
            .is_none_or(|global| global.parameter.repeat_safe),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use tmcl_tables::{tmcm_1311, tmcm_1640};

    use super::*;

    fn safe(module: Option<&ModuleSpec>, command: Command, kind: u8, motor: u8) -> bool {
        is_repeat_safe(module, Request::new(command, kind, motor, 1), false)
    }

    #[test]
    fn what_counts_up_is_not_repeated() {
        use Command::{
            Calculate, DownloadStart, GetAxisParameter, MotorStop, MoveToPosition, ReadProgramMemory,
            SetAxisParameter,
        };
        let module = Some(&tmcm_1311::SPEC);
        for command in [GetAxisParameter, SetAxisParameter, MotorStop, ReadProgramMemory] {
            assert!(safe(module, command, 0, 0), "{command:?}");
        }
        for command in [MoveToPosition, Calculate, DownloadStart] {
            assert!(!safe(module, command, 0, 0), "{command:?}");
        }
        assert!(!is_repeat_safe(module, Request { command: 200, ..Request::default() }, false));
    }

    #[test]
    fn some_parameters_are_not_repeated() {
        use Command::{GetAxisParameter, GetGlobalParameter, SetAxisParameter};
        let stepper = Some(&tmcm_1311::SPEC);
        // 132 starts the encoder's initialization; global parameter 133 of bank 0 is a random number, of bank 2 nothing.
        assert!(!safe(stepper, SetAxisParameter, 132, 0));
        assert!(safe(stepper, GetGlobalParameter, 133, 2));
        assert!(!safe(stepper, GetGlobalParameter, 133, 0));
        // On the other module 132 is something else.
        assert!(safe(Some(&tmcm_1640::SPEC), GetAxisParameter, 132, 0));
        // Nobody knows which module: caution.
        assert!(!safe(None, GetAxisParameter, 132, 0));
        assert!(safe(None, GetAxisParameter, 1, 0));
    }

    #[test]
    fn nothing_is_stored_twice_by_a_download() {
        let get = Request::new(Command::GetAxisParameter, 1, 0, 0);
        let version = Request::new(Command::FirmwareVersion, 1, 0, 0);
        assert!(!is_repeat_safe(None, get, true));
        assert!(is_repeat_safe(None, version, true));
    }
}
