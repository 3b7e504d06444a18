//! What to type to drive the modules with PyTrinamic.

use std::fmt::Write as _;

use tmcl_tables::GlobalParameter;
use virtual_bench::config::Interface;
use virtual_bench::{Bench, BenchConfig, ModuleKind, Probe, Quantity};

/// Modules that are shown; who has more knows how it goes on.
const SHOWN: usize = 8;

/// What a client has to know of a module.
struct Module {
    /// Its class.
    class: String,
    /// What the bench calls it, as a variable.
    variable: String,
    address: i64,
    /// What moves the motor as the module comes.
    motion: &'static str,
}

/// What a client has to know of the modules at the ports, as far as PyTrinamic has classes for them.
pub(super) struct Advice {
    /// What the first one is called.
    pub(super) first: &'static str,
    modules: Vec<Module>,
}

impl Advice {
    /// For the modules as they are: an EEPROM may hold an address.
    pub(super) fn of(config: &BenchConfig, bench: &Bench) -> Self {
        let first = config.modules.first();
        let first = first.map_or(tmcl_tables::tmcm_1311::SPEC.name, |module| module.kind.spec().name);
        let address = match config.bus.interface {
            Some(Interface::Can) => GlobalParameter::CanId,
            Some(Interface::Rs485) | None => GlobalParameter::SerialAddress,
        };
        let (bank, number) = address.address();
        let modules = config.modules.iter().zip(bench.modules()).filter_map(|(module, id)| {
            let motion = match module.kind {
                ModuleKind::Tmcm1311 => "move_to(51200)",
                ModuleKind::Tmcm1640 => "rotate(1000)",
                // PyTrinamic has no class for it.
                ModuleKind::Tmcm1076 => return None,
            };
            Some(Module {
                class: module.kind.spec().name.replace('-', ""),
                variable: module.name.replace('-', "_"),
                address: bench.read(Probe { module: id, quantity: Quantity::Global(bank, number) }) as i64,
                motion,
            })
        });
        Self { first, modules: modules.collect() }
    }

    /// Says it on stderr. `options` go to the connection manager.
    pub(super) fn give(&self, interface: &str, port: &str, options: &str) {
        let text = match self.modules.as_slice() {
            [] => return,
            [module] => single(module, interface, port, options),
            several => bus(several, interface, port, options),
        };
        anstream::eprintln!("\nPyTrinamic (pip install pytrinamic):\n\n{text}");
    }
}

fn single(module: &Module, interface: &str, port: &str, options: &str) -> String {
    let Module { class, motion, address, .. } = module;
    let (option, argument) = match address {
        1 => (String::new(), String::new()),
        address => (format!(" --module-id {address}"), format!(", {address}")),
    };
    format!(
        "    from pytrinamic.connections import ConnectionManager\n    \
         from pytrinamic.modules import {class}\n    \
         connection = ConnectionManager(\"--interface {interface} --port {port}{options}{option}\").connect()\n    \
         motor = {class}(connection{argument}).motors[0]\n    motor.{motion}\n"
    )
}

fn bus(modules: &[Module], interface: &str, port: &str, options: &str) -> String {
    let shown = modules.get(..SHOWN).unwrap_or(modules);
    let mut classes: Vec<_> = shown.iter().map(|module| module.class.as_str()).collect();
    classes.sort_unstable();
    classes.dedup();
    let mut text = format!(
        "    from pytrinamic.connections import ConnectionManager\n    \
         from pytrinamic.modules import {}\n    \
         connection = ConnectionManager(\"--interface {interface} --port {port}{options}\").connect()\n",
        classes.join(", ")
    );
    for Module { class, variable, address, motion } in shown {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "    {variable} = {class}(connection, module_id={address}).motors[0]");
        let _ = writeln!(text, "    {variable}.{motion}");
    }
    if shown.len() < modules.len() {
        let _ = writeln!(text, "    # and so on, for {} modules", modules.len());
    }
    text
}
