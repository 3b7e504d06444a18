//! Which pins a module offers to wires, levels and events, and how they are called.

use super::switches::SwitchesConfig;
use crate::ModuleKind;
use bench_hardware::SwitchName;

/// What a module's pins are, by their port numbers.
pub(super) struct Pins {
    /// Digital inputs: `in_1` in a file's `[module.inputs]`, `input.1` elsewhere.
    pub(super) inputs: &'static [u8],
    /// Their names as keys.
    pub(super) input_keys: &'static [&'static str],
    /// Analogue inputs: `ain_0`, `ain.0`.
    pub(super) analog: &'static [u8],
    /// Their names as keys.
    pub(super) analog_keys: &'static [&'static str],
    /// Outputs: `output.0`.
    pub(super) outputs: &'static [u8],
    /// The switches that are wired to digital inputs, and to which.
    pub(super) switches: &'static [(SwitchName, u8)],
}

/// Full scale of an analogue input (TMCM-1311 §5.7.15.2: 12 bits).
pub(super) const ANALOG_MAX: u16 = 4095;

/// The pins of a module. IN_0 and IN_4 of the TMCM-1311 are AIN_0 and AIN_4 read as digital inputs (§5.7.15.1): they have no
/// level of their own. The TMCM-1640's stop switches are IN_0 and IN_1 (TMCM-1640 §3.1). The
/// TMCM-1076's inputs are CHOP and ENABLE (TMCM-1076 §3.5.5).
pub(super) const fn of(kind: ModuleKind) -> &'static Pins {
    match kind {
        ModuleKind::Tmcm1311 => &Pins {
            inputs: &[1, 2, 3, 5, 6, 7],
            input_keys: &["in_1", "in_2", "in_3", "in_5", "in_6", "in_7"],
            analog: &[0, 4],
            analog_keys: &["ain_0", "ain_4"],
            outputs: &[0, 1, 2, 3, 4, 5, 6, 7],
            switches: &[(SwitchName::Home, 1)],
        },
        ModuleKind::Tmcm1640 => &Pins {
            inputs: &[0, 1],
            input_keys: &["in_0", "in_1"],
            analog: &[0],
            analog_keys: &["ain_0"],
            outputs: &[0],
            switches: &[(SwitchName::Right, 0), (SwitchName::Left, 1)],
        },
        ModuleKind::Tmcm1076 => &Pins {
            inputs: &[0, 1],
            input_keys: &["in_0", "in_1"],
            analog: &[],
            analog_keys: &[],
            outputs: &[],
            switches: &[],
        },
    }
}

/// The switch that drives an input of a module, if there is one.
pub(super) fn switch_at(kind: ModuleKind, switches: &SwitchesConfig, input: u8) -> Option<SwitchName> {
    let wired = of(kind).switches.iter().find(|(_, number)| *number == input);
    wired.map(|(name, _)| *name).filter(|name| switches.get(*name).is_some())
}

/// `input.1, input.2 and so on` of a list of numbers.
pub(super) fn names(word: &str, numbers: &[u8]) -> String {
    let names: Vec<String> = numbers.iter().map(|number| format!("{word}.{number}")).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use tmcl_tables::Direction;

    #[test]
    fn every_pin_is_in_the_tables() {
        for kind in ModuleKind::ALL {
            let pins = of(kind);
            let banks = [
                (0, pins.inputs, pins.input_keys, Direction::Input),
                (1, pins.analog, pins.analog_keys, Direction::Input),
            ];
            for (bank, numbers, keys, direction) in banks {
                assert_eq!(numbers.len(), keys.len());
                for (number, key) in numbers.iter().zip(keys) {
                    let port = kind.spec().port(bank, *number).expect("a port of the tables");
                    assert_eq!((port.id, port.direction), (*key, direction));
                }
            }
            for number in pins.outputs {
                let port = kind.spec().port(2, *number).expect("a port of the tables");
                assert_eq!(port.direction, Direction::Output);
            }
            assert!(pins.switches.iter().all(|(_, input)| pins.inputs.contains(input)));
        }
    }
}
