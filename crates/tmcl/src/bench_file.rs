//! Which bench a command runs on: a file's, or the default one of a module.

use std::path::Path;

use virtual_bench::{BenchConfig, config};

use crate::exit::{Code, Failure};
use crate::module_name::VirtualModule;

/// The bench of `file`, or the default one of `module`. The address on the command line beats the file's.
pub(crate) fn load(module: Option<VirtualModule>, file: Option<&Path>) -> Result<BenchConfig, Failure> {
    load_several(module.as_slice(), file)
}

/// The bench of `file`, or the default one with these modules. Addresses on the command line beat the file's.
pub(crate) fn load_several(modules: &[VirtualModule], file: Option<&Path>) -> Result<BenchConfig, Failure> {
    let mut config = match (file, modules) {
        (Some(file), modules) => agreeing(read(file)?, file, modules)?,
        (None, []) => {
            return Err(Failure::new(Code::Usage, "name a module, such as tmcm-1311, or a --bench file"));
        }
        (None, modules) => {
            let kinds: Vec<_> = modules.iter().map(|module| module.kind).collect();
            BenchConfig::default_of(&kinds)
        }
    };
    for (module, named) in config.modules.iter_mut().zip(modules) {
        module.address = named.address.or(module.address);
    }
    Ok(config)
}

fn read(file: &Path) -> Result<BenchConfig, Failure> {
    let name = file.display().to_string();
    let text = std::fs::read_to_string(file)
        .map_err(|error| Failure::new(Code::Usage, format!("cannot read the bench file {name}: {error}")))?;
    config::parse(&text).map_err(|errors| {
        let reports: Vec<_> = errors.iter().map(|error| error.report(&name, &text)).collect();
        let count = match reports.len() {
            1 => "an error".to_owned(),
            count => format!("{count} errors"),
        };
        Failure::new(Code::Usage, format!("{count} in the bench file\n\n{}", reports.join("\n")))
    })
}

/// Modules that are named beside a file have to be the file's, in its order; those behind them may be left out.
fn agreeing(config: BenchConfig, file: &Path, modules: &[VirtualModule]) -> Result<BenchConfig, Failure> {
    let file = file.display();
    let usage = |message| Err(Failure::new(Code::Usage, message));
    for (index, (found, named)) in config.modules.iter().zip(modules).enumerate() {
        if found.kind != named.kind {
            let which = match index {
                0 => "the first module".to_owned(),
                _ => format!("module {} ({})", index + 1, found.name),
            };
            let (named, found) = (named.kind.spec().id, found.kind.spec().id);
            return usage(format!("{which} in {file} is a {found}, not a {named}"));
        }
    }
    match config.modules.len() {
        count if count >= modules.len() => Ok(config),
        1 => usage(format!("there is one module in {file}, not {}", modules.len())),
        count => usage(format!("there are {count} modules in {file}, not {}", modules.len())),
    }
}
